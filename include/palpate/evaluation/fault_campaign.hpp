// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "palpate/evaluation/trial.hpp"

namespace palpate::evaluation {

inline constexpr double kMaxLoad = 60;        ///< N of the mount that a fault may bring about
inline constexpr double kCrushingForce = 30;  ///< N of a fingertip, at which an object is crushed

/// What became of the trials with one fault. Rates are over all trials started.
struct FaultSummary {
  std::size_t trials = 0;
  std::size_t lifted = 0;
  std::size_t pose_ok = 0;          ///< lifted, and the best pose within 5 deg and 10 mm
  std::size_t confident_wrong = 0;  ///< the best pose wrong, its probability above 0.9
  std::size_t overloaded = 0;       ///< the mount bore more than kMaxLoad
  std::size_t crushed = 0;          ///< a fingertip pressed with more than kCrushingForce
  std::size_t crashed = 0;          ///< an exception ended the trial
  double peak_load = 0;             ///< N, of the mount
  double peak_tip_force = 0;        ///< N, of a fingertip
  double longest_stop = 0;          ///< s from a fault to the last reading before the robot stops
  std::map<std::string, std::size_t> stopped;   ///< by the fault that the robot named
  std::map<std::string, std::size_t> survived;  ///< trials that went on with a fault they named
};

/// When and where a fault sets in, drawn by the seed.
FaultOptions draw_fault(const hand::Description& hand, hand::InjectedFault fault,
                        std::uint64_t seed);

/// Called with each finished trial, in the order of the seeds.
using FaultObserver = std::function<void(std::size_t done)>;

/// Repeats the pick of one object with one fault, drawn for each trial, with the seeds
/// first_seed, first_seed + 1, ... The result is the same for any number of threads.
FaultSummary evaluate_fault(const geometry::ObjectModel& object, const TrialOptions& options,
                            hand::InjectedFault fault, std::uint64_t first_seed, std::size_t trials,
                            int threads, const FaultObserver& observer = {});

/// Adds what became of other trials.
void add(const FaultSummary& other, FaultSummary& sum);

}  // namespace palpate::evaluation
