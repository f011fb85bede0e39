// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/options.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/error_message.hpp"

namespace palpate {
namespace {

struct Lift {
  double way = 0.1;
  double speed = 0.05;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("way", way, 0.01, 0.3, "m, upwards");
    v("speed", speed, 0.001, 0.5, "m/s");
  }
};

struct Pick {
  Lift lift;
  int attempts = 3;
  std::uint64_t start = 7;
  bool table = true;
  std::string object = "mug";

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("lift", lift);
    v("attempts", attempts, 1, 20, "grasps tried at most");
    v("start", start, 0, std::numeric_limits<std::uint64_t>::max(), "first seed");
    v("table", table, "there is a table");
    v("object", object, "name or file");
  }
};

struct Trial {
  Pick pick;

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("pick", pick);
  }
};

/// Options that had other names: locate.window, explore.most_touches.
struct Renewed {
  struct Estimation {
    double window = 0.5;
    template <class Visitor>
    void visit(Visitor&& v) {
      v("window", window, 0.0, 10.0, "s of readings");
    }
  } estimation;
  struct Explore {
    int max_touches = 16;
    template <class Visitor>
    void visit(Visitor&& v) {
      v("max_touches", max_touches, 0, 64, "touches");
    }
  } explore;

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("estimation", estimation);
    v.section("explore", explore);
  }
};

struct WithExperts {
  double speed = 0.1, settle = 0.5;
  Lift inner;

  template <class Visitor>
  void visit(Visitor&& v) {
    v.expert("settle", settle, 0.0, 10.0, "s of rest");
    v("speed", speed, 0.0, 1.0, "m/s");
    v.expert_section("inner", inner);
  }
};

std::string toml_error(std::string_view text, Pick options = {}) {
  return error_message([&] { parse_toml(text, "run.toml", options); });
}

std::string setting_error(std::string_view assignment, Pick options = {}) {
  return error_message([&] { apply_setting(assignment, options); });
}

TEST(Options, ReadsEveryKindFromToml) {
  Pick options;
  parse_toml(R"(attempts = 5
start = 9223372036854775807
table = false
object = "my mug.ply"  # a comment
[lift]
way = 0.2
)",
             "run.toml", options);
  EXPECT_EQ(options.attempts, 5);
  EXPECT_EQ(options.start, 9223372036854775807u);
  EXPECT_FALSE(options.table);
  EXPECT_EQ(options.object, "my mug.ply");
  EXPECT_EQ(options.lift.way, 0.2);
  EXPECT_EQ(options.lift.speed, 0.05);
}

TEST(Options, ReadsDottedAndInlineTables) {
  Pick options;
  parse_toml("lift = {way = 0.2}", "run.toml", options);
  EXPECT_EQ(options.lift.way, 0.2);
  parse_toml("lift.way = 0.3", "run.toml", options);
  EXPECT_EQ(options.lift.way, 0.3);
}

TEST(Options, AppliesSettings) {
  Trial options;
  for (const char* setting : {"pick.lift.way=0.25", "pick.attempts = 1", "pick.table=false",
                              "pick.object=a = b", "pick.start=12"}) {
    apply_setting(setting, options);
  }
  EXPECT_EQ(options.pick.lift.way, 0.25);
  EXPECT_EQ(options.pick.attempts, 1);
  EXPECT_FALSE(options.pick.table);
  EXPECT_EQ(options.pick.object, "a = b");
  EXPECT_EQ(options.pick.start, 12u);
}

TEST(Options, StringSettingMayLookLikeANumber) {
  Pick options;
  apply_setting("object=12", options);
  EXPECT_EQ(options.object, "12");
  apply_setting("object=", options);
  EXPECT_EQ(options.object, "");
}

TEST(Options, NumberTakesAnIntegerButNotTheReverse) {
  Trial options;
  Lift wide;
  EXPECT_EQ(error_message([&] { apply_setting("way=1", wide); }),
            "way = 1 is outside 0.01 .. 0.3 (m, upwards)");
  EXPECT_EQ(setting_error("attempts=2.0"), "attempts = 2.0 is not an integer");
}

TEST(Options, UnknownKeyNamesTheNearestAndTheLine) {
  EXPECT_EQ(toml_error("attempts = 3\n[lift]\nwya = 0.2\n"),
            "run.toml:3: unknown option lift.wya; did you mean lift.way?");
  EXPECT_EQ(setting_error("way=0.2"), "unknown option way; did you mean lift.way?");
  EXPECT_EQ(setting_error("lift.sped=0.2"), "unknown option lift.sped; did you mean lift.speed?");
  EXPECT_EQ(toml_error("[lfit]\nway = 0.2\n"),
            "run.toml:1: unknown option lfit; did you mean lift.way?");
  EXPECT_EQ(toml_error("[[lift]]\nway = 0.2\n"),
            "run.toml:1: unknown option lift; did you mean lift.way?");
  for (const char* key : {"zzz", "nonsense", "x.y", "lift.yaw", "speedy.boat"}) {
    EXPECT_EQ(setting_error(key + std::string("=0.2")), fmt::format("unknown option {}", key));
  }
  EXPECT_EQ(setting_error("arm.lift.sped=1"),
            "unknown option arm.lift.sped; did you mean lift.speed?");
  Renewed sections;  // the section alone is no likeness
  EXPECT_EQ(error_message([&] { apply_setting("estimation.depth=1", sections); }),
            "unknown option estimation.depth");
}

TEST(Options, WrongTypeIsNamed) {
  EXPECT_EQ(toml_error("[lift]\nway = 'fast'"), "run.toml:2: lift.way = 'fast' is not a number");
  EXPECT_EQ(toml_error("table = 1"), "run.toml:1: table = 1 is not true or false");
  EXPECT_EQ(toml_error("object = 1"), "run.toml:1: object = 1 is not a string");
  EXPECT_EQ(toml_error("attempts = [1, 2]"), "run.toml:1: attempts = (array) is not an integer");
  EXPECT_EQ(toml_error("[attempts]\nx = 1"), "run.toml:1: attempts = (table) is not an integer");
  EXPECT_EQ(setting_error("lift.way="), "lift.way =  is not a number");
  EXPECT_EQ(setting_error("attempts=1x"), "attempts = 1x is not an integer");
  EXPECT_EQ(setting_error("lift.way"), "'lift.way' has no value: the form is KEY=VALUE");
  EXPECT_EQ(setting_error("=1"), "'=1' has no key: the form is KEY=VALUE");
}

TEST(Options, RangeIsNamed) {
  EXPECT_EQ(toml_error("\nattempts = 21"),
            "run.toml:2: attempts = 21 is outside 1 .. 20 (grasps tried at most)");
  EXPECT_EQ(setting_error("start=-1"),
            "start = -1 is outside 0 .. 9223372036854775807 (first seed)");
  EXPECT_EQ(setting_error("attempts=5000000000"),
            "attempts = 5000000000 is outside 1 .. 20 (grasps tried at most)");
  EXPECT_EQ(setting_error("lift.way=nan"), "lift.way = nan is outside 0.01 .. 0.3 (m, upwards)");
  EXPECT_NE(toml_error("lift.way = inf"), "");
}

TEST(Options, RangeIncludesItsEnds) {
  Pick options;
  apply_setting("attempts=20", options);
  apply_setting("lift.way=0.01", options);
  EXPECT_EQ(options.attempts, 20);
  EXPECT_EQ(options.lift.way, 0.01);
}

TEST(Options, SyntaxErrorIsOneLineWithItsLine) {
  const std::string message = toml_error("attempts = 3\nlift = = 2\n");
  EXPECT_EQ(message.rfind("run.toml:2: ", 0), 0u) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

TEST(Options, ErrorLeavesTheOptionsUnchanged) {
  Pick options;
  EXPECT_THROW(parse_toml("attempts = 5\ntable = false\nlift.way = 9", "run.toml", options),
               BadInput);
  EXPECT_EQ(options.attempts, 3);
  EXPECT_TRUE(options.table);
}

TEST(Options, MissingFileIsBadInput) {
  Pick options;
  EXPECT_THROW(load_toml("no/such/file.toml", options), BadInput);
}

TEST(Options, WritesTomlThatReadsBackExactly) {
  Trial options;
  options.pick.lift.way = 0.1 + 0.2 * 0.7;
  options.pick.lift.speed = 1.0 / 3;
  options.pick.object = "a \"b\" \\ c\n\u00e9";
  options.pick.table = false;
  options.pick.attempts = 19;
  Trial read;
  parse_toml(to_toml(options), "written", read);
  EXPECT_EQ(read.pick.lift.way, options.pick.lift.way);
  EXPECT_EQ(read.pick.lift.speed, options.pick.lift.speed);
  EXPECT_EQ(read.pick.object, options.pick.object);
  EXPECT_EQ(read.pick.table, options.pick.table);
  EXPECT_EQ(read.pick.attempts, options.pick.attempts);
}

TEST(Options, TomlTextHasRootFirstAndDocs) {
  EXPECT_EQ(to_toml(Pick{}),
            "attempts = 3                      # grasps tried at most (1 .. 20)\n"
            "start = 7                         # first seed (0 .. 9223372036854775807)\n"
            "table = true                      # there is a table\n"
            "object = 'mug'                    # name or file\n"
            "\n[lift]\n"
            "way = 0.1                         # m, upwards (0.01 .. 0.3)\n"
            "speed = 0.05                      # m/s (0.001 .. 0.5)\n");
}

TEST(Options, ListsKeysWithDocs) {
  const auto options = list_options(Trial{});
  ASSERT_EQ(options.size(), 6u);
  EXPECT_EQ(options[0].key, "pick.lift.way");
  EXPECT_EQ(options[0].type, "number");
  EXPECT_EQ(options[0].value, "0.1");
  EXPECT_EQ(options[0].range, "0.01 .. 0.3");
  EXPECT_EQ(options[0].doc, "m, upwards");
  EXPECT_EQ(options[4].type, "bool");
  EXPECT_EQ(options[4].range, "");
}

TEST(Options, AnEarlierNameIsAnErrorThatSaysTheNewOne) {
  Renewed options;
  EXPECT_EQ(error_message([&] { apply_setting("locate.window=1", options); }),
            "option locate.window is now estimation.window");
  EXPECT_EQ(error_message([&] { parse_toml("[explore]\nmost_touches = 3", "run.toml", options); }),
            "run.toml:2: option explore.most_touches is now explore.max_touches");
  EXPECT_EQ(error_message([&] { parse_toml("[locate]\nwindow = 1", "run.toml", options); }),
            "run.toml:2: option locate.window is now estimation.window");
}

/// Options whose names began with most_ and least_.
struct Limits {
  double max_points = 1, min_log_std = 1, max_force = 1, min_gap = 1;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("max_points", max_points, 0.0, 10.0, "points");
    v("min_log_std", min_log_std, 0.0, 10.0, "log");
    v("max_force", max_force, 0.0, 10.0, "N");
    v("min_gap", min_gap, 0.0, 10.0, "m");
  }
};

TEST(Options, LimitsThatWereMostOrLeastAreNamed) {
  for (const auto& [former, present] :
       {std::pair{"most_points", "max_points"}, std::pair{"least_log_std", "min_log_std"},
        std::pair{"most_force", "max_force"}, std::pair{"least_gap", "min_gap"}}) {
    Limits options;
    EXPECT_EQ(error_message([&] { apply_setting(std::string(former) + "=2", options); }),
              std::string("option ") + former + " is now " + present);
  }
}

TEST(Options, AnEarlierNameIsReadWhereItIsAccepted) {
  Renewed options;
  parse_toml("[locate]\nwindow = 1\n[explore]\nmost_touches = 3", "old.h5", options,
             Earlier::accepted);
  EXPECT_EQ(options.estimation.window, 1);
  EXPECT_EQ(options.explore.max_touches, 3);
  EXPECT_THROW(parse_toml("[locate]\nwidow = 1", "old.h5", options, Earlier::accepted), BadInput);
}

/// Options of sections of which some are gone.
struct Left {
  Lift palpation, forward_model;

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("palpation", palpation);
    v.expert_section("forward_model", forward_model);
  }
};

TEST(Options, OneThatIsGoneIsAnErrorThatSaysWhy) {
  Left options;
  const std::string postures = " is gone: the postures are those of the hand's description";
  EXPECT_EQ(
      setting_error("palpation.rolls=2"),
      "option palpation.rolls is gone: a held object is no longer rolled between the fingers");
  EXPECT_EQ(setting_error("grasp.top.pitch=2"), "option grasp.top.pitch" + postures);
  EXPECT_EQ(setting_error("expert.grasp.side.contact_torque.thumb=1"),
            "option expert.grasp.side.contact_torque.thumb" + postures);
  EXPECT_EQ(error_message([&] {
              parse_toml("[expert.forward_model.noise]\npoint = 0.001", "run.toml", options);
            }),
            "run.toml:2: option expert.forward_model.noise.point is gone: the forward model has "
            "neither noise nor errors");
  EXPECT_EQ(setting_error("place.fingers.reorient.world.hand=shadow"),
            "option place.fingers.reorient.world.hand is gone: the forward model is of the hand "
            "that the robot has");
  EXPECT_EQ(
      setting_error("locate.errors.link=0.1"),
      "option locate.errors.link is gone: the hand's description has the errors of its links");
}

TEST(Options, OneThatIsGoneIsPassedOverWhereItIsAccepted) {
  Left options;
  parse_toml("[palpation]\nrolls = 2\nspeed = 0.2\n[expert.forward_model.error]\nmass = 0",
             "old.h5", options, Earlier::accepted);
  EXPECT_EQ(options.palpation.speed, 0.2);
  EXPECT_THROW(parse_toml("[palpation]\nrols = 2", "old.h5", options, Earlier::accepted), BadInput);
}

TEST(Options, ExpertsHaveASectionOfTheirOwnBehindTheOthers) {
  const auto options = list_options(WithExperts{});
  ASSERT_EQ(options.size(), 4u);
  EXPECT_EQ(options[0].key, "speed");
  EXPECT_EQ(options[1].key, "expert.settle");
  EXPECT_EQ(options[2].key, "expert.inner.way");
}

TEST(Options, ExpertsAreSetInTheirSection) {
  WithExperts options;
  apply_setting("expert.settle=2", options);
  parse_toml("[expert.inner]\nspeed = 0.2", "run.toml", options);
  EXPECT_EQ(options.settle, 2);
  EXPECT_EQ(options.inner.speed, 0.2);
  WithExperts again;
  parse_toml(to_toml(options), "run.toml", again);
  EXPECT_EQ(to_toml(again), to_toml(options));
}

TEST(Options, AnExpertsEarlierNameIsAnErrorThatSaysTheNewOne) {
  WithExperts options;
  EXPECT_EQ(error_message([&] { apply_setting("settle=2", options); }),
            "option settle is now expert.settle");
  EXPECT_EQ(error_message([&] { parse_toml("[inner]\nway = 0.2", "run.toml", options); }),
            "run.toml:2: option inner.way is now expert.inner.way");
  parse_toml("[inner]\nway = 0.2", "old.h5", options, Earlier::accepted);
  EXPECT_EQ(options.inner.way, 0.2);
}

}  // namespace
}  // namespace palpate
