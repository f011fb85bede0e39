// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/fault_campaign.hpp"

#include <algorithm>
#include <exception>
#include <optional>

#include "palpate/core/parallel.hpp"
#include "palpate/core/random.hpp"
#include "palpate/simulation/hand/load_hand.hpp"

namespace palpate::evaluation {
namespace {

constexpr double kLatestFault = 150;  // s: most picks are still under way

int draw_index(RandomStream& random, int count) {
  return std::min(count - 1, static_cast<int>(random.uniform() * count));
}

/// @param from  s at which the fault set in
FaultSummary summary_of(const std::optional<Trial>& trial, double from) {
  FaultSummary summary;
  summary.trials = 1;
  summary.crashed = !trial;
  if (!trial) return summary;
  const TrialMetrics& metrics = trial->metrics;
  summary.lifted = metrics.lifted;
  summary.pose_ok = metrics.lifted && metrics.pose_ok;
  summary.confident_wrong = metrics.confident_wrong();
  summary.peak_load = metrics.peak_load;
  summary.peak_tip_force = metrics.peak_tip_force;
  summary.overloaded = metrics.peak_load > kMaxLoad;
  summary.crushed = metrics.peak_tip_force > kCrushingForce;
  for (const auto& fault : trial->result.survived) {
    summary.survived[std::string(to_string(fault.fault))] = 1;
  }
  if (const auto& fault = trial->result.fault) {
    ++summary.stopped[std::string(to_string(fault.fault))];
    summary.longest_stop = std::max(0.0, fault.time - from);
  }
  return summary;
}

}  // namespace

FaultOptions draw_fault(const hand::Description& hand, hand::InjectedFault fault,
                        std::uint64_t seed) {
  RandomStream random(seed, "fault");
  FaultOptions options;
  options.kind = hand::to_string(fault);
  options.from = random.uniform(0, kLatestFault);
  options.finger = draw_index(random, hand.finger_count());
  options.joint = draw_index(random, hand.joint_count());
  options.actuator = draw_index(random, hand.actuator_count());
  return options;
}

FaultSummary evaluate_fault(const geometry::ObjectModel& object, const TrialOptions& options,
                            hand::InjectedFault fault, std::uint64_t first_seed, std::size_t trials,
                            int threads, const FaultObserver& observer) {
  FaultSummary sum;
  const auto hand = simulation::load_hand(options.world.hand);
  const auto run = [&](std::size_t i) -> FaultSummary {
    TrialOptions faulty = options;
    faulty.fault = draw_fault(hand, fault, first_seed + i);
    try {
      return summary_of(run_trial(object, faulty, first_seed + i), faulty.fault.from);
    } catch (const std::exception&) {
      return summary_of(std::nullopt, 0);
    }
  };
  parallel_ordered(trials, threads, run, [&](std::size_t i, const FaultSummary& summary) {
    add(summary, sum);
    if (observer) observer(i + 1);
  });
  return sum;
}

void add(const FaultSummary& other, FaultSummary& sum) {
  sum.trials += other.trials;
  sum.lifted += other.lifted;
  sum.pose_ok += other.pose_ok;
  sum.confident_wrong += other.confident_wrong;
  sum.overloaded += other.overloaded;
  sum.crushed += other.crushed;
  sum.crashed += other.crashed;
  sum.peak_load = std::max(sum.peak_load, other.peak_load);
  sum.peak_tip_force = std::max(sum.peak_tip_force, other.peak_tip_force);
  sum.longest_stop = std::max(sum.longest_stop, other.longest_stop);
  for (const auto& [name, count] : other.stopped) sum.stopped[name] += count;
  for (const auto& [name, count] : other.survived) sum.survived[name] += count;
}

}  // namespace palpate::evaluation
