// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>

namespace palpate::bridge {

/// Tests on the loopback alone, in a domain of the process's own.
class DdsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    setenv("CYCLONEDDS_URI",
           "<CycloneDDS><Domain><General><AllowMulticast>false</AllowMulticast><Interfaces>"
           "<NetworkInterface name=\"lo\" multicast=\"false\"/></Interfaces></General><Discovery>"
           "<ParticipantIndex>auto</ParticipantIndex>"
           "<MaxAutoParticipantIndex>60</MaxAutoParticipantIndex>"
           "<Peers><Peer address=\"127.0.0.1\"/></Peers></Discovery></Domain></CycloneDDS>",
           1);
  }
  const int domain_ = 1 + static_cast<int>(getpid() % 200);
};

}  // namespace palpate::bridge
