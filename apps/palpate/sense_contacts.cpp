// SPDX-License-Identifier: Apache-2.0
#include "sense_contacts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpate/core/angle.hpp"
#include "palpate/evaluation/recorder.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/skills/explore/calibrate_phase.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "palpate/tactile/contacts/contact_log.hpp"
#include "palpate/tactile/normals/normal_estimator.hpp"
#include "sense_biotac.hpp"

namespace palpate::app {
namespace {

constexpr double kReach = 0.02;  // m from a tip's centre to the object; what it touches farther
                                 // away is something else, such as the table
constexpr double kNoTruth = std::numeric_limits<double>::quiet_NaN();

/// Sends the frames of one finger through checks and estimator.
class FingerSensor {
 public:
  FingerSensor(const std::string& name, const SenseArguments& arguments, double period)
      : stream_{.name = name, .samples = {}},
        maker_({.period = period, .min_force = arguments.min_force}),
        estimator_(tactile::make_normal_estimator(arguments.estimator)) {}

  void take(const tactile::FingerFrame& frame, const std::optional<Eigen::Vector3d>& truth) {
    const tactile::FingerSample sample = maker_.next(frame);
    stream_.samples.push_back({.time = sample.time,
                               .point = sample.p,
                               .force = sample.f,
                               .normal = Eigen::Vector3d::Constant(kNoTruth),
                               .sigma_deg = kNoTruth,
                               .error_deg = kNoTruth,
                               .flags = sample.flags.names()});
    truths_.push_back(truth);
    touched_ = touched_ || !frame.contacts.empty();
    const tactile::NormalEstimate estimate = estimator_->update(sample);
    if (estimate.status == tactile::NormalStatus::tracked) place(estimate);
    for (const auto& late : estimator_->take_late()) place(late);
  }

  bool touched() const { return touched_; }
  SensedStream take_stream() {
    for (const auto& late : estimator_->take_late(true)) place(late);
    return std::move(stream_);
  }

 private:
  /// Puts an estimate to the sample that it describes, which may lie some time back.
  void place(const tactile::NormalEstimate& estimate) {
    for (std::size_t i = stream_.samples.size(); i-- > 0;) {
      SensedSample& sample = stream_.samples[i];
      if (sample.time != estimate.time || !sample.point.allFinite()) continue;
      sample.normal = estimate.n;
      if (estimate.covariance) {
        sample.sigma_deg = kDegreesPerRadian * std::sqrt(estimate.covariance->trace() / 2);
      }
      if (truths_[i]) sample.error_deg = tactile::angle_between_deg(estimate.n, *truths_[i]);
      return;
    }
  }

  SensedStream stream_;
  std::vector<std::optional<Eigen::Vector3d>> truths_;  // of the samples
  tactile::SampleMaker maker_;
  std::unique_ptr<tactile::NormalEstimator> estimator_;
  bool touched_ = false;
};

std::optional<Eigen::Vector3d> true_normal_of(const geometry::MeshQuery& mesh,
                                              const recording::Frame& frame,
                                              const tactile::FingerFrame& sensed,
                                              double tip_radius) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0;
  for (const auto& contact : sensed.contacts) {
    if (!contact.tip_normal) continue;
    sum += contact.p + tip_radius * *contact.tip_normal;
    ++count;
  }
  if (count == 0) return std::nullopt;
  return true_normal(mesh, frame, sum / count);
}

}  // namespace

std::optional<Eigen::Vector3d> true_normal(const geometry::MeshQuery& mesh,
                                           const recording::Frame& frame,
                                           const Eigen::Vector3d& tip_center) {
  if (!frame.truth || !frame.truth->T_world_object.matrix().allFinite()) return std::nullopt;
  const Eigen::Isometry3d& T = frame.truth->T_world_object;
  const Eigen::Vector3d center = T.inverse() * tip_center;
  if (!center.allFinite()) return std::nullopt;
  const geometry::ClosestPoint nearest = mesh.closest_point(center);
  const Eigen::Vector3d out = center - nearest.point;
  if (out.norm() > kReach) return std::nullopt;
  return T.linear() * (out.dot(nearest.normal) > 0 ? out.normalized() : nearest.normal);
}

std::vector<SensedStream> sense_recording(const SenseArguments& arguments) {
  auto recording = recording::read_recording(arguments.recording);
  recording.header.hand =
      skills::calibration(recording.header.hand, recording::event_log(recording), {}).hand;
  const geometry::MeshQuery mesh(recording.header.object.mesh);
  std::vector<SensedStream> streams;
  for (const auto& finger : recording.header.hand.fingers) {
    tactile::check_finger_name(finger.name, arguments.recording);
  }
  for (int finger = 0; finger < recording.header.hand.finger_count(); ++finger) {
    const auto& described = recording.header.hand.fingers[static_cast<std::size_t>(finger)];
    FingerSensor sensor(described.name, arguments, hand::kTick);
    for (const recording::Frame& frame : recording.frames) {
      const auto sensed = tactile::finger_frame(frame.reading, recording.header.hand, finger);
      const double radius = described.tip.radius;
      sensor.take(sensed, true_normal_of(mesh, frame, sensed, radius));
    }
    if (sensor.touched()) streams.push_back(sensor.take_stream());
  }
  for (auto& stream : sense_channels(arguments, recording)) streams.push_back(std::move(stream));
  // A hand also touches the table, and lifts the object.
  for (SensedStream& stream : streams) stream.resting = false;
  return streams;
}

std::vector<SensedStream> sense_contact_log(const SenseArguments& arguments) {
  std::vector<SensedStream> streams;
  for (const auto& log : tactile::read_contact_log(arguments.recording, arguments.tick)) {
    FingerSensor sensor(log.finger, arguments, log.period);
    for (std::size_t i = 0; i < log.frames.size(); ++i) sensor.take(log.frames[i], log.normals[i]);
    streams.push_back(sensor.take_stream());
  }
  return streams;
}

}  // namespace palpate::app
