// SPDX-License-Identifier: Apache-2.0
#include "sense_biotac.hpp"

#include <fmt/format.h>

#include <limits>
#include <numbers>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/touch/biotac_normal.hpp"

namespace palpate::app {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

SensedSample sense_frame(const touch::BiotacNormalModel& model, const touch::BiotacLog& log,
                         const touch::BiotacSignals& signals, std::size_t i) {
  const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(kUnknown);
  SensedSample sample{.time = log.time[i],
                      .point = unknown,
                      .force = unknown,
                      .normal = unknown,
                      .sigma_deg = kUnknown,
                      .error_deg = kUnknown,
                      .flags = touch::biotac_flag_names(signals.flags[i])};
  if (!touch::biotac_usable(signals.flags[i])) return sample;
  const auto felt = model.estimate(signals.changes[i]);
  if (!felt) return sample;
  sample.normal = felt->n;
  sample.sigma_deg = felt->sigma * 180 / std::numbers::pi;
  if (log.normals[i]) sample.error_deg = touch::angle_between_deg(felt->n, *log.normals[i]);
  return sample;
}

}  // namespace

std::vector<SensedStream> sense_biotac(const SenseArguments& arguments) {
  if (arguments.model.empty()) {
    throw BadInput(
        fmt::format("{} is a log of a BioTac, which needs --model FILE; palpate train "
                    "biotac-normal makes one",
                    arguments.recording));
  }
  const auto model = touch::BiotacNormalModel::parse(read_file(arguments.model), arguments.model);
  const auto log = touch::read_biotac_log(arguments.recording);
  const auto signals = touch::biotac_signals(log);
  SensedStream stream{.name = "biotac", .samples = {}};
  for (std::size_t i = 0; i < log.time.size(); ++i) {
    stream.samples.push_back(sense_frame(model, log, signals, i));
  }
  return {stream};
}

}  // namespace palpate::app
