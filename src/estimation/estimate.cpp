// SPDX-License-Identifier: Apache-2.0
#include "palpate/estimation/estimate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "estimation/fallen.hpp"
#include "estimation/height_likelihood.hpp"
#include "estimation/log_evidence.hpp"
#include "estimation/prior_after_grasp.hpp"
#include "estimation/tracked_pose.hpp"
#include "palpate/core/error.hpp"
#include "palpate/estimation/height_probe.hpp"
#include "palpate/localization/sizes.hpp"

namespace palpate::estimation {
namespace {

/// Shares of the guarded moves that are forgotten, one after the other, while no pose explains the
/// rest: a touch may have moved the object.
constexpr std::array<double, 3> kForgotten = {0, 0.35, 0.55};
constexpr std::size_t kMinTouches = 4;  // that are then left
constexpr double kMoved = 0.02;         // prior probability that a touch has moved the object so
constexpr double kRuledOut = 1e-6;      // probability of a candidate that is not looked at again

const localization::ObjectHypothesis kImpossible{
    {}, -std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

using geometry::KnownObject;
using localization::Evidence;
using localization::TableSupport;

/// kg
double lightest(const Candidates& candidates) {
  double mass = std::numeric_limits<double>::infinity();
  for (const auto* candidate : candidates) mass = std::min(mass, candidate->object().mass);
  return mass;
}

localization::SizedCandidates objects_of(const Candidates& candidates) {
  localization::SizedCandidates objects;
  for (const auto* candidate : candidates) objects.push_back(&candidate->object());
  return objects;
}

/// Latest reading of a kind since the hand let go for good.
const hand::HandReading* reading_at(const EventLog& log, TouchEvent event) {
  const hand::HandReading* reading = nullptr;
  for (const auto& moment : log.since_release()) {
    if (moment.event == event) reading = &log.readings[moment.reading];
  }
  return reading;
}

/// Those for an object that may have fallen before it was touched.
EstimationOptions as_it_lay(const hand::Description& hand, const EventLog& log,
                            const EstimationOptions& options) {
  const auto* const probed = reading_at(log, TouchEvent::height_probed);
  if (!probed || !reading_at(log, TouchEvent::fallen)) return options;
  return of_fallen(options, place_under_hand(hand, *probed));
}

/// Likelihood of each stable pose by the measured height of the object; 1 if none was measured.
std::vector<double> height_likelihoods(const KnownObject& object, const hand::Description& hand,
                                       const EventLog& log, const EstimationOptions& options) {
  const auto* const probed = reading_at(log, TouchEvent::height_probed);
  if (!probed) return std::vector<double>(object.stable_poses.size(), 1.0);
  const EstimationOptions lay = as_it_lay(hand, log, options);
  return probed_height_likelihoods(object, hand, *probed, {lay.place, lay.resting_half_width},
                                   options.probed_height_sigma);
}

/// Probability of each stable pose, given the measured height of the object.
std::vector<double> stable_pose_weights(const KnownObject& object, const hand::Description& hand,
                                        const EventLog& log, const EstimationOptions& options) {
  std::vector<double> weights = height_likelihoods(object, hand, log, options);
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    weights[i] *= object.stable_poses[i].probability;
    sum += weights[i];
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    const double before = object.stable_poses[i].probability;
    weights[i] = (1 - options.other_stable_pose) * (sum > 0 ? weights[i] / sum : before) +
                 options.other_stable_pose * before;
  }
  return weights;
}

/// The table's frame below the object's rough place.
Eigen::Isometry3d table_at_place(const EventLog& log, const EstimationOptions& options) {
  return log.T_world_table * Eigen::Translation3d(options.place.x(), options.place.y(), 0);
}

/// The table under the object that nobody has moved yet. Misplaced links of the hand shift all that
/// it touches, so that height and place are uncertain by that much.
TableSupport resting_table(const KnownObject& object, const hand::Description& hand,
                           const EventLog& log, const EstimationOptions& options) {
  TableSupport table;
  table.T_frame_table = table_at_place(log, options);
  table.stable_pose_weights = stable_pose_weights(object, hand, log, options);
  table.tilt_sigma = options.resting_tilt_sigma;
  table.height_sigma = options.resting_height_sigma;
  table.centroid_sigma = options.centroid_sigma;
  table.half_width = options.resting_half_width;
  table.edge_sigma = 0.005;
  return table;
}

TableSupport table_at_closing(const KnownObject& object, const hand::Description& hand,
                              const EventLog& log, const EstimationOptions& options) {
  TableSupport table;
  const auto& closed = log.readings[*log.at(TouchEvent::closed)];
  table.T_frame_table = closed.mount.pose().inverse() * table_at_place(log, options);
  table.stable_pose_weights = stable_pose_weights(object, hand, log, options);
  table.tilt_sigma = options.tilt_sigma;
  table.height_sigma = options.height_sigma;
  table.centroid_sigma = options.centroid_sigma;
  table.half_width = options.half_width;
  table.edge_sigma = 0.01;
  return table;
}

/// Whether some pose of it explains what was sensed.
bool has_pose(const localization::ObjectHypothesis& hypothesis) {
  double sum = 0;
  for (const auto& mode : hypothesis.posterior.modes) sum += mode.weight;
  return sum > 0;
}

/// What the measured height says for the object itself, beside its stable poses.
void add_height(const KnownObject& object, const hand::Description& hand, const EventLog& log,
                const EstimationOptions& options, localization::ObjectHypothesis& hypothesis) {
  const auto likelihoods = height_likelihoods(object, hand, log, options);
  double likelihood = options.other_stable_pose;
  for (std::size_t i = 0; i < likelihoods.size(); ++i) {
    likelihood +=
        (1 - options.other_stable_pose) * object.stable_poses[i].probability * likelihoods[i];
  }
  hypothesis.log_evidence += std::log(likelihood);
  hypothesis.log_evidence_other += std::log(likelihood);
}

/// All moments up to the last one that bears on how the object rests.
std::vector<EventLog::Moment> moments_of_resting(const EventLog& log) {
  const auto bears = [](const EventLog::Moment& moment) {
    return moment.event == TouchEvent::height_probed || moment.event == TouchEvent::touched ||
           moment.event == TouchEvent::missed || moment.event == TouchEvent::fallen ||
           moment.event == TouchEvent::opened || moment.event == TouchEvent::released;
  };
  const auto last = std::find_if(log.moments.rbegin(), log.moments.rend(), bears);
  return {log.moments.begin(), last.base()};
}

/// No pose of any candidate explains all touches: either one of them has moved the object, or it is
/// another one, which may be unlike all candidates and explain the rest as well as they do.
void doubt(double other_before, localization::ObjectProbabilities& objects) {
  const double moved = (1 - other_before) * kMoved;
  const double share = moved / (moved + other_before);
  for (double& probability : objects.candidates) probability *= share;
  objects.other = 1 - share * (1 - objects.other);
}

/// At the end of the lift only: what is sensed later decides.
/// @param before_lift  in the hand's mount
/// @param probability  of the object
/// @param posterior  in the world
void compare_with_tracked(const GraspHistory& held, const localization::Posterior& before_lift,
                          double probability, localization::Posterior& posterior) {
  const auto lifts = held.log.all(TouchEvent::held);
  const auto lift = std::upper_bound(lifts.begin(), lifts.end(), held.closed);
  if (lift == lifts.end() || *lift != held.at) return;
  localization::Posterior tracked;
  tracked.modes = {track_best_mode(held, held.at, before_lift)};
  tracked.modes.front().weight = probability;
  transform(held.log.readings[held.at].mount.pose(), tracked);
  add_tracked_pose(tracked.modes.front(), held.model.object().symmetries, posterior);
}

}  // namespace

void transform(const Eigen::Isometry3d& T_new_old, localization::Posterior& posterior) {
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
  for (auto& T_frame_object : posterior.residual_set) T_frame_object = T_new_old * T_frame_object;
}

PoseEstimator::PoseEstimator(Candidates candidates, const EstimationOptions& options,
                             std::uint64_t seed)
    : candidates_(std::move(candidates)),
      options_(options),
      seed_(seed),
      ruled_out_(candidates_.size(), false) {
  if (candidates_.empty()) throw BadInput("an estimator of 0 candidates");
  const auto count = static_cast<double>(candidates_.size());
  for (const auto* model : candidates_) area_ += model->area() / count;
  probabilities_.candidates.assign(candidates_.size(), 1 / count);
}

/// One object is not weighed against others.
localization::ObjectHypothesis PoseEstimator::search(std::size_t candidate,
                                                     const Evidence& evidence,
                                                     std::string_view stream) const {
  const auto& model = *candidates_[candidate];
  const RandomStream random(seed_, stream);
  if (one()) return {localization::localize(model, evidence, random, options_.search)};
  return localization::hypothesis_of(model, evidence, random, options_.search, options_.identify);
}

std::vector<localization::Posterior> PoseEstimator::posteriors() const {
  std::vector<localization::Posterior> all;
  for (std::size_t i = 0; i < last_.size(); ++i) {
    all.push_back(localization::weighted(last_[i].posterior, probabilities_.candidates[i]));
  }
  return all;
}

/// Weighs the candidates against each other.
/// @return of the most probable shape
localization::Posterior PoseEstimator::conclude(const Hypotheses& hypotheses) {
  last_ = hypotheses;
  if (one()) {
    probabilities_.candidates = {1};
    probabilities_.probability = 1;
    probabilities_.size = object().object().size;
    return last_.front().posterior;
  }
  const localization::SizedCandidates objects = objects_of(candidates_);
  auto probabilities = localization::object_probabilities(last_, options_.identify);
  if (!all_touches_explained_) doubt(options_.identify.other, probabilities);
  localization::choose_shape(objects, probabilities);
  const bool explained = probabilities.candidates[probabilities.best] > 0;
  if (explained) probabilities_ = probabilities;
  for (std::size_t i = 0; explained && i < last_.size(); ++i) {
    ruled_out_[i] = probabilities_.candidates[i] < kRuledOut;
  }
  return localization::pooled(objects, probabilities_, posteriors());
}

double PoseEstimator::probable_top(const hand::Description& hand, const EventLog& log) const {
  double top = 0, greatest = 0;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const KnownObject& object = candidates_[i]->object();
    const auto likelihoods = height_likelihoods(object, hand, log, options_);
    for (std::size_t k = 0; k < likelihoods.size(); ++k) {
      const geometry::StablePose& stable_pose = object.stable_poses[k];
      const double weight = likelihoods[k] * stable_pose.probability * probabilities_.candidates[i];
      if (weight <= greatest) continue;
      greatest = weight;
      top = geometry::top_of(object, stable_pose);
    }
  }
  return top;
}

localization::Posterior PoseEstimator::resting(const hand::Description& hand, const EventLog& log) {
  auto moments = moments_of_resting(log);
  if (moments != moments_ || moments.empty()) {
    const bool released = log.since_release().size() < log.moments.size();
    if (released) ruled_out_.assign(candidates_.size(), false);
    resting_ = search_resting(hand, log);
    moments_ = std::move(moments);
  }
  return conclude(resting_);
}

PoseEstimator::Hypotheses PoseEstimator::search_resting(const hand::Description& hand,
                                                        const EventLog& log) {
  if (const auto before = log.before_opening()) {
    PoseEstimator past(*this);
    past.held(hand, *before, before->at(TouchEvent::placed));
    all_touches_explained_ = past.all_touches_explained_;
    return past.last_;
  }
  const std::size_t guarded_moves =
      log.all(TouchEvent::touched).size() + log.all(TouchEvent::missed).size();
  const EstimationOptions lay = as_it_lay(hand, log, options_);
  Hypotheses hypotheses(candidates_.size());
  all_touches_explained_ = true;
  for (const double forgotten : kForgotten) {
    const auto skipped = static_cast<std::size_t>(forgotten * static_cast<double>(guarded_moves));
    Evidence evidence =
        evidence_of_guarded_moves(hand, log, options_, lightest(candidates_), skipped);
    if (evidence.contacts.size() < (skipped > 0 ? kMinTouches : 1)) break;
    evidence.false_contact_share = options_.false_contacts;
    evidence.surface_sigma = options_.surface_sigma;
    evidence.penetration_sigma = options_.free_space_sigma;
    if (!one()) evidence.contact_area = area_;
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const KnownObject& object = candidates_[i]->object();
      evidence.table = resting_table(object, hand, log, lay);
      hypotheses[i] = ruled_out_[i] ? kImpossible : search(i, evidence, "locate resting");
      add_height(object, hand, log, options_, hypotheses[i]);
    }
    if (std::any_of(hypotheses.begin(), hypotheses.end(), has_pose)) break;
    all_touches_explained_ = false;
  }
  return hypotheses;
}

HeldPoseEstimate PoseEstimator::held(const hand::Description& hand, const EventLog& log,
                                     std::optional<std::size_t> at) {
  HeldPoseEstimate estimate;
  if (!at) return estimate;
  const bool closed = !log.all(TouchEvent::closed).empty();
  if (closed) resting(hand, log);
  if (closed && log.hangs_at(*at)) look_before_lift(hand, log);
  Hypotheses hypotheses;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    hypotheses.push_back(ruled_out_[i] ? kImpossible : hold(i, hand, log, *at, estimate.contacts));
  }
  const Eigen::Isometry3d T_world_mount = log.readings[*at].mount.pose();
  for (auto& hypothesis : hypotheses) transform(T_world_mount, hypothesis.posterior);
  estimate.posterior = conclude(hypotheses);
  const std::size_t best = probabilities_.best;
  if (closed && log.hangs_at(*at) && has_pose(before_lift_[best])) {
    compare_with_tracked({*candidates_[best], hand, log, *closed_at_, *at, options_, seed_},
                         before_lift_[best].posterior, probabilities_.probability,
                         estimate.posterior);
  }
  for (auto& contact : estimate.contacts) transform(T_world_mount, contact);
  return estimate;
}

/// In the hand that had closed, with what was sensed of it until the lift.
void PoseEstimator::look_before_lift(const hand::Description& hand, const EventLog& log) {
  const std::size_t closed = log.all(TouchEvent::closed).back();
  if (closed_at_ == closed) return;
  const EventLog past = log.until(TouchEvent::closed);
  before_lift_.clear();
  std::vector<tactile::Contact> contacts;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    before_lift_.push_back(ruled_out_[i] ? kImpossible : hold(i, hand, past, closed, contacts));
  }
  closed_at_ = closed;
}

/// The pose in the hand if it is a candidate, in the hand's mount.
localization::ObjectHypothesis PoseEstimator::hold(std::size_t candidate,
                                                   const hand::Description& hand,
                                                   const EventLog& log, std::size_t at,
                                                   std::vector<tactile::Contact>& contacts) const {
  const KnownObject& object = candidates_[candidate]->object();
  Evidence evidence = evidence_in_hand(hand, log, {at, log.hangs_at(at)}, object.mass, options_);
  if (!one()) evidence.contact_area = area_;
  localization::ObjectHypothesis before;
  if (const auto closed = log.all(TouchEvent::closed); !closed.empty()) {
    before = resting_[candidate];
    auto& resting = before.posterior;
    const bool any = std::any_of(resting_.begin(), resting_.end(), has_pose);
    if (any && !has_pose(before)) return kImpossible;
    if (!any) {
      before.log_evidence = before.log_evidence_other = 0;  // it says nothing of any
      evidence.table = table_at_closing(object, hand, log, options_);
    } else {
      GraspHistory held{*candidates_[candidate], hand, log, closed.front(), at, options_, seed_};
      evidence.prior = prior_after_grasp(held, resting);
      if (log.hangs_at(at) && has_pose(before_lift_[candidate])) {
        held.closed = closed.back();
        evidence.prior =
            either_of(*evidence.prior, prior_after_lift(held, before_lift_[candidate].posterior));
      }
    }
  }
  auto hypothesis = search(candidate, evidence, "locate");
  hypothesis.log_evidence += before.log_evidence;
  hypothesis.log_evidence_other += before.log_evidence_other;
  contacts = std::move(evidence.contacts);
  return hypothesis;
}

}  // namespace palpate::estimation
