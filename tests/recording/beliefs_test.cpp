// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/recording/recording.hpp"
#include "palpate/recording/writer.hpp"
#include "recording/same_recording.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::recording {
namespace {

TEST(Beliefs, BeliefsComeBackAndBadOnesAreRefused) {
  const TestFolder folder;
  Recording written = toy_recording(3);
  const Eigen::Isometry3d T(Eigen::Translation3d(0.1, 0.2, 0.3));
  written.beliefs = {{.time = 0, .source = "prior", .in_hand = false, .poses = {}},
                     {.time = 0.02, .source = "online", .in_hand = true, .poses = {{0.75, T}}}};
  write_recording(folder / "toy.h5", written);
  const Recording read = read_recording(folder / "toy.h5");
  ASSERT_EQ(read.beliefs.size(), 2u);
  EXPECT_TRUE(read.beliefs[0].poses.empty());
  EXPECT_EQ(read.beliefs[1].time, 0.02);
  EXPECT_EQ(read.beliefs[1].source, "online");
  EXPECT_TRUE(read.beliefs[1].in_hand);
  ASSERT_EQ(read.beliefs[1].poses.size(), 1u);
  EXPECT_EQ(read.beliefs[1].poses[0].probability, 0.75);
  EXPECT_EQ(read.beliefs[1].poses[0].T_world_object.matrix(), T.matrix());
  for (const double bad : {std::nan(""), -0.1, 1.5}) {
    written.beliefs[1].poses[0].probability = bad;
    EXPECT_THROW(write_recording(folder / "bad.h5", written), BadInput) << bad;
  }
}

}  // namespace
}  // namespace palpate::recording
