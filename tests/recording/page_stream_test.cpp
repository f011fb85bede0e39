// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/page_stream.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/recording/replay_page.hpp"

namespace palpate::recording {
namespace {

using nlohmann::json;

RecordingHeader header() {
  return {"1.2.3", 7, geometry::load_known_object("box"), hand::shadow_hand(), "", false};
}

Frame frame_at(const RecordingHeader& header, double time) {
  Frame frame;
  frame.reading.time = time;
  frame.reading.joints.setZero(header.hand.joint_count());
  frame.reading.contacts.resize(header.hand.fingers.size());
  frame.truth = FrameTruth{Eigen::Isometry3d(Eigen::Translation3d(0, 0, time)), {}};
  return frame;
}

/// A stream and the messages that it has sent.
struct Sent {
  std::vector<json> messages;
  PageStream stream{header(), [this](const std::string& text) {
                      EXPECT_EQ(text.find('\n'), std::string::npos);
                      messages.push_back(json::parse(text));
                    }};

  std::vector<json> of(const char* kind) const {
    std::vector<json> found;
    for (const auto& message : messages) {
      if (message.contains(kind)) found.push_back(message[kind]);
    }
    return found;
  }
};

TEST(PageStream, ThinsFramesAndNothingElse) {
  Sent sent;
  const RecordingHeader known = header();
  for (int i = 0; i <= 100; ++i) sent.stream.frame(frame_at(known, 0.01 * i));
  EXPECT_EQ(sent.of("frames").size(), 21u);
  for (int i = 0; i < 3; ++i) sent.stream.event({1.0, EventKind::begin, "lift", ""});
  EXPECT_EQ(sent.of("story").size(), 3u);
  EXPECT_EQ(sent.of("story").back()["phases"].size(), 3u);
}

TEST(PageStream, FramesAfterAStepBackInTimeAreSent) {
  Sent sent;
  sent.stream.frame(frame_at(header(), 5));
  sent.stream.frame(frame_at(header(), 1));
  EXPECT_EQ(sent.of("frames").size(), 2u);
}

TEST(PageStream, AFrameInWhichAnotherFingerTouchesIsSent) {
  RecordingHeader touching = header();
  touching.hand.links.resize(1);
  for (auto& finger : touching.hand.fingers) finger.link = 0;
  std::vector<json> frames;
  PageStream stream(
      touching, [&](const std::string& text) { frames.push_back(json::parse(text)["frames"]); });
  for (int i = 0; i <= 100; ++i) {
    Frame frame = frame_at(touching, 0.01 * i);
    if (i == 42) frame.reading.contacts[1].emplace_back();
    if (i == 42 || i == 43) frame.reading.contacts[2].emplace_back();
    stream.frame(frame);
  }
  EXPECT_EQ(frames.size(), 22u);
  EXPECT_EQ(
      std::ranges::count(frames, "AgAAAA==", [](const json& f) { return f["contact_counts"]; }),
      1);  // two contacts in the only frame
}

TEST(PageStream, TimesCountFromTheWholeSecondBeforeTheFirstFrame) {
  constexpr double kSince1970 = 1.764e9;  // s
  const RecordingHeader known = header();
  Sent sent;
  sent.stream.belief({.time = 0, .source = "prior", .in_hand = false, .poses = {}});
  sent.stream.event({kSince1970 + 0.01, EventKind::begin, "lift", ""});
  for (int i = 1; i <= 100; ++i) sent.stream.frame(frame_at(known, kSince1970 + 0.01 * i));
  sent.stream.event({kSince1970 + 1, EventKind::end, "lift", "ok"});
  sent.stream.estimate(
      {.time = kSince1970 + 0.5, .status = "certain", .modes = {}, .contacts = {}});
  sent.stream.belief({.time = kSince1970 + 0.75, .source = "online", .in_hand = true, .poses = {}});
  const auto phase = sent.of("story").back()["phases"][0];
  EXPECT_NEAR(phase["begin"].get<double>(), 0.01, 1e-6);
  EXPECT_NEAR(phase["end"].get<double>(), 1, 1e-6);
  EXPECT_NEAR(sent.of("estimate")[0]["time"].get<double>(), 0.5, 1e-6);
  EXPECT_EQ(sent.of("belief")[0]["time"], 0.0);
  EXPECT_NEAR(sent.of("belief")[1]["time"].get<double>(), 0.75, 1e-6);
  Sent early;
  early.stream.frame(frame_at(known, 0.25));
  Sent late;
  late.stream.frame(frame_at(known, kSince1970 + 0.25));
  EXPECT_EQ(late.of("frames")[0]["time"], early.of("frames")[0]["time"]);
}

TEST(PageStream, ABeliefOfEarlierIsJudgedByTheTruthOfThen) {
  Sent sent;
  for (int i = 0; i <= 10; ++i) sent.stream.frame(frame_at(header(), 0.1 * i));
  const Eigen::Isometry3d then(Eigen::Translation3d(0, 0, 0.3));
  sent.stream.belief({.time = 0.3, .source = "touch", .in_hand = false, .poses = {{1.0, then}}});
  const auto beliefs = sent.of("belief");
  ASSERT_EQ(beliefs.size(), 1u);
  EXPECT_NEAR(beliefs[0]["translation_error_mm"].get<double>(), 0, 1e-6);
  EXPECT_EQ(beliefs[0]["entropy"], 0.0);
}

TEST(PageStream, NotesOfCrediblePosesAreBeliefsUntilThereAreOthers) {
  Sent sent;
  const std::string note = "credible 0.5 1 0 0 0 0 1 0 0 0 0 1 0.04 0 0 0 1";
  sent.stream.event({0, EventKind::note, "explore", note});
  EXPECT_EQ(sent.of("belief").size(), 1u);
  EXPECT_NEAR(sent.of("belief")[0]["entropy"].get<double>(), std::log(2.0), 1e-9);
  sent.stream.belief({.time = 0, .source = "prior", .in_hand = false, .poses = {}});
  sent.stream.event({0, EventKind::note, "explore", note});
  EXPECT_EQ(sent.of("belief").size(), 2u);
}

TEST(LivePage, IsAPageWithoutFrames) {
  const std::string page =
      live_page(header(), {}, "{{title}}|{{recording}}|{{script}}", "script", "a <b>");
  EXPECT_TRUE(page.starts_with("a &lt;b&gt;|"));
  const auto data =
      json::parse(page.substr(page.find('|') + 1, page.rfind('|') - page.find('|') - 1));
  EXPECT_EQ(data["live"], true);
  EXPECT_EQ(data["frames"]["count"], 0);
  EXPECT_EQ(data["fingers"].size(), 5u);
}

TEST(ComparePage, HoldsBothPagesAsTheyAre) {
  const std::string page = compare_page("<p a=\"1\">left</p>", "<p>right</p>", "two");
  EXPECT_NE(page.find("srcdoc=\"&lt;p a=&quot;1&quot;&gt;left&lt;/p&gt;\""), std::string::npos);
  EXPECT_NE(page.find("srcdoc=\"&lt;p&gt;right&lt;/p&gt;\""), std::string::npos);
  // On a telephone one is above the other.
  EXPECT_NE(page.find("<meta name=\"viewport\" content=\"width=device-width"), std::string::npos);
  EXPECT_NE(page.find("@media (max-width: 860px) { body { grid-template: "), std::string::npos);
}

TEST(Entropy, IsThatOfTheShares) {
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const auto of = [&](std::vector<double> shares) {
    BeliefRecord belief;
    for (const double share : shares) belief.poses.push_back({share, T});
    return entropy(belief);
  };
  EXPECT_NEAR(of({1}), 0, 1e-12);
  EXPECT_NEAR(of({0.5, 0.5}), std::log(2.0), 1e-12);
  EXPECT_NEAR(of({0.25, 0.25, 0.25, 0.25}), std::log(4.0), 1e-12);
  EXPECT_NEAR(of({0.5}), std::log(2.0), 1e-12);  // the rest is elsewhere
  // Where the most probable of many are listed, the others are no more probable than the least.
  EXPECT_NEAR(of(std::vector<double>(60, 0.001)), std::log(1000.0), 1e-9);
  EXPECT_NEAR(of({0.9, 0.01}), -0.9 * std::log(0.9) - 0.1 * std::log(0.01), 1e-12);
}

}  // namespace
}  // namespace palpate::recording
