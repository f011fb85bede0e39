// SPDX-License-Identifier: Apache-2.0
#include "sense_biotac.hpp"

#include <fmt/format.h>

#include <limits>
#include <memory>
#include <optional>

#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/biotac/contact_hand.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "sense_contacts.hpp"

namespace palpate::app {
namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// A frame in which nothing is known but its flags.
SensedSample without_contact(double time, unsigned flags) {
  const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(kNotMeasured);
  return {.time = time,
          .point = unknown,
          .force = unknown,
          .normal = unknown,
          .sigma_deg = kNotMeasured,
          .error_deg = kNotMeasured,
          .flags = tactile::biotac_flag_names(flags)};
}

SensedSample sensed_frame(const tactile::BiotacLog& log, unsigned flags,
                          const std::optional<tactile::BiotacNormal>& normal, std::size_t i) {
  SensedSample sample = without_contact(log.time[i], flags);
  if (!normal) return sample;
  sample.normal = normal->n;
  sample.sigma_deg = normal->sigma / kDegree;
  if (log.normals[i]) sample.error_deg = tactile::angle_between_deg(normal->n, *log.normals[i]);
  return sample;
}

std::shared_ptr<const tactile::BiotacInverse> inverse_of(const std::string& model) {
  if (model.empty()) return tactile::shipped_biotac_inverse();
  return std::make_shared<const tactile::BiotacInverse>(
      tactile::BiotacInverse::parse(read_file(model), model));
}

}  // namespace

std::vector<SensedStream> sense_channels(const SenseArguments& arguments,
                                         const recording::Recording& recording) {
  if (recording.frames.empty() || recording.frames.front().reading.biotacs.empty()) {
    if (arguments.model.empty()) return {};
    throw BadInput(fmt::format("{} has no channels of a BioTac for --model {} to read",
                               arguments.recording, arguments.model));
  }
  const auto& hand = recording.header.hand;
  const geometry::MeshQuery mesh(recording.header.object.mesh);
  tactile::BiotacFingers fingers(hand, inverse_of(arguments.model));
  std::vector<SensedStream> streams;
  for (const auto& finger : hand.fingers) {
    streams.push_back({.name = fmt::format("{}-biotac", finger.name), .samples = {}});
  }
  for (const recording::Frame& frame : recording.frames) {
    const auto estimates = fingers.estimate(frame.reading);
    const auto T_mount_link = hand::forward_kinematics(hand, frame.reading.joints);
    for (std::size_t i = 0; i < estimates.size(); ++i) {
      SensedSample sample = without_contact(frame.reading.time, estimates[i].flags);
      if (estimates[i].contact) {
        const auto contact = fingers.in_link(*estimates[i].contact, static_cast<int>(i));
        const Eigen::Isometry3d T = frame.reading.mount.pose() *
                                    T_mount_link[static_cast<std::size_t>(hand.fingers[i].link)];
        sample.point = T * contact.p;
        sample.force = T.linear() * contact.f;
        sample.normal = T.linear() * contact.n;
        sample.sigma_deg = contact.normal_sigma / kDegree;
        const Eigen::Vector3d tip_center =
            sample.point + hand.fingers[i].tip.radius * sample.normal;
        if (const auto truth = true_normal(mesh, frame, tip_center)) {
          sample.error_deg = tactile::angle_between_deg(sample.normal, *truth);
        }
      }
      streams[i].samples.push_back(std::move(sample));
    }
  }
  return streams;
}

std::vector<SensedStream> sense_biotac(const SenseArguments& arguments) {
  if (arguments.model.empty()) {
    throw BadInput(
        fmt::format("{} is a log of a BioTac, which needs --model FILE; palpate train "
                    "biotac-normal makes one",
                    arguments.recording));
  }
  const auto model = tactile::BiotacNormalModel::parse(read_file(arguments.model), arguments.model);
  const auto log = tactile::read_biotac_log(arguments.recording);
  const auto rest = arguments.causal ? tactile::BiotacRest::causal : tactile::BiotacRest::whole_log;
  const auto signals = tactile::biotac_signals(log, rest);
  const auto normals = model.track(log, signals, rest);
  SensedStream stream{.name = "biotac", .samples = {}};
  for (std::size_t i = 0; i < log.time.size(); ++i) {
    stream.samples.push_back(sensed_frame(log, signals.flags[i], normals[i], i));
  }
  return {stream};
}

}  // namespace palpate::app
