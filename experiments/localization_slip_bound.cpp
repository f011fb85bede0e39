// SPDX-License-Identifier: Apache-2.0
// How often a pose can be known 0.2 s after a slip at all: by an observer that knows everything but
// the slip and the noise.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "experiment.hpp"
#include "moving_object.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/core/statistics.hpp"

namespace {

using namespace palpate;
using experiment::MovingObject;
using experiment::Subject;

constexpr int kBefore = 100, kAfter = 20;  // frames about the slip that count
constexpr int kTemperatures = 30, kMoves = 2;

/// The information of the frames after the slip on a value that stays, once the errors that keep
/// have been learnt from those before: y = value + carried' errors_before + noise of this variance.
struct Averaging {
  Eigen::VectorXd weights;  // of the frames after
  Eigen::VectorXd carried;  // of the known errors before, to be taken off
  double variance = 0;      // of the mean, of a frame's being 1
};

/// @param before  frames whose errors are known
/// Generalised least squares with the covariance share exp(-|t| / time) + (1 - share) [t = 0].
Averaging averaging(int before) {
  const int count = before + kAfter;
  Eigen::MatrixXd C(count, count);
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      C(i, j) = experiment::kCorrelatedShare *
                std::exp(-std::abs(i - j) * experiment::kFrame / experiment::kNoiseTime);
    }
    C(i, i) += 1 - experiment::kCorrelatedShare;
  }
  const Eigen::MatrixXd gain =
      C.topLeftCorner(before, before).llt().solve(C.topRightCorner(before, kAfter)).transpose();
  const Eigen::MatrixXd S =
      C.bottomRightCorner(kAfter, kAfter) - gain * C.topRightCorner(before, kAfter);
  const Eigen::VectorXd w = S.llt().solve(Eigen::VectorXd::Ones(kAfter));
  Averaging result;
  result.variance = 1 / w.sum();
  result.weights = w * result.variance;
  result.carried = gain.transpose() * result.weights;
  return result;
}

/// A contact after the slip, the object's own motion since taken back, and freed of what is known.
struct MeanContact {
  Eigen::Vector3d p, n;
};

/// The jump: a turn by kSlipAngle about one direction, a way of kSlipWay along another.
struct Jump {
  Eigen::Vector3d axis, way;  // unit
  [[nodiscard]] Eigen::Isometry3d of(const Eigen::Isometry3d& before) const {
    Eigen::Isometry3d T = before;
    T.linear() = exp_so3(experiment::kSlipAngle * axis) * before.linear();
    T.translation() += experiment::kSlipWay * way;
    return T;
  }
};

class Observer {
 public:
  Observer(const Subject& subject, const Eigen::Isometry3d& before,
           std::vector<MeanContact> contacts, double variance)
      : subject_(subject), before_(before), contacts_(std::move(contacts)), variance_(variance) {}

  [[nodiscard]] double energy(const Jump& jump) const {
    const Eigen::Isometry3d T = jump.of(before_);
    double sum = 0;
    for (const MeanContact& contact : contacts_) {
      const auto closest = subject_.mesh.closest_point(T.inverse() * contact.p);
      const Eigen::Vector3d n = T.linear() * closest.normal;
      const double off = n.dot(contact.p - T * closest.point) / experiment::kPointNoise;
      const double along = contact.n.dot(n);
      if (along < 0.1) return 1e6;
      const double tilt = (contact.n / along - n).norm() / experiment::kNormalNoise;
      sum += 0.5 * (off * off + tilt * tilt) / variance_;
    }
    return sum;
  }

  /// Draws from the posterior: annealed from the prior, resampled, moved by Metropolis steps.
  [[nodiscard]] std::vector<Jump> draws(std::size_t count, RandomStream& random) const {
    std::vector<Jump> jumps(count);
    std::vector<double> energies(count);
    for (std::size_t i = 0; i < count; ++i) {
      jumps[i] = {random.unit_vector(), random.unit_vector()};
      energies[i] = energy(jumps[i]);
    }
    double power = 0;
    for (int step = 1; step <= kTemperatures; ++step) {
      const double next = std::pow(static_cast<double>(step) / kTemperatures, 3);
      resample(next - power, jumps, energies, random);
      power = next;
      const double spread = 0.6 / std::sqrt(1 + 20 * power / variance_ * 0.02);
      for (int move = 0; move < kMoves; ++move) {
        for (std::size_t i = 0; i < count; ++i) {
          this->move(power, spread, jumps[i], energies[i], random);
        }
      }
    }
    return jumps;
  }

 private:
  static void resample(double power, std::vector<Jump>& jumps, std::vector<double>& energies,
                       RandomStream& random) {
    const double least = *std::min_element(energies.begin(), energies.end());
    std::vector<double> sums(jumps.size());
    double sum = 0;
    for (std::size_t i = 0; i < jumps.size(); ++i) {
      sums[i] = sum += std::exp(-power * (energies[i] - least));
    }
    const auto old_jumps = jumps;
    const auto old_energies = energies;
    const double start = random.uniform();
    std::size_t from = 0;
    for (std::size_t i = 0; i < jumps.size(); ++i) {
      const double mark =
          (start + static_cast<double>(i)) / static_cast<double>(jumps.size()) * sum;
      while (from + 1 < sums.size() && sums[from] < mark) ++from;
      jumps[i] = old_jumps[from];
      energies[i] = old_energies[from];
    }
  }

  void move(double power, double spread, Jump& jump, double& now, RandomStream& random) const {
    const double scale = spread * std::exp(-2 * random.uniform());  // wide and narrow steps
    const Jump other{(jump.axis + scale * random.normal3()).normalized(),
                     (jump.way + scale * random.normal3()).normalized()};
    const double there = energy(other);
    if (random.uniform() >= std::exp(power * (now - there))) return;
    jump = other;
    now = there;
  }

  const Subject& subject_;
  Eigen::Isometry3d before_;
  std::vector<MeanContact> contacts_;
  double variance_;
};

struct Outcome {
  double mass = 0;  // of the posterior within tolerance of the best guess: its chance to be right
  bool right = false;
};

bool near(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b, const Subject& subject) {
  return localization::within(localization::pose_error(a, b, subject.model.object().symmetries));
}

/// Index of the draw that has most of all draws within tolerance, and their share.
std::pair<std::size_t, double> best_guess(const std::vector<Eigen::Isometry3d>& poses,
                                          const Subject& subject) {
  std::pair<std::size_t, double> best{0, 0};
  for (std::size_t i = 0; i < poses.size(); i += 4) {
    double mass = 0;
    for (const auto& pose : poses) mass += near(pose, poses[i], subject);
    mass /= static_cast<double>(poses.size());
    if (mass > best.second) best = {i, mass};
  }
  return best;
}

/// One slip, seen by the observer.
Outcome slip_once(const Subject& subject, const Averaging& averaging, std::size_t draws,
                  RandomStream random) {
  MovingObject object(subject, {"correlated", 0.001, true, true}, random.fork("object"));
  const std::size_t tips = object.tips().size();
  std::vector<MeanContact> mean(tips, {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()});
  for (int k = 0; k < kBefore; ++k) {
    const auto frame = object.next(k * experiment::kFrame);
    for (std::size_t i = 0; i < tips; ++i) {
      const auto& contact = frame.contacts[i];
      if (averaging.carried.size() == 0) continue;
      const Eigen::Vector3d n = object.truth().linear() * object.tips()[i].n;
      mean[i].p -= averaging.carried[k] * (contact.p - object.truth() * object.tips()[i].p);
      mean[i].n -= averaging.carried[k] * (contact.n / contact.n.dot(n) - n);
    }
  }
  const Eigen::Isometry3d before = object.truth();
  object.slip();
  const Eigen::Isometry3d slipped = object.truth();
  for (int k = 0; k < kAfter; ++k) {
    const auto frame = object.next((kBefore + k) * experiment::kFrame);
    const Eigen::Isometry3d back = slipped * object.truth().inverse();
    for (std::size_t i = 0; i < tips; ++i) {
      mean[i].p += averaging.weights[k] * (back * frame.contacts[i].p);
      mean[i].n += averaging.weights[k] * (back.linear() * frame.contacts[i].n);
    }
  }
  for (auto& contact : mean) contact.n.normalize();
  const Observer observer(subject, before, mean, averaging.variance);
  std::vector<Eigen::Isometry3d> poses;
  for (const Jump& jump : observer.draws(draws, random)) poses.push_back(jump.of(before));
  const auto [guess, mass] = best_guess(poses, subject);
  return {mass, near(poses[guess], slipped, subject)};
}

void slip_bound(const experiment::Options& options) {
  const std::size_t count = options.quick ? 2 : 100;
  const std::size_t draws = options.quick ? 60 : 600;
  experiment::Table table(
      {"object", "slips", "errors that keep", "left of a frame's error", "right", "chance stated"});
  const auto objects =
      options.quick ? std::vector<std::string>{"box"} : geometry::built_in_objects();
  for (const auto& name : objects) {
    const Subject subject(name);
    for (const int before : {kBefore, 0}) {
      const Averaging averaged = averaging(before);
      std::vector<Outcome> outcomes(count);
      parallel_for(count, options.threads, [&](std::size_t i) {
        outcomes[i] =
            slip_once(subject, averaged, draws, RandomStream(options.seed + i, "slip bound"));
      });
      double right = 0, stated = 0;
      for (const Outcome& outcome : outcomes) {
        right += outcome.right;
        stated += outcome.mass;
      }
      const auto n = static_cast<double>(count);
      table.add_row({name, fmt::format("{}", count), before > 0 ? "known from before" : "unknown",
                     fmt::format("{:.2f}", std::sqrt(averaged.variance)),
                     fmt::format("{:.2f}", right / n), fmt::format("{:.2f}", stated / n)});
    }
    fmt::print(stderr, "{} done\n", name);
  }
  table.publish(options, "slip_bound",
                "Poses within 5 deg and 10 mm .2 s after a slip of 5 mm and 10 deg, at best");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "localization_slip_bound",
                         "How well a pose can be known .2 s after a slip, by an observer that "
                         "knows all but the slip and the noise",
                         slip_bound);
}
