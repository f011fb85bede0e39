// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common.hpp"

namespace palpate::app {

struct SenseArguments {
  CommonOptions common;
  std::string recording;
  std::string model;             ///< trained BioTac model; empty: none given
  std::string estimator = "s2";  ///< of contacts' normals
  std::optional<double> tick;    ///< s, where a CSV counts ticks instead of seconds
  double min_force = 1e-3;       ///< N; contacts of less are left out
  bool causal = false;           ///< a BioTac's log frame by frame, as it would come
};

/// What was sensed at one time; values that are not known are nan.
struct SensedSample {
  double time = 0;  ///< s
  Eigen::Vector3d point, force, normal;
  double sigma_deg = 0;  ///< standard deviation of the normal, per tangent axis
  double error_deg = 0;
  std::string flags;  ///< what is wrong with the sample, joined by "+"; empty: nothing
};

/// One finger's (or sensor's) samples in the order of time.
struct SensedStream {
  std::string name;
  std::vector<SensedSample> samples;
  bool resting = true;  ///< all that was touched is one object, which did not move meanwhile
};

/// Prints the table or JSON object of the streams, and writes each stream's series and figures to
/// --out, if given, with the contacts of resting objects.
void report_streams(const SenseArguments& arguments, const CLI::App& command,
                    const std::vector<SensedStream>& streams);

}  // namespace palpate::app
