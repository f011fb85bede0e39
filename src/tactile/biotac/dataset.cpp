// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/dataset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "palpate/core/se3.hpp"

namespace palpate::tactile {
namespace {

constexpr int kLag = 10;  // frames in 100 ms

/// A smooth function of time within -1..1.
class Wave {
 public:
  explicit Wave(RandomStream& random) {
    for (int i = 0; i < 3; ++i) {
      rate_[i] = 2 * std::numbers::pi * random.uniform(0.1, 1.5);
      phase_[i] = random.uniform(0, 2 * std::numbers::pi);
      size_[i] = random.uniform(0.2, 1);
    }
    size_ /= size_.sum();
  }
  [[nodiscard]] double operator()(double t) const {
    return (size_.array() * (rate_.array() * t + phase_.array()).sin()).sum();
  }

 private:
  Eigen::Vector3d rate_, phase_, size_;
};

/// Shape, path and force of one touch.
class Trajectory {
 public:
  Trajectory(RandomStream random, const BiotacDatasetOptions& options)
      : options_(options),
        waves_{Wave(random), Wave(random), Wave(random), Wave(random), Wave(random)} {
    along_ = random.uniform(-0.011, 0.006);
    turn_ = random.uniform(-1.1, 1.1);
    most_ = options.max_force * random.uniform(0.05, 1);
    slip_ = 0.7 * std::sqrt(random.uniform());
    temperature_ = random.uniform(24, 33);
    const std::size_t shape = options.only_planes ? 0 : random.index(3);
    touched_ = static_cast<Touched>(shape);
    radius_ =
        touched_ == Touched::ball ? random.uniform(0.008, 0.06) : random.uniform(0.002, 0.005);
    edge_turn_ = random.uniform(0, std::numbers::pi);
  }

  /// The contact at a time before whose lag the forces start.
  [[nodiscard]] hand::TipContact at(double t, const BiotacSkin& skin) const {
    const double r = skin.options().radius;
    const double x = along_ + 0.003 * waves_[0](0.4 * t), angle = turn_ + 0.3 * waves_[1](0.4 * t);
    const double forward = std::clamp(x / r, 0.0, 0.95);
    const double ring = std::sqrt(1 - forward * forward);
    const Eigen::Vector3d outward(forward, ring * std::sin(angle), -ring * std::cos(angle));
    const Eigen::Vector3d p = Eigen::Vector3d(std::min(x, 0.0), 0, 0) + r * outward;
    const double normal = most_ * (0.55 + 0.45 * waves_[2](t));
    const Eigen::Matrix3d frame = frame_with_z(outward);
    const Eigen::Vector3d shear = slip_ * normal *
                                  (waves_[3](t) * frame.col(0) + waves_[4](t) * frame.col(1)) /
                                  std::numbers::sqrt2;
    return {.p = p, .n = -outward, .f = normal * outward + shear};
  }

  /// Distance from the touched object, which meets the skin at the contact.
  [[nodiscard]] SurfaceDistance surface(const hand::TipContact& contact) const {
    const Eigen::Vector3d p = contact.p, n = contact.n;
    if (touched_ == Touched::plane) {
      return [p, n](const Eigen::Vector3d& x) { return n.dot(x - p); };
    }
    const double radius = radius_;
    const Eigen::Vector3d center = p - radius * n;
    if (touched_ == Touched::ball) {
      return [center, radius](const Eigen::Vector3d& x) { return (x - center).norm() - radius; };
    }
    const Eigen::Matrix3d frame = frame_with_z(n);
    const Eigen::Vector3d axis =
        std::cos(edge_turn_) * frame.col(0) + std::sin(edge_turn_) * frame.col(1);
    return [center, radius, axis](const Eigen::Vector3d& x) {
      const Eigen::Vector3d d = x - center;
      return (d - d.dot(axis) * axis).norm() - radius;
    };
  }

  [[nodiscard]] double temperature(double t) const { return temperature_ + 0.1 * t; }

 private:
  BiotacDatasetOptions options_;
  std::array<Wave, 5> waves_;
  double along_, turn_, most_, slip_, temperature_, radius_, edge_turn_;
  Touched touched_;
};

void simulate_one(const Trajectory& trajectory, const BiotacDatasetOptions& options,
                  const BiotacSkin& skin, BiotacSensor& sensor, BiotacDecoder decoder,
                  std::vector<BiotacFrame>& frames) {
  const int number = frames.empty() ? 0 : frames.back().trajectory + 1;
  const int count = static_cast<int>(std::lround(options.seconds / kBiotacPeriod));
  sensor.reset();
  for (int k = 0; k < count; ++k) {
    const double t = k * kBiotacPeriod;
    const hand::TipContact contact = trajectory.at(t, skin);
    const auto state = skin.press({&contact, 1}, trajectory.surface(contact));
    const BiotacReading reading = sensor.step(state, trajectory.temperature(t));
    const auto decoded = decoder.step(reading);
    // Creep and filters need a while to forget that the touch began all at once.
    if (k < 5 * kLag || k % options.stride != 0 || !decoded) continue;
    frames.push_back({.trajectory = number,
                      .time = t,
                      .p = contact.p,
                      .n = contact.n,
                      .f1 = contact.f,
                      .f2 = trajectory.at(t - kLag * kBiotacPeriod, skin).f,
                      .f3 = trajectory.at(t - 2 * kLag * kBiotacPeriod, skin).f,
                      .reading = reading,
                      .decoded = *decoded});
  }
}

std::vector<std::string> column_names() {
  std::vector<std::string> names = {"pdc", "pac", "tdc", "tac"};
  for (int e = 1; e <= kElectrodes; ++e) names.push_back(fmt::format("e{}", e));
  for (int k = 1; k <= 3; ++k) {
    for (const char axis : {'x', 'y', 'z'}) names.push_back(fmt::format("f{}{}", k, axis));
  }
  for (const char axis : {'x', 'y', 'z'}) names.push_back(fmt::format("c{}", axis));
  return names;
}

}  // namespace

std::vector<BiotacFrame> simulate_biotac(const BiotacDatasetOptions& options,
                                         const SkinOptions& skin_options,
                                         const BiotacSensorOptions& sensor_options) {
  const BiotacSkin skin(skin_options);
  const RandomStream random(options.seed, "biotac-dataset");
  std::vector<BiotacFrame> frames;
  BiotacSensor sensor(skin, sensor_options, random.fork("sensor"));
  for (int i = 0; i < options.trajectories; ++i) {
    const auto index = static_cast<std::uint64_t>(i);
    sensor.reseed(random.fork("noise", index));
    simulate_one(Trajectory(random.fork("trajectory", index), options), options, skin, sensor,
                 BiotacDecoder(sensor.rest(), sensor_options), frames);
  }
  return frames;
}

Eigen::MatrixXd biotac_dataset(const std::vector<BiotacFrame>& frames) {
  Eigen::MatrixXd rows(static_cast<Eigen::Index>(frames.size()), kDatasetColumns);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const BiotacFrame& frame = frames[i];
    rows.row(static_cast<Eigen::Index>(i)) << frame.reading.pdc, frame.reading.pac.back(),
        frame.reading.tdc, frame.reading.tac, frame.reading.electrodes.transpose(),
        frame.f1.transpose(), frame.f2.transpose(), frame.f3.transpose(), frame.p.transpose();
  }
  return rows;
}

std::string dataset_csv(const std::vector<BiotacFrame>& frames) {
  const Eigen::MatrixXd rows = biotac_dataset(frames);
  std::string text = fmt::format("trajectory,{}\n", fmt::join(column_names(), ","));
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    text += fmt::format("{}", frames[static_cast<std::size_t>(i)].trajectory);
    for (Eigen::Index c = 0; c < rows.cols(); ++c) text += fmt::format(",{:.6g}", rows(i, c));
    text += '\n';
  }
  return text;
}

Eigen::MatrixXf network_inputs(const Eigen::MatrixXd& rows) {
  Eigen::MatrixXf inputs(kNetworkInputs, rows.rows());
  inputs.topRows<3>() = rows.rightCols<3>().transpose().cast<float>();
  inputs.middleRows<9>(3) = rows.middleCols<9>(kNetworkOutputs).transpose().cast<float>();
  inputs.bottomRows<1>() = rows.col(2).transpose().cast<float>();
  return inputs;
}

Eigen::MatrixXf network_outputs(const Eigen::MatrixXd& rows) {
  return rows.leftCols<kNetworkOutputs>().transpose().cast<float>();
}

}  // namespace palpate::tactile
