// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "estimation/fallen.hpp"
#include "estimation/in_hand_motion.hpp"
#include "estimation/log_evidence.hpp"
#include "palpate/estimation/height_probe.hpp"
#include "palpate/localization/pose_prior.hpp"

namespace palpate::estimation {
namespace {

constexpr int kSlides = 2;             // how often a grasp may slide, each time
constexpr double kFarther = 3.0;       // so many times as far
constexpr double kBesideTheTop = 0.1;  // chance
constexpr double kToldError = 0.25;  // of the motion in the hand that the fingertips tell of, sigma
constexpr double kStirred = 3.0;     // so many times as far, where it was rolled or grasped again
/// Shares of the guarded moves that are forgotten, one after the other, while no pose explains the
/// rest: a touch may have moved the object.
constexpr std::array<double, 3> kForgotten = {0, 0.35, 0.55};
constexpr std::size_t kMinTouches = 4;  // that are then left

using geometry::KnownObject;
using localization::Evidence;
using localization::PosePrior;
using localization::TableSupport;

double top_of(const KnownObject& object, const geometry::StablePose& stable_pose) {
  double top = -std::numeric_limits<double>::infinity();
  for (const auto& vertex : object.mesh.vertices) {
    top = std::max(top, stable_pose.R_table_object.row(2).dot(vertex));
  }
  return top + stable_pose.height;
}

/// Likelihood of a felt height (m) where the object's top is `top`: the flat hand may have come
/// down beside what is highest of it.
double felt_likelihood(double felt, double top, const EstimationOptions& options) {
  const double miss = (top - felt) / options.felt_sigma;
  const double beside = miss > 0 ? kBesideTheTop : 0;
  return (1 - kBesideTheTop) * std::exp(-0.5 * miss * miss) + beside;
}

/// Probability of each stable pose, given how tall the object felt.
std::vector<double> stable_pose_weights(const KnownObject& object,
                                        std::optional<double> felt_height,
                                        const EstimationOptions& options) {
  std::vector<double> weights;
  double sum = 0;
  for (const auto& stable_pose : object.stable_poses) {
    const double felt =
        felt_height ? felt_likelihood(*felt_height, top_of(object, stable_pose), options) : 1.0;
    weights.push_back(stable_pose.probability * felt);
    sum += weights.back();
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double felt = sum > 0 ? weights[i] / sum : object.stable_poses[i].probability;
    weights[i] = (1 - options.other_stable_pose) * felt +
                 options.other_stable_pose * object.stable_poses[i].probability;
  }
  return weights;
}

/// Latest reading of a kind since the hand let go for good.
const hand::HandReading* reading_at(const EventLog& log, TouchEvent mark) {
  const hand::HandReading* reading = nullptr;
  for (const auto& moment : log.since_release()) {
    if (moment.mark == mark) reading = &log.readings[moment.reading];
  }
  return reading;
}

std::optional<double> felt_height(const hand::Description& hand, const EventLog& log) {
  const auto* const felt = reading_at(log, TouchEvent::felt);
  if (!felt) return std::nullopt;
  return lowest_of_hand(hand, *felt);
}

/// Those for an object that may have fallen before it was felt.
EstimationOptions as_it_lay(const hand::Description& hand, const EventLog& log,
                            const EstimationOptions& options) {
  const auto* const felt = reading_at(log, TouchEvent::felt);
  if (!felt || !reading_at(log, TouchEvent::fallen)) return options;
  return of_fallen(options, place_under_hand(hand, *felt));
}

/// The table's frame below the object's rough place.
Eigen::Isometry3d table_at_place(const EventLog& log, const EstimationOptions& options) {
  return log.T_world_table * Eigen::Translation3d(options.place.x(), options.place.y(), 0);
}

/// The table under the object that nobody has moved yet. Misplaced links of the hand shift all that
/// it feels, so that height and place are uncertain by that much.
TableSupport resting_table(const KnownObject& object, const hand::Description& hand,
                           const EventLog& log, const EstimationOptions& options) {
  TableSupport table;
  table.T_frame_table = table_at_place(log, options);
  table.stable_pose_weights = stable_pose_weights(object, felt_height(hand, log), options);
  table.tilt_sigma = options.resting_tilt_sigma;
  table.height_sigma = options.resting_height_sigma;
  table.half_width = options.resting_half_width;
  table.edge_sigma = 0.005;
  return table;
}

TableSupport table_at_closing(const KnownObject& object, const hand::Description& hand,
                              const EventLog& log, const EstimationOptions& options) {
  TableSupport table;
  const auto& closed = log.readings[*log.at(TouchEvent::closed)];
  table.T_frame_table = closed.base.pose().inverse() * table_at_place(log, options);
  table.stable_pose_weights = stable_pose_weights(object, felt_height(hand, log), options);
  table.tilt_sigma = options.tilt_sigma;
  table.height_sigma = options.height_sigma;
  table.half_width = options.half_width;
  table.edge_sigma = 0.01;
  return table;
}

double total_weight(const localization::Posterior& posterior) {
  double sum = 0;
  for (const auto& mode : posterior.modes) sum += mode.weight;
  return sum;
}

/// How far the fingertips say that the object has moved in the hand.
struct ToldMotion {
  double turn = 0, way = 0;  ///< rad, m
};

ToldMotion told_motion(const Eigen::Isometry3d& motion, const Eigen::Vector3d& p) {
  return {Eigen::AngleAxisd(motion.linear()).angle(), (motion * p - p).norm()};
}

/// By how much closing, pressing and lifting move the object in the hand, times `scale`, beside
/// what the fingertips tell of that motion, which is off by a share of itself.
Matrix6d motion_covariance(const EstimationOptions& options, const ToldMotion& told, double scale) {
  const double turn = scale * std::hypot(options.motion_angle_sigma, kToldError * told.turn);
  const double way = scale * std::hypot(options.motion_sigma, kToldError * told.way);
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(turn * turn), Eigen::Vector3d::Constant(way * way);
  return variance.asDiagonal();
}

/// Share of the peak density that spreads the probability `elsewhere` over all poses.
double floor_density(const PosePrior& prior, double elsewhere) {
  constexpr double kPoses = 8 * std::numbers::pi * std::numbers::pi * 1e-3;  // 1 dm^3, rad^3 m^3
  double peak = 0;
  for (const auto& component : prior.components) {
    const double volume =
        std::sqrt(std::pow(2 * std::numbers::pi, 6) * component.covariance.determinant());
    peak = std::max(peak, component.weight / volume);
  }
  return std::min(0.5, elsewhere / kPoses / peak);
}

/// The resting pose seen from the hand, after a grasp that mostly moved the object a little.
/// @param scale  of that motion
PosePrior prior_after_grasp(const localization::Posterior& resting, const ToldMotion& told,
                            const EstimationOptions& options, double scale) {
  PosePrior prior;
  double share = 1;
  for (int slides = 0; slides <= kSlides; ++slides) {
    PosePrior part = localization::prior_from(resting, motion_covariance(options, told, scale));
    const double stays = slides < kSlides ? 1 - options.slide_share : 1;
    for (auto& component : part.components) component.weight *= share * stays;
    prior.components.insert(prior.components.end(), part.components.begin(), part.components.end());
    share *= options.slide_share;
    scale *= kFarther;
  }
  std::stable_sort(prior.components.begin(), prior.components.end(),
                   [](const auto& a, const auto& b) { return a.weight > b.weight; });
  prior.floor = floor_density(prior, options.elsewhere);
  return prior;
}

/// All moments up to the last one that tells how the object rests.
std::vector<EventLog::Moment> moments_of_resting(const EventLog& log) {
  const auto tells = [](const EventLog::Moment& moment) {
    return moment.mark == TouchEvent::felt || moment.mark == TouchEvent::touched ||
           moment.mark == TouchEvent::missed || moment.mark == TouchEvent::fallen ||
           moment.mark == TouchEvent::opened || moment.mark == TouchEvent::released;
  };
  const auto last = std::find_if(log.moments.rbegin(), log.moments.rend(), tells);
  return {log.moments.begin(), last.base()};
}

}  // namespace

void move(const Eigen::Isometry3d& T_new_old, localization::Posterior& posterior) {
  Matrix6d turn = Matrix6d::Zero();
  turn.topLeftCorner<3, 3>() = T_new_old.linear();
  turn.bottomRightCorner<3, 3>() = T_new_old.linear();
  for (auto& mode : posterior.modes) {
    mode.T_frame_object = T_new_old * mode.T_frame_object;
    mode.covariance = turn * mode.covariance * turn.transpose();
    if (mode.free_axis) {
      mode.free_axis->point = T_new_old * mode.free_axis->point;
      mode.free_axis->direction = T_new_old.linear() * mode.free_axis->direction;
    }
  }
  for (auto& T_frame_object : posterior.further) T_frame_object = T_new_old * T_frame_object;
}

localization::Posterior PoseEstimator::resting(const hand::Description& hand, const EventLog& log) {
  auto moments = moments_of_resting(log);
  if (moments != moments_ || moments.empty()) {
    resting_ = search_resting(hand, log);
    moments_ = std::move(moments);
  }
  return resting_;
}

localization::Posterior PoseEstimator::search_resting(const hand::Description& hand,
                                                      const EventLog& log) {
  if (const auto before = log.before_opening()) {
    return PoseEstimator(*this).held(hand, *before, before->at(TouchEvent::placed)).posterior;
  }
  const std::size_t guarded_moves =
      log.all(TouchEvent::touched).size() + log.all(TouchEvent::missed).size();
  localization::Posterior posterior;
  for (const double forgotten : kForgotten) {
    const auto skipped = static_cast<std::size_t>(forgotten * static_cast<double>(guarded_moves));
    Evidence evidence = evidence_of_guarded_moves(hand, log, options_, skipped);
    if (evidence.contacts.size() < (skipped > 0 ? kMinTouches : 1)) break;
    evidence.false_contact_share = options_.false_contacts;
    evidence.surface_sigma = options_.surface_sigma;
    evidence.penetration_sigma = options_.swept_sigma;
    evidence.table = resting_table(object_.object(), hand, log, as_it_lay(hand, log, options_));
    posterior = localization::localize(object_, evidence, RandomStream(seed_, "locate resting"),
                                       options_.search);
    if (total_weight(posterior) > 0) break;
  }
  return posterior;
}

HeldPoseEstimate PoseEstimator::held(const hand::Description& hand, const EventLog& log,
                                     std::optional<std::size_t> at) {
  HeldPoseEstimate estimate;
  if (!at) return estimate;
  Evidence evidence =
      evidence_in_hand(hand, log, {*at, log.hangs_at(*at)}, object_.object().mass, options_);
  if (const auto closed = log.all(TouchEvent::closed); !closed.empty()) {
    auto resting = this->resting(hand, log);
    if (total_weight(resting) <= 0) {
      evidence.table = table_at_closing(object_.object(), hand, log, options_);
    } else {
      const auto motion = in_hand_motion(hand, log, closed.front(), *at, options_.errors);
      move(log.readings[closed.front()].base.pose().inverse(), resting);
      const auto told = told_motion(motion, resting.modes.front().T_frame_object.translation());
      move(motion, resting);
      const bool stirred = log.has_opened() || log.at(TouchEvent::rolled);
      evidence.prior = prior_after_grasp(resting, told, options_, stirred ? kStirred : 1.0);
    }
  }
  estimate.posterior =
      localization::localize(object_, evidence, RandomStream(seed_, "locate"), options_.search);
  estimate.contacts = evidence.contacts;
  const Eigen::Isometry3d T_world_base = log.readings[*at].base.pose();
  move(T_world_base, estimate.posterior);
  for (auto& contact : estimate.contacts) move(T_world_base, contact);
  return estimate;
}

}  // namespace palpate::estimation
