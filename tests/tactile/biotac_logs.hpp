// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include "data.hpp"
#include "palpate/core/random.hpp"
#include "palpate/tactile/biotac/log.hpp"

namespace palpate::tactile {

/// A made-up log at 60 Hz: touches of a plate from changing directions, three seconds each with
/// two seconds of rest between, with noise and a drift of the rest values.
inline BiotacLog made_up_log(std::uint64_t seed, int touches, double drift_a_second = 0.2) {
  RandomStream random(seed, "log");
  BiotacLog log;
  log.name = "made-up";
  for (int touch = 0; touch < touches; ++touch) {
    const auto draw = [&] {
      const double y = random.uniform(-0.5, 0.5);
      return Eigen::Vector3d(random.uniform(-0.6, 0.2), y, 1);
    };
    const Eigen::Vector3d from = draw(), to = draw();
    for (int tick = 0; tick < 300; ++tick) {
      const double share = (tick - 120) / 180.0;
      const double press = share < 0 ? 0 : 300 * std::sin(3.14 * share);
      const Eigen::Vector3d n =
          ((1 - std::max(0.0, share)) * from + std::max(0.0, share) * to).normalized();
      const double time = (touch * 300 + tick) / 60.0;
      BiotacChannels channels;
      channels[0] = 2410 + press + drift_a_second * time + random.normal();
      for (int e = 0; e < kElectrodes; ++e) {
        // Electrodes that look the way of the normal lose counts, the others gain some.
        const double side = e < 6 ? 1 : e >= 10 && e < 16 ? -1 : 0;
        const Eigen::Vector3d look =
            Eigen::Vector3d(-0.4 + 0.1 * (e % 5), -0.6 * side, 1).normalized();
        const double near = std::exp(8 * (n.dot(look) - 1));
        channels[1 + e] =
            3200 + 10 * e + 0.5 * press * (0.3 - near) + drift_a_second * time + random.normal();
      }
      log.time.push_back(time);
      log.channels.push_back(channels.array().round().matrix());
      log.normals.emplace_back(n);
    }
  }
  return log;
}

/// The log as a CSV text.
inline std::string csv_of(const BiotacLog& log) {
  std::string text = "t_s,pdc";
  for (int e = 1; e <= kElectrodes; ++e) text += fmt::format(",e{}", e);
  text += ",nx,ny,nz\n";
  for (std::size_t i = 0; i < log.time.size(); ++i) {
    text += fmt::format("{}", log.time[i]);
    for (const double count : log.channels[i]) text += fmt::format(",{}", count);
    for (int axis = 0; axis < 3; ++axis) text += fmt::format(",{}", (*log.normals[i])[axis]);
    text += '\n';
  }
  return text;
}

/// The made-up log as it is read from its CSV text and, where it is there, that of a real sensor.
inline std::vector<BiotacLog> logs_on_file(const BiotacLog& made_up) {
  std::vector<BiotacLog> logs{parse_biotac_log(csv_of(made_up), made_up.name)};
  if (const auto file = real_data("biotac_robotic_finger/trial_15330.csv")) {
    logs.push_back(read_biotac_log(*file));
  }
  return logs;
}

}  // namespace palpate::tactile
