// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "palpate/evaluation/fault_campaign.hpp"
#include "palpate/evaluation/trial_record.hpp"
#include "palpate/hand/shadow.hpp"

namespace palpate::evaluation {
namespace {

using hand::InjectedFault;
using skills::Fault;

constexpr std::uint64_t kSeed = 7;

const geometry::ObjectModel& box() {
  static const geometry::ObjectModel object(geometry::load_known_object("box"));
  return object;
}

TrialOptions options_with(InjectedFault fault, double from) {
  TrialOptions options = TrialOptions::ideal();
  options.fault.kind = hand::to_string(fault);
  options.fault.from = from;
  return options;
}

struct Case {
  InjectedFault injected;
  Fault reported;
  double within;  ///< s after it set in, or became visible
};

class FaultInSimulation : public testing::TestWithParam<Case> {};

/// While the hand touches the table, and as it sets out: the job cannot be done, and is not.
TEST_P(FaultInSimulation, IsNamedBeforeAnythingIsPressed) {
  const Case& c = GetParam();
  for (const double from : {0.0, 3.0, 4.21}) {
    const Trial trial = run_trial(box(), options_with(c.injected, from), kSeed);
    EXPECT_EQ(to_string(trial.result.fault.fault), to_string(c.reported)) << "from " << from;
    EXPECT_LT(trial.result.fault.time, from + c.within) << trial.result.fault.detail;
    EXPECT_LT(trial.metrics.peak_load, kMaxLoad);
    EXPECT_LT(trial.metrics.peak_tip_force, kCrushingForce);
    EXPECT_FALSE(trial.result.held);
    EXPECT_FALSE(trial.metrics.has_pose);
    EXPECT_TRUE(trial.result.estimate.posterior.modes.empty());
  }
}

INSTANTIATE_TEST_SUITE_P(
    Campaign, FaultInSimulation,
    testing::Values(Case{InjectedFault::load_nan, Fault::not_finite, 0.051},
                    Case{InjectedFault::load_zero, Fault::frozen, 0.061},
                    Case{InjectedFault::load_frozen, Fault::frozen, 0.061},
                    Case{InjectedFault::joint_nan, Fault::not_finite, 0.051},
                    Case{InjectedFault::torques_zero, Fault::frozen, 0.061},
                    Case{InjectedFault::contacts_nan, Fault::touch_lost, 0.051},
                    Case{InjectedFault::readings_stuck, Fault::frozen, 0.061},
                    Case{InjectedFault::link_dead, Fault::silent, 0.051},
                    Case{InjectedFault::time_nan, Fault::not_finite, 0.051},
                    Case{InjectedFault::delay, Fault::late, 0.051},
                    Case{InjectedFault::throws, Fault::exception, 0.051},
                    Case{InjectedFault::joint_stuck, Fault::joint_stuck, 10},
                    Case{InjectedFault::mount_stuck, Fault::joint_stuck, 10},
                    Case{InjectedFault::contacts_none, Fault::touch_lost, 60}),
    [](const auto& tested) { return std::string(hand::to_string(tested.param.injected)); });

TEST(Faults, AnInsensitiveFingertipIsNotBelievedAndTheObjectIsPicked) {
  int lifted = 0;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const Trial trial = run_trial(box(), options_with(InjectedFault::finger_silent, 0), kSeed + i);
    if (trial.result.fault) {
      EXPECT_EQ(trial.result.fault.fault, Fault::unsensed_load);
    }
    lifted += trial.metrics.lifted;
  }
  EXPECT_GE(lifted, 2);
}

/// Something holds it up, and a press on the table shows that it is insensitive.
TEST(Faults, AnInsensitiveThumbCrushesNothingAndIsNamed) {
  TrialOptions options = options_with(InjectedFault::finger_silent, 80);
  options.fault.finger = 0;
  const Trial trial = run_trial(box(), options, 945);
  EXPECT_TRUE(trial.metrics.lifted);
  EXPECT_LT(trial.metrics.peak_tip_force, kCrushingForce);
  EXPECT_LT(trial.metrics.peak_load, kMaxLoad);
  EXPECT_FALSE(trial.result.fault) << trial.result.fault.detail;
  ASSERT_FALSE(trial.result.survived.empty());
  EXPECT_EQ(trial.result.survived.front().fault, Fault::touch_lost);
  EXPECT_NE(trial.result.survived.front().detail.find("TH"), std::string::npos);
}

/// A tenth of the readings of each fingertip, which once ended every pick.
TEST(Faults, FalseContactsAreNotBelievedAndTheObjectIsPicked) {
  int lifted = 0;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const Trial trial = run_trial(box(), options_with(InjectedFault::false_contacts, 56), 703 + i);
    EXPECT_FALSE(trial.result.fault) << trial.result.fault.detail;
    EXPECT_LT(trial.metrics.peak_load, kMaxLoad);
    lifted += trial.metrics.lifted;
  }
  EXPECT_GE(lifted, 2);
}

/// It pushes the object out of the hand no more.
TEST(Faults, APickGoesOnWithARingFingerThatSensesNothing) {
  TrialOptions options = options_with(InjectedFault::finger_silent, 20);
  options.fault.finger = 3;
  const Trial trial = run_trial(box(), options, 702);
  EXPECT_FALSE(trial.result.fault) << trial.result.fault.detail;
  EXPECT_TRUE(trial.metrics.lifted);
  EXPECT_EQ(trial.result.attempts, 1);
}

TEST(Faults, NominalPickNeedsNoLimit) {
  TrialOptions options = TrialOptions::ideal();
  options.pick.explore.touches = options.pick.explore.max_touches = 4;
  const Trial trial = run_trial(box(), options, kSeed);
  EXPECT_FALSE(trial.result.fault) << trial.result.fault.detail;
  EXPECT_LT(trial.metrics.peak_load, skills::SafetyOptions{}.max_load);
  EXPECT_EQ(trial.result.limited_commands, 0u);
}

TEST(Faults, ARequestStopsThePick) {
  std::stop_source source;
  source.request_stop();
  const Trial trial = run_trial(box(), {}, kSeed, nullptr, {}, source.get_token());
  EXPECT_EQ(trial.result.fault.fault, Fault::stop_requested);
}

TEST(Faults, ATrialsRecordKeepsTheFault) {
  const Trial trial = run_trial(box(), options_with(InjectedFault::load_nan, 1), kSeed);
  const Trial again = trial_from_json(trial_to_json(trial));
  EXPECT_EQ(again.result.fault.fault, trial.result.fault.fault);
  EXPECT_EQ(again.result.fault.detail, trial.result.fault.detail);
  EXPECT_EQ(again.result.fault.time, trial.result.fault.time);
  EXPECT_EQ(again.metrics.peak_load, trial.metrics.peak_load);
}

TEST(Faults, ACampaignCountsWhatTheRobotNamed) {
  const FaultSummary summary = evaluate_fault(box(), {}, InjectedFault::joint_nan, kSeed, 2, 1);
  EXPECT_EQ(summary.trials, 2u);
  EXPECT_EQ(summary.crashed, 0u);
  EXPECT_EQ(summary.lifted, 0u);
  EXPECT_EQ(summary.stopped.at("not_finite"), 2u);
  EXPECT_LT(summary.longest_stop, 0.051);
}

TEST(Faults, AreDrawnByTheSeed) {
  const FaultOptions a = draw_fault(hand::shadow_hand(), InjectedFault::finger_stuck, 1);
  const FaultOptions b = draw_fault(hand::shadow_hand(), InjectedFault::finger_stuck, 1);
  const FaultOptions c = draw_fault(hand::shadow_hand(), InjectedFault::finger_stuck, 2);
  EXPECT_EQ(a.from, b.from);
  EXPECT_NE(a.from, c.from);
  EXPECT_EQ(hand::injected_fault(a.kind), InjectedFault::finger_stuck);
}

}  // namespace
}  // namespace palpate::evaluation
