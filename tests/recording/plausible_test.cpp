// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <functional>

#include "palpate/core/error.hpp"
#include "palpate/recording/json_text.hpp"
#include "palpate/recording/writer.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::recording {
namespace {

/// The message with which a recording is refused, when it is written or read; empty if it is not.
std::string refusal(const std::function<void(Recording&)>& change) {
  const TestFolder folder;
  Recording recording = toy_recording(9);
  change(recording);
  try {
    write_recording(folder / "toy.h5", recording);
    read_recording(folder / "toy.h5");
    return "";
  } catch (const BadInput& error) {
    return error.what();
  }
}

std::vector<hand::TipContact>& some_contacts(Recording& r) {
  for (auto& frame : r.frames) {
    for (auto& finger : frame.reading.contacts) {
      if (!finger.empty()) return finger;
    }
  }
  throw std::logic_error("the toy has no contacts");
}

TEST(PlausibleRecordingTest, WhatCannotBeIsRefusedThoughItIsFinite) {
  EXPECT_EQ(refusal([](Recording&) {}), "");
  const std::vector<std::function<void(Recording&)>> changes = {
      [](Recording& r) { some_contacts(r)[0].f.x() = 1e200; },
      [](Recording& r) { some_contacts(r)[0].p.y() = -1e9; },
      [](Recording& r) { some_contacts(r)[0].n *= 2; },
      [](Recording& r) { r.frames[4].reading.mount_force.z() = 1e200; },
      [](Recording& r) { r.frames[4].reading.joints[2] = 1e200; },
      [](Recording& r) { r.frames[4].reading.time = -1e300; },
      [](Recording& r) { r.frames[4].truth->T_world_object.linear() *= 3; },
      [](Recording& r) { r.frames[4].truth->T_world_object.matrix()(3, 0) = 1; },
      [](Recording& r) { r.header.hand.fingers[1].tip.radius = -1; },
      [](Recording& r) { r.header.hand.spheres[1].radius = -1; },
      [](Recording& r) { r.header.hand.links[1].T_parent_link.linear() *= -1; },
      [](Recording& r) { r.header.hand.links[1].axis *= 2; },
      [](Recording& r) { r.header.hand.kinematic_error = 1e200; },
      [](Recording& r) { r.header.object.mass = -0.1; },
      [](Recording& r) { r.header.object.mass_properties.volume = 1e200; },
      [](Recording& r) { r.header.object.stable_poses[0].probability = 7; },
      [](Recording& r) { r.header.object.symmetries[1] *= 2; },
      [](Recording& r) { r.header.object.mesh.vertices[3].x() = 1e200; },
      [](Recording& r) { r.estimates[0].modes[0].weight = 1e6; },
      [](Recording& r) { r.estimates[0].modes[0].T_world_object.linear() *= 2; },
      [](Recording& r) { r.estimates[0].contacts[0].f.x() = 1e200; },
      [](Recording& r) { r.estimates[0].contacts[0].finger = 1000000; },
      [](Recording& r) { r.estimates[0].contacts[0].point_sigma = -1; },
      [](Recording& r) { r.events[0].phase = "../../lift"; },
  };
  for (std::size_t i = 0; i < changes.size(); ++i) EXPECT_NE(refusal(changes[i]), "") << i;
}

TEST(JsonText, OfAnyDepthIsRefusedAndNotFollowed) {
  const auto nested = [](int depth, char open, char close) {
    const auto size = static_cast<std::size_t>(depth);
    return std::string(size, open) + std::string(open == '[' ? size : 0, close);
  };
  EXPECT_EQ(parse_json(nested(kMaxJsonDepth, '[', ']')).size(), 1u);
  EXPECT_THROW(parse_json(nested(kMaxJsonDepth + 1, '[', ']')), BadInput);
  EXPECT_THROW(parse_json(nested(1000000, '[', ']')), BadInput);
  std::string objects;
  for (int i = 0; i < 100000; ++i) objects += "{\"a\":";
  EXPECT_THROW(parse_json(objects), BadInput);
  EXPECT_THROW(parse_json("{\"a\": 1"), BadInput);
}

TEST(JsonText, IsShownInAFewCharacters) {
  EXPECT_EQ(shown(nlohmann::json("ab")), "\"ab\"");
  EXPECT_LE(shown(nlohmann::json(std::string(100000, 'x'))).size(), 70u);
}

}  // namespace
}  // namespace palpate::recording
