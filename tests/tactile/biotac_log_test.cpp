// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "core/error_message.hpp"
#include "palpate/tactile/biotac/log.hpp"
#include "tactile/biotac_logs.hpp"

namespace palpate::tactile {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

bool has(unsigned flags, BiotacFlag flag) { return (flags & static_cast<unsigned>(flag)) != 0; }

TEST(BiotacLog, ReadsWhatWasWritten) {
  const auto log = made_up_log(1, 1);
  const auto again = parse_biotac_log(csv_of(log), "folder/made-up.csv");
  EXPECT_EQ(again.name, "made-up");
  EXPECT_EQ(again.channels, log.channels);
  EXPECT_LT((*again.normals[200] - *log.normals[200]).norm(), 1e-6);
}

TEST(BiotacLog, RefusesWhatIsNoLog) {
  const auto says = [](const std::string& text) {
    return error_message([&] { (void)parse_biotac_log(text, "log.csv"); });
  };
  auto text = csv_of(made_up_log(1, 1));
  EXPECT_EQ(says(text), "");
  EXPECT_NE(says("t_s,pdc,e1\n1,2,3\n").find("e2"), std::string::npos);
  EXPECT_NE(says(text.substr(0, text.find('\n') + 1)).find("no rows"), std::string::npos);
  EXPECT_NE(says(text + "1,2\n").find("log.csv:302"), std::string::npos);
  auto words = text;
  words.replace(words.find("\n0,") + 1, 1, "x");
  EXPECT_NE(says(words).find("x"), std::string::npos);
}

TEST(BiotacSignals, FreesASlowlyDriftingLogOfItsRest) {
  const auto still = made_up_log(3, 4, 0), drifting = made_up_log(3, 4, 1);
  const auto a = biotac_signals(still), b = biotac_signals(drifting);
  double worst = 0;
  for (std::size_t i = 0; i < a.changes.size(); ++i) {
    worst = std::max(worst, (a.changes[i] - b.changes[i]).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 9);  // the drift sums up to 20 counts
  EXPECT_FALSE(has(a.flags.back(), BiotacFlag::drifted));
  EXPECT_TRUE(has(b.flags.back(), BiotacFlag::drifted));
}

TEST(BiotacSignals, FindsTheRestOfALogThatStartsInContact) {
  auto log = made_up_log(3, 3);
  const auto whole = biotac_signals(log);
  const std::ptrdiff_t cut = 200;  // within the first touch
  log.time.erase(log.time.begin(), log.time.begin() + cut);
  log.channels.erase(log.channels.begin(), log.channels.begin() + cut);
  log.normals.erase(log.normals.begin(), log.normals.begin() + cut);
  const auto late = biotac_signals(log);
  EXPECT_LT((late.changes[0] - whole.changes[cut]).cwiseAbs().maxCoeff(), 9);
  EXPECT_FALSE(has(late.flags[0], BiotacFlag::no_contact));
}

TEST(BiotacSignals, DistinguishesContactFromRest) {
  const auto signals = biotac_signals(made_up_log(3, 1));
  EXPECT_TRUE(has(signals.flags[60], BiotacFlag::no_contact));
  EXPECT_EQ(biotac_flag_names(signals.flags[210]), "");
  EXPECT_TRUE(biotac_usable(signals.flags[210]));
}

TEST(BiotacSignals, FlagsFaultyCounts) {
  auto log = made_up_log(3, 1);
  log.channels[210][4] = kNan;
  log.channels[211][4] = -1;
  log.channels[212][4] = 4096;
  log.channels[213][4] = 4095;
  log.channels[214][0] = 0;
  log.channels[216] = log.channels[215];
  const auto flags = biotac_signals(log).flags;
  EXPECT_EQ(biotac_flag_names(flags[210]), "missing");
  EXPECT_EQ(biotac_flag_names(flags[211]), "out_of_range");
  EXPECT_EQ(biotac_flag_names(flags[212]), "out_of_range");
  EXPECT_EQ(biotac_flag_names(flags[213]), "saturated");
  EXPECT_TRUE(has(flags[214], BiotacFlag::saturated));
  EXPECT_EQ(biotac_flag_names(flags[216]), "repeated");
  EXPECT_EQ(biotac_flag_names(flags[218]), "");
  for (const std::size_t i : {210, 211, 212, 213, 214, 216}) EXPECT_FALSE(biotac_usable(flags[i]));
}

TEST(BiotacSignals, FlagsAStuckElectrode) {
  auto log = made_up_log(3, 2);
  for (auto& channels : log.channels) channels[9] = 3210;
  int stuck = 0;
  for (const unsigned flags : biotac_signals(log).flags) stuck += has(flags, BiotacFlag::stuck);
  EXPECT_EQ(stuck, 600);
}

TEST(BiotacSignals, FlagsLateAndDisorderedFrames) {
  auto log = made_up_log(3, 1);
  for (std::size_t i = 200; i < log.time.size(); ++i) log.time[i] += 1;
  std::swap(log.time[250], log.time[251]);
  const auto flags = biotac_signals(log).flags;
  EXPECT_TRUE(has(flags[200], BiotacFlag::late));
  EXPECT_FALSE(has(flags[201], BiotacFlag::late));
  EXPECT_TRUE(has(flags[251], BiotacFlag::out_of_order));
}

TEST(BiotacSignals, SaysSoWhereThereIsNoRest) {
  auto log = made_up_log(3, 1);
  for (auto& channels : log.channels) channels[3] = kNan;
  for (const unsigned flags : biotac_signals(log).flags) {
    EXPECT_TRUE(has(flags, BiotacFlag::no_rest));
    EXPECT_FALSE(biotac_usable(flags));
  }
}

}  // namespace
}  // namespace palpate::tactile
