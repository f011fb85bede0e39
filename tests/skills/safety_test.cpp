// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/safety.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <condition_variable>
#include <limits>
#include <mutex>
#include <thread>

#include "hand/fake_hand.hpp"
#include "palpate/core/error.hpp"
#include "palpate/hand/faulty_hand.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/skills/phase.hpp"

namespace palpate::skills {
namespace {

using hand::HandReading;
using hand::InjectedFault;
using hand::kTick;

constexpr double kFrom = 0.2;     // s at which a fault sets in
constexpr double kDetect = 0.05;  // s within which the hand must stand still
const double kNan = std::numeric_limits<double>::quiet_NaN();
const hand::Description kSoftHand = hand::with_soft_actuators();

/// A hand that notes when its mount was last commanded to move on.
class WatchedHand : public hand::Hand {
 public:
  explicit WatchedHand(hand::Hand& hand) : hand_(hand) {}
  HandReading step(const hand::HandCommand& command) override {
    ++steps;
    if (command.mount.xyz.x() > before_) last_advance = steps * kTick;
    before_ = command.mount.xyz.x();
    return hand_.step(command);
  }
  int steps = 0;
  double last_advance = 0;  ///< s, by the number of steps

 private:
  hand::Hand& hand_;
  double before_ = 0;
};

/// A hand in motion, of which all fingertips but one sense something, and a fault.
struct FaultyScene {
  explicit FaultyScene(const hand::FaultSchedule& schedule, hand::FakeHand::Script script = {})
      : fake([script = std::move(script)](HandReading& reading) {
          for (std::size_t i = 0; i < 4; ++i) {
            const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
            reading.contacts[i] = {{0.01 * up, up, -0.5 * up}};
          }
          reading.mount_force.z() = 2;
          if (script) script(reading);
        }),
        faulty(fake, schedule),
        hand(faulty),
        robot(hand, kSoftHand, hand::resting_command()) {}

  /// Moves on until something stops it.
  FaultReport run(double seconds = 3) {
    hand::MountPosition far;
    far.xyz.x() = 0.05 * seconds;
    try {
      robot.move_mount(far, 0.05);
    } catch (const SafetyStop& stop) {
      return stop.report();
    }
    return {};
  }

  hand::FakeHand fake;
  hand::FaultyHand faulty;
  WatchedHand hand;
  Executor robot;
};

struct Case {
  InjectedFault injected;
  Fault reported;
};

class EveryFault : public testing::TestWithParam<Case> {};

TEST_P(EveryFault, StopsTheHandInTimeAndIsNamed) {
  const Case& c = GetParam();
  FaultyScene scene({.fault = c.injected, .from = kFrom});
  EXPECT_EQ(to_string(scene.run().fault), to_string(c.reported));
  EXPECT_EQ(scene.robot.fault().fault, c.reported);
  EXPECT_FALSE(scene.robot.fault().detail.empty());
  EXPECT_LE(scene.hand.last_advance, kFrom + kDetect + 1e-9);
  EXPECT_THROW(scene.robot.wait(0.1), SafetyStop);  // for good
}

INSTANTIATE_TEST_SUITE_P(Safety, EveryFault,
                         testing::Values(Case{InjectedFault::load_nan, Fault::not_finite},
                                         Case{InjectedFault::load_zero, Fault::frozen},
                                         Case{InjectedFault::load_frozen, Fault::frozen},
                                         Case{InjectedFault::joint_nan, Fault::not_finite},
                                         Case{InjectedFault::torques_zero, Fault::frozen},
                                         Case{InjectedFault::contacts_nan, Fault::touch_lost},
                                         Case{InjectedFault::readings_stuck, Fault::frozen},
                                         Case{InjectedFault::link_dead, Fault::silent},
                                         Case{InjectedFault::time_nan, Fault::not_finite},
                                         Case{InjectedFault::delay, Fault::late},
                                         Case{InjectedFault::throws, Fault::exception}),
                         [](const auto& tested) {
                           return std::string(hand::to_string(tested.param.injected));
                         });

/// The errors of the load are taken off by the mount's attitude, which is noisy: what is left of a
/// frozen load never repeats.
TEST(Safety, AFrozenLoadIsNoticedAfterItsErrorsAreKnown) {
  for (const InjectedFault fault : {InjectedFault::load_zero, InjectedFault::load_frozen}) {
    FaultyScene scene({.fault = fault, .from = kFrom}, [](HandReading& reading) {
      reading.mount.ypr.x() += 1e-3 * std::sin(1000 * reading.time);
    });
    scene.robot.load_sensor().set_error({{0.2, 0.1, -0.1}, 0.5});
    EXPECT_EQ(to_string(scene.run().fault), to_string(Fault::frozen));
    EXPECT_LE(scene.hand.last_advance, kFrom + kDetect + 1e-9);
  }
}

class SurvivedFault : public testing::TestWithParam<InjectedFault> {};

TEST_P(SurvivedFault, LetsTheRobotGoOn) {
  FaultyScene scene({.fault = GetParam(), .from = kFrom, .finger = 2});
  EXPECT_FALSE(scene.run()) << scene.robot.fault().detail;
  EXPECT_EQ(scene.robot.limited_commands(), 0u);
}

INSTANTIATE_TEST_SUITE_P(Safety, SurvivedFault,
                         testing::Values(InjectedFault::none, InjectedFault::finger_silent,
                                         InjectedFault::finger_stuck, InjectedFault::finger_nan,
                                         InjectedFault::finger_saturated,
                                         InjectedFault::fingers_swapped, InjectedFault::taxel_dead,
                                         InjectedFault::false_contacts, InjectedFault::link_gap,
                                         InjectedFault::time_jitter),
                         [](const auto& tested) {
                           return std::string(hand::to_string(tested.param));
                         });

TEST(Safety, StandsStillInAGapAndKeepsNothingOfIt) {
  FaultyScene scene({.fault = InjectedFault::link_gap, .from = kFrom});
  scene.run();
  const auto& readings = scene.robot.log().readings;
  for (std::size_t i = 1; i < readings.size(); ++i) {
    EXPECT_GT(readings[i].time, readings[i - 1].time);
    EXPECT_LT(readings[i].mount.xyz.x() - readings[i - 1].mount.xyz.x(), 0.05 * kTick * 1.001);
  }
  EXPECT_NEAR(scene.hand.steps - static_cast<double>(readings.size()), 20, 1);
}

TEST(Safety, DropsWhatAFaultyFingertipSenses) {
  for (const auto fault : {InjectedFault::finger_nan, InjectedFault::finger_stuck}) {
    FaultyScene scene({.fault = fault, .from = kFrom, .finger = 2});
    scene.run();
    EXPECT_TRUE(scene.robot.reading().contacts[2].empty());
    EXPECT_FALSE(scene.robot.reading().contacts[1].empty());
  }
}

TEST(Safety, TooMuchLoadEndsInABaseThatGivesWay) {
  // An obstacle at 0.02 m, as stiff as the drives: the mount stays there.
  FaultyScene scene({}, [](HandReading& reading) {
    const double pushed = reading.mount.xyz.x() - 0.02;
    if (pushed <= 0) return;
    reading.mount_force.x() = 4000 * pushed;
    reading.mount.xyz.x() = 0.02;
  });
  const FaultReport report = scene.run();
  EXPECT_EQ(report.fault, Fault::excess_force);
  EXPECT_LT(scene.faulty.peak_load(), 45);
  EXPECT_LT(scene.robot.reading().mount_force.norm(), 5);
}

TEST(Safety, LoadThatNoFingertipSensesIsNamed) {
  FaultyScene scene({}, [](HandReading& reading) {
    for (auto& contacts : reading.contacts) contacts.clear();
    if (reading.time > kFrom) reading.mount_force.x() = 100 * (reading.time - kFrom);
  });
  EXPECT_EQ(scene.run().fault, Fault::unsensed_load);
}

TEST(Safety, ImpossibleValuesAreNamed) {
  const auto fault_of = [](auto spoil) {
    FaultyScene scene({}, [spoil](HandReading& reading) {
      if (reading.time > kFrom) spoil(reading);
    });
    return scene.run().fault;
  };
  EXPECT_EQ(fault_of([](HandReading& r) { r.joints[3] = 7; }), Fault::out_of_range);
  EXPECT_EQ(fault_of([](HandReading& r) { r.mount.xyz.y() = 40; }), Fault::out_of_range);
  EXPECT_EQ(fault_of([](HandReading& r) { r.mount_force.x() = 900; }), Fault::out_of_range);
  EXPECT_EQ(fault_of([](HandReading& r) { r.joints[3] = 1; }), Fault::implausible_change);
  EXPECT_EQ(fault_of([](HandReading& r) { r.mount.xyz.y() = 0.8; }), Fault::implausible_change);
  EXPECT_EQ(fault_of([](HandReading& r) { r.mount.ypr.y() = kNan; }), Fault::not_finite);
}

TEST(Safety, AReadingOfAnotherHandsSizeIsNamed) {
  const auto detail_of = [](auto spoil) {
    FaultyScene scene({}, [spoil](HandReading& reading) {
      if (reading.time > kFrom) spoil(reading);
    });
    const FaultReport report = scene.run();
    EXPECT_EQ(report.fault, Fault::out_of_range);
    EXPECT_LE(scene.hand.last_advance, kFrom + kDetect + 1e-9);
    return report.detail;
  };
  EXPECT_EQ(detail_of([](HandReading& r) { r.joints.conservativeResize(23); }),
            "23 joints were read, the hand has 24");
  EXPECT_EQ(detail_of([](HandReading& r) { r.torques.setZero(21); }),
            "21 torques were read, the hand has 20");
  EXPECT_EQ(detail_of([](HandReading& r) { r.contacts.pop_back(); }),
            "4 fingertips were read, the hand has 5");
}

TEST(Safety, ACommandOfAnotherHandsSizeNeverReachesTheHand) {
  FaultyScene scene({});
  const std::vector way(3, hand::HandCommand{hand::ActuatorVector::Zero(2), {}});
  EXPECT_THROW(scene.robot.follow(way), SafetyStop);
  EXPECT_EQ(scene.robot.fault().fault, Fault::invalid_command);
  EXPECT_NE(scene.robot.fault().detail.find("2 actuators are commanded, the hand has 20"),
            std::string::npos)
      << scene.robot.fault().detail;
}

TEST(Safety, APostureOfAnotherHandsSizeNeverReachesTheHand) {
  FaultyScene scene({});
  EXPECT_THROW(scene.robot.move_fingers(hand::ActuatorVector::Zero(2), 0.5), SafetyStop);
  EXPECT_EQ(scene.robot.fault().fault, Fault::invalid_command);
  EXPECT_EQ(scene.robot.fault().detail, "a posture of 2 actuators, the hand has 20");
}

TEST(Safety, AStartOfAnotherHandsSizeIsRefused) {
  hand::FakeHand fake;
  EXPECT_THROW(Executor(fake, kSoftHand, {}), BadInput);
}

TEST(Safety, AJointThatDoesNotFollowIsNamed) {
  hand::FakeHand fake;
  hand::FaultyHand faulty(fake, {.fault = InjectedFault::joint_stuck, .from = kFrom});
  Executor robot(faulty, kSoftHand, hand::resting_command());
  robot.wait(2 * kFrom);
  hand::ActuatorVector posture = hand::ActuatorVector::Zero(hand::kShadowActuators);
  posture[9] = 1;
  EXPECT_EQ(robot.move_fingers(posture, 1), MotionEnd::reached);
  EXPECT_THROW(robot.wait(1), SafetyStop);
  EXPECT_EQ(robot.fault().fault, Fault::joint_stuck);
  EXPECT_NE(robot.fault().detail.find("FFJ0"), std::string::npos);
}

TEST(Safety, AFaultLastsAsLongAsItIsTo) {
  hand::FakeHand fake([](HandReading& reading) { reading.mount_force.z() = 2; });
  int onsets = 0;
  hand::FaultyHand faulty(fake, {.fault = InjectedFault::load_zero, .from = kFrom, .length = 0.1},
                          [&] { ++onsets; });
  int without = 0;
  for (int tick = 1; tick <= 60; ++tick) {
    without += faulty.step(hand::resting_command()).mount_force.z() == 0;
  }
  EXPECT_NEAR(without, 10, 1);  // the time stamps are rounded
  EXPECT_EQ(onsets, 1);
}

TEST(Safety, ACommandThatIsNotFiniteNeverReachesTheHand) {
  FaultyScene scene({});
  hand::MountPosition nowhere;
  nowhere.xyz.z() = kNan;
  EXPECT_THROW(scene.robot.move_mount(nowhere, 0.1), SafetyStop);
  EXPECT_EQ(scene.robot.fault().fault, Fault::invalid_command);
  EXPECT_TRUE(scene.robot.reading().mount.xyz.allFinite());
}

TEST(Safety, AFullLogStopsTheRobot) {
  hand::FakeHand fake;
  Executor robot(fake, kSoftHand, hand::resting_command(), {}, nullptr, {{.max_log = 1.0}, {}, {}});
  EXPECT_THROW(robot.wait(2), SafetyStop);
  EXPECT_EQ(robot.fault().fault, Fault::log_full);
  EXPECT_LT(robot.log().readings.size(), 140u);
}

TEST(Safety, StopsWithinATickFromAnotherThread) {
  std::stop_source source;
  double asked = 0;
  hand::FakeHand fake([&](HandReading& reading) {
    if (reading.time < 0.5 || source.stop_requested()) return;
    asked = reading.time;
    std::thread([&] { source.request_stop(); }).join();
  });
  Executor robot(fake, kSoftHand, hand::resting_command(), {}, nullptr, {{}, source.get_token()});
  EXPECT_THROW(robot.wait(2), SafetyStop);
  EXPECT_EQ(robot.fault().fault, Fault::stop_requested);
  EXPECT_NEAR(robot.fault().time, asked, 1e-9);
}

/// A hand whose step hangs until its drives are stopped.
class HangingHand : public hand::FakeHand {
 public:
  HandReading step(const hand::HandCommand& command) override {
    if (++steps == 20) {
      std::unique_lock lock(mutex);
      EXPECT_TRUE(stopped.wait_for(lock, std::chrono::seconds(30), [this] { return stop; }));
    }
    return FakeHand::step(command);
  }
  void stop_drives() {
    const std::lock_guard lock(mutex);
    stop = true;
    stopped.notify_all();
  }
  int steps = 0;
  bool stop = false;
  std::mutex mutex;
  std::condition_variable stopped;
};

TEST(Safety, TheWatchdogStopsAHandThatHangs) {
  HangingHand hand;
  Safety safety;
  safety.options.watchdog = 0.5;
  safety.stop_drives = [&] { hand.stop_drives(); };
  Executor robot(hand, kSoftHand, hand::resting_command(), {}, nullptr, safety);
  EXPECT_THROW(robot.wait(2), SafetyStop);
  EXPECT_EQ(robot.fault().fault, Fault::silent);
}

/// A phase that throws what a user's code may throw.
class ThrowingPhase : public Phase {
 public:
  std::string_view name() const override { return "throwing"; }
  double time_limit() const override { return 10; }
  PhaseEnd run(Executor& robot, PickState&) override {
    hand::MountPosition far;
    far.xyz.x() = 0.1;
    robot.move_mount(far, 0.05);
    throw std::logic_error("a mistake");
  }
};

TEST(Safety, AnExceptionOfAPhaseLeavesTheHandSafe) {
  FaultyScene scene({});
  ThrowingPhase phase;
  PickState state;
  EXPECT_THROW(run_phase(phase, scene.robot, state), std::logic_error);
  EXPECT_EQ(scene.robot.fault().fault, Fault::exception);
  EXPECT_EQ(scene.robot.fault().detail, "a mistake");
}

TEST(Safety, AnExceptionThatEndsTheRobotLeavesTheHandSafe) {
  int stopped = 0;
  hand::FakeHand fake;
  try {
    Executor robot(fake, kSoftHand, hand::resting_command(), {}, nullptr,
                   {{}, {}, [&] { ++stopped; }});
    throw std::runtime_error("elsewhere");
  } catch (const std::runtime_error&) {
  }
  EXPECT_EQ(stopped, 1);
}

TEST(Safety, APhaseThatAFaultStopsSaysSo) {
  FaultyScene scene({.fault = InjectedFault::load_nan, .from = kFrom});
  ThrowingPhase phase;
  PickState state;
  const PhaseReport report = run_phase(phase, scene.robot, state);
  EXPECT_EQ(to_string(report.status), "fault");
  EXPECT_NE(report.outcome.find("not_finite: the mount's load"), std::string::npos);
}

TEST(Safety, AFingertipThatPressesHarderThanItsRangeTouches) {
  FaultyScene scene({}, [](HandReading& reading) {
    if (reading.time < 0.5) return;
    reading.contacts[4] = {{{0, 0, 0.01}, {0, 0, 1}, {0, 0, -60}}};
  });
  EXPECT_FALSE(scene.run(1));
  const auto& contacts = scene.robot.reading().contacts[4];
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].f.z(), -SafetyOptions{}.tip_force_range, 1e-9);
}

}  // namespace
}  // namespace palpate::skills
