// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/information/guarded_move_choice.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "palpate/core/se3.hpp"
#include "palpate/localization/consensus.hpp"

namespace palpate::localization {
namespace {

constexpr double kStep = 0.003;           // m of a way between places that are looked at
constexpr double kReportedApart = 0.010;  // m between ends that are distinguished
constexpr double kMinWeight = 0.002;      // of a pose of one of several objects that is looked at
constexpr double kNeglected = 0.05;       // of the posterior, that no pose which is looked at has
constexpr double kBeside = 0.003;         // m by which the finger may pass elsewhere
constexpr double kGuard = 0.002;          // m that the rest of the finger is to stay away
/// m by which the distance field may be off between its nodes, at most: their distance from the
/// middle of a cell of 2 mm and the corrections by the gradients along three axes.
constexpr double kFieldError = 0.0035;

// Of the errors that a refining move is chosen by; angles in rad, lengths in m.
constexpr double kPointSigma = 0.0008, kNormalSigma = 0.13, kOffsetSigma = 0.0025;
constexpr double kTiltSigma = 0.02, kHeightSigma = 0.001, kFarSigma = 0.1;
constexpr double kTightAngle = 0.0436, kTightDistance = 0.0035;

using localization::FreeSphere;

/// Where a guarded move ends for the object at one pose.
enum class Ending { touch, nothing, blocked };
struct MoveOutcome {
  Ending ending = Ending::nothing;
  double way = 0;  ///< m
};

/// Balls of the probing finger on their way past the object at one pose.
class PassingBalls {
 public:
  PassingBalls(const geometry::ObjectModel& object, const Eigen::Isometry3d& T_object_world,
               const std::vector<FreeSphere>& balls, double margin)
      : object_(object), T_object_world_(T_object_world), balls_(balls), margin_(margin) {
    clear_until_.assign(balls.size(), 0);
  }

  /// Whether one of them is within the margin of the object, the finger at `at`, `way` from where
  /// it began; it only goes forward.
  bool meet(const Eigen::Vector3d& at, double way) {
    for (std::size_t i = 0; i < balls_.size(); ++i) {
      if (way < clear_until_[i]) continue;
      const Eigen::Vector3d p = T_object_world_ * (at + balls_[i].center);
      const double distance = field().distance(p.cast<float>());
      const double near = balls_[i].radius + margin_;
      if (distance < field().beyond() && distance < near) return true;
      clear_until_[i] = way + min_distance(p, distance) - near - kFieldError;
    }
    return false;
  }

 private:
  [[nodiscard]] const geometry::DistanceField& field() const { return object_.field(); }

  /// Of p from the object, by the field's distance there.
  [[nodiscard]] double min_distance(const Eigen::Vector3d& p, double distance) const {
    if (distance < field().beyond()) return distance - kFieldError;
    return object_.bounds().cast<double>().exteriorDistance(p);
  }

  const geometry::ObjectModel& object_;
  const Eigen::Isometry3d& T_object_world_;
  const std::vector<FreeSphere>& balls_;
  double margin_;
  std::vector<double> clear_until_;  // the way that each goes at least before it is near again, m
};

MoveOutcome outcome(const geometry::ObjectModel& object, const Eigen::Isometry3d& T_object_world,
                    const ProbingFinger& finger, const GuardedMove& guarded_move) {
  const double length = (guarded_move.to - guarded_move.from).norm();
  PassingBalls rest(object, T_object_world, finger.rest, kGuard);
  PassingBalls tip(object, T_object_world, finger.tip, 0);
  for (double way = 0; way <= length; way += kStep) {
    const Eigen::Vector3d at =
        guarded_move.from + way / length * (guarded_move.to - guarded_move.from);
    if (rest.meet(at, way)) return {Ending::blocked, way};
    if (tip.meet(at, way)) return {Ending::touch, way};
  }
  return {Ending::nothing, length};
}

/// A way that ends without a touch of the tip shows only how far the tip came.
double reported_apart(const MoveOutcome& a, const MoveOutcome& b) {
  if (a.ending != Ending::touch && b.ending != Ending::touch) return 0;
  return std::min(1.0, std::abs(a.way - b.way) / kReportedApart);
}

/// An object at a pose that it may have.
struct WeightedObject {
  const geometry::ObjectModel* object;
  Eigen::Isometry3d T_object_world;
  double weight;
};

std::vector<WeightedObject> weighted_objects(const std::vector<PosedObject>& objects) {
  std::vector<WeightedObject> all;
  for (const PosedObject& posed : objects) {
    for (const WeightedPose& pose : poses_of(posed.posterior)) {
      if (objects.size() > 1 && pose.weight < kMinWeight) continue;
      all.push_back({posed.object, pose.T.inverse(), pose.weight});
    }
  }
  return all;
}

/// Probability that two draws from the poses are distinguished, where the finger goes just as it is
/// meant to.
double ideal_information(const std::vector<WeightedObject>& poses, const ProbingFinger& finger,
                         const GuardedMove& guarded_move) {
  std::vector<MoveOutcome> outcomes;
  for (const auto& pose : poses) {
    outcomes.push_back(outcome(*pose.object, pose.T_object_world, finger, guarded_move));
  }
  double sum = 0;
  for (std::size_t i = 0; i < outcomes.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      sum += 2 * poses[i].weight * poses[j].weight * reported_apart(outcomes[i], outcomes[j]);
    }
  }
  return sum;
}

/// The guarded move, and four beside it that the finger may make instead.
constexpr std::size_t kWays = 5;
std::array<GuardedMove, kWays> ways_of(const GuardedMove& guarded_move) {
  const Eigen::Matrix3d across = frame_with_z((guarded_move.to - guarded_move.from).normalized());
  std::array<GuardedMove, kWays> ways;
  for (std::size_t i = 0; i < kWays; ++i) {
    const double side = i == 0 ? 0 : i % 2 == 0 ? kBeside : -kBeside;
    const Eigen::Vector3d shift = side * across.col(i < 3 ? 0 : 1);
    ways[i] = {guarded_move.from + shift, guarded_move.to + shift};
  }
  return ways;
}

using Outcomes = std::array<MoveOutcome, kWays>;

/// Mean difference between an outcome of one pose and one of another.
double mean_apart(const Outcomes& a, const Outcomes& b) {
  double sum = 0;
  for (const MoveOutcome& one : a) {
    for (const MoveOutcome& other : b) sum += reported_apart(one, other);
  }
  return sum / static_cast<double>(kWays * kWays);
}

/// Probability that two draws from the poses are distinguished, by how much more the outcomes of
/// two poses differ than those of either alone (energy distance): where the finger grazes the
/// object, chance decides.
double information(const std::vector<WeightedObject>& poses, const ProbingFinger& finger,
                   const GuardedMove& guarded_move) {
  const auto ways = ways_of(guarded_move);
  std::vector<Outcomes> outcomes(poses.size());
  std::vector<double> by_chance;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (std::size_t k = 0; k < kWays; ++k) {
      outcomes[i][k] = outcome(*poses[i].object, poses[i].T_object_world, finger, ways[k]);
    }
    by_chance.push_back(mean_apart(outcomes[i], outcomes[i]));
  }
  double sum = 0;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const double apart = mean_apart(outcomes[i], outcomes[j]) - (by_chance[i] + by_chance[j]) / 2;
      sum += 2 * poses[i].weight * poses[j].weight * std::max(0.0, apart);
    }
  }
  return sum;
}

using Matrix9d = Eigen::Matrix<double, 9, 9>;  // of [rotation; translation; offset]

/// What is known of a resting object's pose and of the fingertip's offset before any touch.
Matrix9d information_before() {
  Eigen::Matrix<double, 9, 1> sigmas;
  sigmas << kTiltSigma, kTiltSigma, 1, kFarSigma, kFarSigma, kHeightSigma, kOffsetSigma,
      kOffsetSigma, kOffsetSigma;
  return sigmas.cwiseAbs2().cwiseInverse().asDiagonal();
}

/// What a guarded move's touch would add; nothing where it ends without one.
std::optional<Matrix9d> information_of(const geometry::ObjectModel& object,
                                       const Eigen::Isometry3d& T_world_object,
                                       const ProbingFinger& finger,
                                       const GuardedMove& guarded_move) {
  const Eigen::Isometry3d T_object_world = T_world_object.inverse();
  const MoveOutcome end = outcome(object, T_object_world, finger, guarded_move);
  if (end.ending != Ending::touch) return std::nullopt;
  const Eigen::Vector3d at =
      guarded_move.from + end.way * (guarded_move.to - guarded_move.from).normalized();
  std::optional<geometry::DistanceField::Sample> nearest;
  Eigen::Vector3d p = at;
  for (const FreeSphere& sphere : finger.tip) {
    const Eigen::Vector3d center = at + sphere.center;
    const auto sample = object.field().at((T_object_world * center).cast<float>());
    if (!sample || (nearest && sample->distance >= nearest->distance)) continue;
    nearest = sample;
    p = center;
  }
  if (!nearest) return std::nullopt;
  const Eigen::Vector3d n = T_world_object.linear() * nearest->gradient.cast<double>().normalized();
  Eigen::Matrix<double, 9, 1> row;
  row << (p - T_world_object.translation()).cross(n), n, -finger.R_world_mount.transpose() * n;
  Matrix9d information = row * row.transpose() / (kPointSigma * kPointSigma);
  information.topLeftCorner<3, 3>() +=
      (Eigen::Matrix3d::Identity() - n * n.transpose()) / (kNormalSigma * kNormalSigma);
  return information;
}

double spread_of(const Matrix9d& information) {
  const Matrix9d covariance = information.inverse();
  return covariance.topLeftCorner<3, 3>().trace() / (kTightAngle * kTightAngle) +
         covariance.block<3, 3>(3, 3).trace() / (kTightDistance * kTightDistance);
}

}  // namespace

std::optional<InformativeMove> most_informative_move(
    const geometry::ObjectModel& object, const localization::Posterior& posterior,
    const ProbingFinger& finger, const std::vector<GuardedMove>& guarded_moves) {
  return most_informative_move({{&object, posterior}}, finger, guarded_moves);
}

std::optional<InformativeMove> most_informative_move(
    const std::vector<PosedObject>& objects, const ProbingFinger& finger,
    const std::vector<GuardedMove>& guarded_moves) {
  const auto poses = weighted_objects(objects);
  std::vector<std::pair<double, std::size_t>> ideal;  // information and index
  for (std::size_t i = 0; i < guarded_moves.size(); ++i) {
    ideal.emplace_back(ideal_information(poses, finger, guarded_moves[i]), i);
  }
  std::stable_sort(ideal.begin(), ideal.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::optional<InformativeMove> best;
  for (const auto& [without_error, i] : ideal) {
    if (without_error <= (best ? best->information : 0.0)) break;  // an error rarely adds to it
    const double gained = information(poses, finger, guarded_moves[i]);
    if (gained <= (best ? best->information : 0.0)) continue;
    best = {guarded_moves[i], i, gained, gained / finger.seconds};
  }
  return best;
}

double clear_way(const std::vector<PosedObject>& objects, const ProbingFinger& finger,
                 const GuardedMove& guarded_move, double neglected) {
  std::map<double, double> weights;  // of the poses, by the way after which they are touched
  double total = 0;
  for (const auto& pose : weighted_objects(objects)) {
    weights[outcome(*pose.object, pose.T_object_world, finger, guarded_move).way] += pose.weight;
    total += pose.weight;
  }
  double nearer = 1 - total;  // of poses that are not among them
  double clear = 0;
  for (const auto& [way, weight] : weights) {
    if (nearer > neglected) break;
    nearer += weight;
    clear = way;
  }
  return clear;
}

double useful_way(const std::vector<PosedObject>& objects, const ProbingFinger& finger,
                  const GuardedMove& guarded_move) {
  double farthest = 0, total = 0;
  for (const auto& pose : weighted_objects(objects)) {
    const auto end = outcome(*pose.object, pose.T_object_world, finger, guarded_move);
    if (end.ending != Ending::nothing) farthest = std::max(farthest, end.way);
    total += pose.weight;
  }
  const bool all = farthest == 0 || 1 - total > kNeglected;
  return all ? (guarded_move.to - guarded_move.from).norm() : farthest;
}

std::optional<RefiningMove> most_refining_move(const geometry::ObjectModel& object,
                                               const Eigen::Isometry3d& T_world_object,
                                               const std::vector<ProbingFinger>& fingers,
                                               const std::vector<GuardedMove>& guarded_moves,
                                               const std::vector<TurnedMove>& done,
                                               double worthwhile) {
  Matrix9d known = information_before();
  for (const TurnedMove& guarded_move : done) {
    const auto gained = information_of(object, T_world_object, fingers[guarded_move.turn],
                                       guarded_move.guarded_move);
    if (gained) known += *gained;
  }
  const double before = spread_of(known);
  std::optional<RefiningMove> best;
  double best_rate = 0;  // per second
  for (std::size_t turn = 0; turn < fingers.size(); ++turn) {
    for (const GuardedMove& guarded_move : guarded_moves) {
      const auto gained = information_of(object, T_world_object, fingers[turn], guarded_move);
      if (!gained) continue;
      const double after = spread_of(known + *gained);
      if (after > worthwhile * before) continue;
      const double rate = (before - after) / fingers[turn].seconds;
      if (best && rate <= best_rate) continue;
      best = {{guarded_move, turn}, before, after};
      best_rate = rate;
    }
  }
  return best;
}

}  // namespace palpate::localization
