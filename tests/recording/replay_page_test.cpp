// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/replay_page.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <regex>

#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::recording {
namespace {

constexpr std::string_view kPage = "<title>{{title}}</title>|{{recording}}|{{script}}|";

std::string page_of(const Recording& recording, const hand::HandVisuals& visuals = {}) {
  return replay_page(recording, visuals, kPage, "script()", "toy");
}

/// What kPage holds in place of {{recording}}.
nlohmann::json data_of(const std::string& page) {
  const auto begin = page.find('|') + 1;
  return nlohmann::json::parse(page.substr(begin, page.rfind("|script()") - begin));
}

template <class T>
std::vector<T> decoded(const std::string& text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, count = 0;
  for (const char c : text.substr(0, text.find('='))) {
    bits = bits << 6 | static_cast<unsigned>(kDigits.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += static_cast<char>(bits >> count & 0xff);
  }
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

/// In which nothing is touched.
Recording untouched_recording(int ticks) {
  Recording recording = toy_recording(ticks);
  for (Frame& frame : recording.frames) {
    for (auto& finger : frame.reading.contacts) finger.clear();
  }
  return recording;
}

void touch(Frame& frame, std::size_t finger) {
  frame.reading.contacts[finger] = {
      {Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ(), -Eigen::Vector3d::UnitZ()}};
}

TEST(ReplayPageTest, HoldsEveryOtherFrameAndTheLast) {
  for (const int ticks : {0, 1, 2, 101, 250}) {
    const Recording recording = untouched_recording(ticks);
    const auto frames = data_of(page_of(recording))["frames"];
    const std::size_t expected = ticks == 0 ? 0 : static_cast<std::size_t>(ticks) / 2 + 1;
    const auto time = decoded<float>(frames["time"]);
    ASSERT_EQ(frames["count"], expected);
    ASSERT_EQ(time.size(), expected);
    EXPECT_EQ(decoded<float>(frames["object_poses"]).size(), 7 * expected);
    EXPECT_EQ(decoded<float>(frames["link_poses"]).size(), 7 * 3 * expected);
    for (std::size_t i = 0; i + 1 < expected; ++i) {
      EXPECT_EQ(time[i], static_cast<float>(recording.frames[2 * i].reading.time));
    }
    if (ticks > 0) {
      EXPECT_EQ(time.back(), static_cast<float>(recording.frames.back().reading.time));
    }
  }
}

TEST(ReplayPageTest, ThinsLongRecordings) {
  Recording recording = toy_recording(10);
  recording.frames.resize(9001, recording.frames[0]);
  const std::size_t count = data_of(page_of(recording))["frames"]["count"];
  EXPECT_LE(count, 1501u);
  EXPECT_GT(count, 1000u);
}

TEST(ReplayPageTest, HoldsAFrameOfATouchThatIsShorterThanFramesAreApart) {
  Recording recording = untouched_recording(101);
  touch(recording.frames[31], 2);
  for (const std::size_t i : {51u, 52u, 53u}) touch(recording.frames[i], 1);
  const auto frames = data_of(page_of(recording))["frames"];
  const auto time = decoded<float>(frames["time"]);
  const auto counts = decoded<std::uint32_t>(frames["contact_counts"]);
  ASSERT_EQ(time.size(), 53u);  // every other one, and the first of each touch
  for (const std::size_t i : {31u, 51u, 52u}) {
    const auto at = std::ranges::find(time, static_cast<float>(recording.frames[i].reading.time));
    ASSERT_NE(at, time.end());
    EXPECT_EQ(counts[static_cast<std::size_t>(at - time.begin())], 1u);
  }
  EXPECT_TRUE(std::ranges::is_sorted(time));

  recording.frames.resize(9001, recording.frames[0]);  // a sensor that flickers
  for (std::size_t i = 0; i < recording.frames.size(); ++i) touch(recording.frames[i], i % 5);
  EXPECT_LE(data_of(page_of(recording))["frames"]["count"], 3001u);
}

TEST(ReplayPageTest, IsTheSameWhateverTheClock) {
  constexpr double kSince1970 = 1.764e9;  // s, in which 32 bits resolve a minute
  Recording recording = toy_recording(100);
  recording.events.push_back({0.7, EventKind::note, "place", "mark placed"});
  recording.beliefs = {{.time = 0.3, .source = "touch", .in_hand = false, .poses = {}}};
  const auto expected = data_of(page_of(recording));
  for (Frame& frame : recording.frames) frame.reading.time += kSince1970;
  for (Event& event : recording.events) event.time += kSince1970;
  for (EstimateRecord& estimate : recording.estimates) estimate.time += kSince1970;
  for (BeliefRecord& belief : recording.beliefs) belief.time += kSince1970;
  const auto shifted = data_of(page_of(recording));

  constexpr double kClose = 1e-6;  // s; doubles resolve less than that
  const auto expected_time = decoded<float>(expected["frames"]["time"]);
  const auto time = decoded<float>(shifted["frames"]["time"]);
  ASSERT_EQ(time.size(), expected_time.size());
  for (std::size_t i = 0; i < time.size(); ++i) EXPECT_NEAR(time[i], expected_time[i], kClose);
  for (const char* const at :
       {"/phases/0/begin", "/phases/0/end", "/phases/1/begin", "/placement/let_go/0",
        "/estimates/0/time", "/estimates/1/time", "/beliefs/0/time"}) {
    const nlohmann::json::json_pointer pointer(at);
    EXPECT_NEAR(shifted[pointer].get<double>(), expected[pointer].get<double>(), kClose) << at;
  }
  const nlohmann::json::json_pointer error("/estimates/0/modes/0/rotation_error_deg");
  EXPECT_EQ(shifted[error], expected[error]);
}

TEST(ReplayPageTest, ShowsWhereTheObjectWasToBePut) {
  Recording recording = toy_recording(10);
  EXPECT_TRUE(data_of(page_of(recording))["placement"]["target"].is_null());
  const std::string pose = "1 0 0 0.2 0 1 0 0.1 0 0 1 0.05 0 0 0 1";
  for (const std::string& text : {"target " + pose, std::string("path 0 0 0.3 0.1 0 0.4"),
                                  "fixture " + pose + " 0.1 0.002 0.003",
                                  std::string("fixture 1 2"), std::string("mark placed")}) {
    recording.events.push_back({0.05, EventKind::note, "place", text});
  }
  const auto placement = data_of(page_of(recording))["placement"];
  ASSERT_EQ(placement["target"].size(), 16u);
  EXPECT_EQ(placement["target"][3], 0.2);
  EXPECT_EQ(placement["path"], nlohmann::json::array({0.0, 0.0, 0.3, 0.1, 0.0, 0.4}));
  ASSERT_EQ(placement["fixture"].size(), 1u);  // a note that is not a box is left out
  EXPECT_EQ(placement["fixture"][0].back(), 0.003);
  EXPECT_EQ(placement["let_go"], nlohmann::json::array({0.05}));
}

TEST(ReplayPageTest, PlacesLinksAndContactsInTheWorld) {
  const Recording recording = toy_recording(1);
  const auto frames = data_of(page_of(recording))["frames"];
  const hand::HandReading& reading = recording.frames[0].reading;
  const auto T_world_distal =
      reading.mount.pose() * hand::forward_kinematics(recording.header.hand, reading.joints)[2];
  const auto links = decoded<float>(frames["link_poses"]);
  const auto contacts = decoded<float>(frames["contacts"]);
  const auto counts = decoded<std::uint32_t>(frames["contact_counts"]);
  std::vector<hand::TipContact> sensed;
  for (const auto& finger : reading.contacts)
    sensed.insert(sensed.end(), finger.begin(), finger.end());
  ASSERT_GT(sensed.size(), 0u);
  ASSERT_EQ(counts.at(0), sensed.size());
  ASSERT_EQ(contacts.size(), 7 * sensed.size());
  for (std::size_t i = 0; i < sensed.size(); ++i) {
    const Eigen::Vector3d p = T_world_distal * sensed[i].p;
    const Eigen::Vector3d n = T_world_distal.linear() * sensed[i].n;
    for (int k = 0; k < 3; ++k) {
      const auto at = 7 * i + static_cast<std::size_t>(k);
      EXPECT_NEAR(contacts[at], p[k], 1e-6);
      EXPECT_NEAR(contacts[at + 3], n[k], 1e-6);
    }
    EXPECT_NEAR(contacts[7 * i + 6], -sensed[i].f.dot(sensed[i].n), 1e-6);
  }
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(links[static_cast<std::size_t>(14 + k)], T_world_distal.translation()[k], 1e-6);
  }
}

TEST(ReplayPageTest, ReportsErrorsModuloSymmetryAndAlongTheFreeAxis) {
  Recording recording = toy_recording(60);
  const std::size_t last = 59;
  recording.frames[last].truth.emplace();
  auto& truth = recording.frames[last].truth->T_world_object;
  truth = Eigen::Translation3d(0.1, 0.2, 0.3) * Eigen::Isometry3d::Identity();
  EstimateRecord& estimate = recording.estimates.at(1);
  PoseModeRecord& twin = estimate.modes[0];
  twin.T_world_object =
      Eigen::Translation3d(0.1, 0.2, 0.304) *
      Eigen::Isometry3d(Eigen::Quaterniond(recording.header.object.symmetries[1]));
  PoseModeRecord& turned = estimate.modes[1];
  turned.free_axis = {truth.translation(), Eigen::Vector3d::UnitX(), std::numbers::pi};
  turned.T_world_object = truth * Eigen::AngleAxisd(2.0, Eigen::Vector3d::UnitX());
  const auto modes = data_of(page_of(recording))["estimates"][1]["modes"];
  EXPECT_NEAR(modes[0]["rotation_error_deg"], 0, 1e-6);
  EXPECT_NEAR(modes[0]["translation_error_mm"], 4, 1e-9);
  EXPECT_LE(modes[1]["rotation_error_deg"], 0.51);
  EXPECT_NEAR(modes[1]["translation_error_mm"], 0, 1e-6);

  for (Frame& frame : recording.frames) frame.truth.reset();
  EXPECT_FALSE(
      data_of(page_of(recording))["estimates"][1]["modes"][0].contains("rotation_error_deg"));
}

TEST(ReplayPageTest, ReportsPhasesInOrder) {
  Recording recording = toy_recording(100);
  recording.events.push_back({1.0, EventKind::begin, "lift", ""});
  const auto phases = data_of(page_of(recording))["phases"];
  ASSERT_EQ(phases.size(), 3u);
  EXPECT_EQ(phases[0]["name"], "height_probe");
  EXPECT_EQ(phases[0]["end"], 0.5);
  EXPECT_EQ(phases[0]["outcome"], "81 mm tall: side grasp");
  EXPECT_EQ(phases[2]["outcome"], "");
  EXPECT_GE(phases[2]["end"], 1.0);
}

TEST(ReplayPageTest, ReportsWhereTheRestingObjectMayBe) {
  Recording recording = toy_recording(100);
  const auto pose = [](double x) { return fmt::format("1 0 0 {} 0 1 0 0 0 0 1 0 0 0 0 1", x); };
  recording.events.push_back({0.6, EventKind::note, "explore",
                              fmt::format("credible 0.75 {} 0.25 {}", pose(0.1), pose(0.2))});
  recording.events.push_back({0.7, EventKind::note, "explore", "credible"});
  const auto data = data_of(page_of(recording));
  ASSERT_EQ(data["beliefs"].size(), 2u);
  const auto& poses = data["beliefs"][0]["poses"];
  EXPECT_EQ(data["beliefs"][0]["time"], 0.6);
  ASSERT_EQ(poses.size(), 2u);
  EXPECT_EQ(poses[1]["probability"], 0.25);
  EXPECT_EQ(poses[1]["T_world_object"][3], 0.2);
  EXPECT_TRUE(data["beliefs"][1]["poses"].empty());
  // What was worked out for the whole recording is shown in the place of the notes.
  recording.beliefs = {{.time = 0, .source = "prior", .in_hand = false, .poses = {}}};
  EXPECT_EQ(data_of(page_of(recording))["beliefs"].size(), 1u);
}

TEST(ReplayPageTest, NamesCannotBreakOut) {
  Recording recording = toy_recording(2);
  const std::string nasty = "</script><script>alert(1)</script>{{script}}&\"'";
  recording.header.object.name = nasty;
  recording.events[0].phase = nasty;
  recording.events[1].text = std::string("\xff\xfe") + nasty;
  const std::string page = replay_page(recording, {}, kPage, "var s = '</script>{{title}}'", nasty);
  EXPECT_EQ(page.find("</script"), std::string::npos);
  EXPECT_EQ(page.find("<script"), std::string::npos);
  EXPECT_NE(page.find("&lt;/script&gt;"), std::string::npos);
  const auto begin = page.find('|') + 1;
  const auto data = nlohmann::json::parse(page.substr(begin, page.find("|var s") - begin));
  EXPECT_EQ(data["object"], nasty);
}

TEST(ReplayPageTest, DrawsPartsOnceAndSpheresWithoutThem) {
  const Recording recording = toy_recording(1);
  hand::HandVisuals visuals;
  visuals.meshes["box"] = box_mesh({0.01, 0.01, 0.02});
  visuals.parts = {{0, "box", Eigen::Isometry3d::Identity(), {1, 0, 0}},
                   {2, "box", Eigen::Isometry3d::Identity(), {0, 1, 0}}};
  const auto data = data_of(page_of(recording, visuals));
  EXPECT_EQ(data["meshes"].size(), 2u);
  EXPECT_EQ(data["parts"].size(), 2u);
  EXPECT_TRUE(data["spheres"].empty());
  EXPECT_EQ(data_of(page_of(recording))["spheres"].size(), recording.header.hand.spheres.size());

  visuals.parts[0].link = 3;
  EXPECT_THROW(page_of(recording, visuals), BadInput);
  visuals.parts[0] = {0, "ball", Eigen::Isometry3d::Identity(), {1, 0, 0}};
  EXPECT_THROW(page_of(recording, visuals), BadInput);
}

TEST(ReplayPageTest, CoarsensFineMeshes) {
  const Recording recording = toy_recording(1);
  hand::HandVisuals visuals;
  geometry::TriangleMesh& sheet = visuals.meshes["sheet"];
  constexpr int kSide = 200;
  for (int i = 0; i < kSide * kSide; ++i) {
    sheet.vertices.emplace_back(0.001 * (i % kSide), 0.001 * (i / kSide), 0);
    if (i % kSide + 1 < kSide && i / kSide + 1 < kSide) {
      sheet.triangles.push_back({i, i + 1, i + kSide});
    }
  }
  visuals.parts = {{0, "sheet", Eigen::Isometry3d::Identity(), {1, 0, 0}}};
  const auto mesh = data_of(page_of(recording, visuals))["meshes"][1];
  const std::size_t vertices = decoded<float>(mesh["positions"]).size() / 3;
  EXPECT_LT(vertices, sheet.vertices.size() / 2);
  for (const auto v : decoded<std::uint32_t>(mesh["indices"])) EXPECT_LT(v, vertices);
}

TEST(ReplayPageTest, RefusesATemplateWithoutItsMarks) {
  const Recording recording = toy_recording(1);
  EXPECT_THROW(replay_page(recording, {}, "{{title}} {{recording}}", "", ""), BadInput);
}

TEST(ReplayPageTest, ShippedPageLoadsNothing) {
  const std::string page = replay_page(toy_recording(2500), {}, read_file(asset("page.html")),
                                       read_file(asset("viewer.js")), "toy");
  EXPECT_LT(page.size(), 6'000'000u);
  EXPECT_EQ(page.find("{{"), page.npos);
  const std::string shell = page.substr(0, page.find("<script type=\"application/json\""));
  EXPECT_FALSE(std::regex_search(shell, std::regex("https?://|url\\(|@import|(src|href)\\s*=")));
  EXPECT_NE(shell.find("default-src 'none'"), shell.npos);  // the browser then refuses any request
  std::size_t scripts = 0;
  for (auto at = page.find("<script"); at != page.npos; at = page.find("<script", at + 1))
    ++scripts;
  EXPECT_EQ(scripts, 2u);
}

}  // namespace
}  // namespace palpate::recording
