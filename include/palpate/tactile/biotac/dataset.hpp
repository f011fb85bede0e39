// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "palpate/tactile/biotac/decoder.hpp"

namespace palpate::tactile {

inline constexpr int kNetworkInputs = 13;   ///< c (m), f1, f2, f3 (N), tdc (counts)
inline constexpr int kNetworkOutputs = 23;  ///< pdc, pac, tdc, tac, e1..e19 (counts)
inline constexpr int kDatasetColumns = 35;  ///< thesis eq. 5.11

/// What touches the sensor in a simulated trajectory.
enum class Touched { plane, ball, edge };

struct BiotacDatasetOptions {
  int trajectories = 400;
  double seconds = 3;        ///< of each
  int stride = 5;            ///< frames from one row to the next
  double max_force = 5;      ///< N, normal
  bool only_planes = false;  ///< else also balls of 8..60 mm radius and rounded edges
  std::uint64_t seed = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("trajectories", trajectories, 1, 1000000, "number of simulated touches");
    v("seconds", seconds, 0.3, 1000.0, "s, duration of each touch");
    v("stride", stride, 1, 1000, "frames between two rows");
    v("max_force", max_force, 0.01, 100.0, "N, largest normal force");
    v("only_planes", only_planes, "touch only planes, no balls and rounded edges");
  }
};

/// A frame of a simulated touch: what is true, and what the sensor says.
struct BiotacFrame {
  int trajectory = 0;
  double time = 0;  ///< s
  Eigen::Vector3d p, n;
  /// Force on the object now, 100 ms and 200 ms ago, N.
  Eigen::Vector3d f1, f2, f3;
  BiotacReading reading;
  DecodedReading decoded;
};

/// Simulated touches: an object rolls and slides over the tip while normal and tangential force
/// and temperature vary smoothly (below 1.5 Hz); the tangential force stays within friction.
std::vector<BiotacFrame> simulate_biotac(const BiotacDatasetOptions& options,
                                         const SkinOptions& skin = {},
                                         const BiotacSensorOptions& sensor = {});

/// Thesis eq. 5.11: rows [pdc pac tdc tac e1..e19 f1 f2 f3 c], N x 35; pac is the frame's last.
Eigen::MatrixXd biotac_dataset(const std::vector<BiotacFrame>& frames);

/// The data set as CSV: a header, and a column of the trajectory's number before the 35.
std::string dataset_csv(const std::vector<BiotacFrame>& frames);

/// Inputs (13 x N) and outputs (23 x N) of the network in a data set.
Eigen::MatrixXf network_inputs(const Eigen::MatrixXd& rows);
Eigen::MatrixXf network_outputs(const Eigen::MatrixXd& rows);

}  // namespace palpate::tactile
