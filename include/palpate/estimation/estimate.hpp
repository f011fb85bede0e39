// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "palpate/estimation/event_log.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/localization/identification.hpp"
#include "palpate/tactile/contacts/contact_window.hpp"

namespace palpate::estimation {

struct EstimationOptions {
  /// Rough place of the object on the table before it is touched, m. Not an option of the program.
  Eigen::Vector2d place = Eigen::Vector2d::Zero();
  tactile::ContactErrorModel errors;
  double window = 0.5;                  ///< s of readings, before the event, that are averaged
  double probed_height_sigma = 0.005;   ///< of the measured height, m
  double resting_height_sigma = 0.001;  ///< of the resting object, m
  double resting_tilt_sigma = 0.02;     ///< of the resting object from its stable pose, rad
  double free_space_sigma = 0.003;  ///< of the place of the space that a guarded move found free, m
  double resting_half_width =
      0.045;  ///< object within +- of its rough place before it is touched, m
  double motion_angle_sigma = 0.009;  ///< by which the grasp turns the object in the hand, rad
  double slide_share =
      0.2;  ///< probability that it slid three times as far, and that much of it again
  double probe_motion = 0.001;       ///< of the object while a finger probes it, m
  double table_touch_sigma = 0.001;  ///< of where a held object touches the table, m
  double elsewhere = 0.02;           ///< probability that the resting pose was wrong
  double motion_sigma = 0.0005;      ///< by which the grasp moves the object in the hand, m
  double other_stable_pose =
      0.03;                  ///< probability that the grasp put the object into another stable pose
  double tilt_sigma = 0.30;  ///< by which the closing hand tilts the object, rad
  double height_sigma = 0.015;    ///< by which it raises the object, m
  double half_width = 0.08;       ///< object within +- of its rough place after the grasp, m
  double surface_sigma = 0.0005;  ///< by which the mesh's surface is off the object's, m
  double centroid_sigma = 0.003;  ///< by which its centre of mass is off along each axis, m
  double false_contacts = 0.02;   ///< prior share of contacts with something else
  bool balance = false;           ///< use that pushes and weight balance, once the object hangs
  double torsional_friction_radius =
      0.003;                         ///< m, unsensed moment about a contact's normal by its force
  bool free_space = true;            ///< use that the hand's links do not penetrate the object
  double penetration_sigma = 0.004;  ///< m
  /// By default the hand's contacts have errors of 0.5 mm and more, so that this changes nothing.
  localization::LocalizerOptions search{.first_point_sigma = 0.0015};
  localization::IdentificationOptions identify;  ///< which of several objects it is

  template <class Visitor>
  void visit(Visitor&& v) {
    v("window", window, 0.01, 10.0, "s, window over which readings are averaged");
    v.expert("probed_height_sigma", probed_height_sigma, 1e-4, 0.1,
             "m, error of the measured height");
    v.expert("resting_height_sigma", resting_height_sigma, 1e-4, 0.1,
             "m, error of the resting object's height");
    v.expert("resting_tilt_sigma", resting_tilt_sigma, 1e-4, 1.0,
             "rad, tilt of the resting object from its stable pose");
    v.expert("free_space_sigma", free_space_sigma, 1e-4, 0.1,
             "m, error of the space that guarded moves found free");
    v.expert("resting_half_width", resting_half_width, 0.0, 0.3,
             "m, half width of the prior on the resting object's position");
    v.expert("slide_share", slide_share, 0.0, 0.9,
             "probability that the object slid three times as far in the grasp as expected");
    v.expert("probe_motion", probe_motion, 0.0, 0.05,
             "m, motion of the object while a finger probes it");
    v.expert("table_touch_sigma", table_touch_sigma, 1e-5, 0.1,
             "m, error of the height at which the held object touches the table");
    v.expert("elsewhere", elsewhere, 1e-6, 0.9,
             "probability that the estimated resting pose was wrong");
    v.expert("motion_angle_sigma", motion_angle_sigma, 1e-4, 3.0,
             "rad, rotation of the object in the grasp");
    v.expert("motion_sigma", motion_sigma, 1e-5, 0.2, "m, motion of the object in the grasp");
    v.expert("other_stable_pose", other_stable_pose, 0.0, 1.0,
             "probability that the grasp changed the stable pose");
    v.expert("tilt_sigma", tilt_sigma, 1e-3, 1.0,
             "rad, by which the closing hand tilts the object");
    v.expert("height_sigma", height_sigma, 1e-4, 0.1,
             "m, by which the closing hand raises the object");
    v.expert("surface_sigma", surface_sigma, 0.0, 0.01, "m, error of the mesh's surface");
    v.expert("centroid_sigma", centroid_sigma, 0.0, 0.1,
             "m, error of the object's centre of mass along each axis");
    v.expert("half_width", half_width, 0.0, 0.3,
             "m, half width of the prior on the position of an object that was grasped unexplored");
    v("false_contacts", false_contacts, 1e-6, 0.9, "prior probability that a contact is spurious");
    v("balance", balance,
      "use as evidence that the finger forces balance the weight of the held object");
    v.expert("torsional_friction_radius", torsional_friction_radius, 0.0, 0.1,
             "m, unsensed moment about a contact's normal, relative to its force");
    v("free_space", free_space,
      "use as evidence that the hand's links do not penetrate the object");
    v.expert("penetration_sigma", penetration_sigma, 1e-4, 0.05, "m, error of the hand's surface");
    v.section("errors", errors);
    v.section("search", search);
    v.expert_section("identify", identify);
  }
};

/// Expresses a posterior in another frame.
void transform(const Eigen::Isometry3d& T_new_old, localization::Posterior& posterior);

/// What is known of the object's pose when it hangs in the hand.
struct HeldPoseEstimate {
  localization::Posterior posterior;       ///< in the world, at the instant
  std::vector<tactile::Contact> contacts;  ///< it was made from, in the world
};

/// Objects of which the one that is touched may be any; kept by reference.
using Candidates = std::vector<const geometry::ObjectModel*>;

/// Estimates an object's pose from what a hand has sensed, and from nothing else. Where it may be
/// one of several objects, the estimate is the posterior of the most probable one, its weights
/// times the probability that it is that object: all that the poses lack of 1 is elsewhere or of
/// others. Candidates that are one shape in several sizes count as one object of unknown size.
class PoseEstimator {
 public:
  /// @param object  kept by reference
  PoseEstimator(const geometry::ObjectModel& object, const EstimationOptions& options,
                std::uint64_t seed)
      : PoseEstimator(Candidates{&object}, options, seed) {}

  /// @throws BadInput for no candidates
  PoseEstimator(Candidates candidates, const EstimationOptions& options, std::uint64_t seed);

  /// How the object lies on the table: from the measured height and the touches of a fingertip, or,
  /// where the hand has opened around it since, from the grasp before. Searched for once as long as
  /// the log has nothing new about it.
  /// @return in the world; status no_pose if the log has no touch
  localization::Posterior resting(const hand::Description& hand, const EventLog& log);

  /// m above the table of the highest point of the object in its most probable stable pose, given
  /// the height in which the hand was stopped, over all candidates.
  [[nodiscard]] double probable_top(const hand::Description& hand, const EventLog& log) const;

  /// The pose in the hand at an instant. Contacts are those of the held object, with those that
  /// probes have found; the table supported it when the fingers had closed; the measured height
  /// weighs its stable poses. All is expressed in the hand's mount, in which the object rests.
  /// @param at  reading of the log; all of the log counts, before and after it
  /// @return status no_pose for no instant, as EventLog::at() gives for what has not happened
  HeldPoseEstimate held(const hand::Description& hand, const EventLog& log,
                        std::optional<std::size_t> at);

  /// The most probable object by the last estimate; before any, the first candidate.
  [[nodiscard]] const geometry::ObjectModel& object() const {
    return *candidates_[probabilities_.best];
  }
  [[nodiscard]] const Candidates& candidates() const { return candidates_; }
  /// Which object it is, by the last estimate; equally probable before any.
  [[nodiscard]] const localization::ObjectProbabilities& probabilities() const {
    return probabilities_;
  }
  /// The posterior of each candidate by the last estimate, its weights times the object's
  /// probability; resting() in the world, of held() too.
  [[nodiscard]] std::vector<localization::Posterior> posteriors() const;
  [[nodiscard]] const EstimationOptions& options() const { return options_; }
  [[nodiscard]] std::uint64_t seed() const { return seed_; }

 private:
  using Hypotheses = std::vector<localization::ObjectHypothesis>;

  Hypotheses search_resting(const hand::Description& hand, const EventLog& log);
  localization::ObjectHypothesis search(std::size_t candidate,
                                        const localization::Evidence& evidence,
                                        std::string_view stream) const;
  localization::ObjectHypothesis hold(std::size_t candidate, const hand::Description& hand,
                                      const EventLog& log, std::size_t at,
                                      std::vector<tactile::Contact>& contacts) const;
  void look_before_lift(const hand::Description& hand, const EventLog& log);
  localization::Posterior conclude(const Hypotheses& hypotheses);
  [[nodiscard]] bool one() const { return candidates_.size() == 1; }

  Candidates candidates_;
  EstimationOptions options_;
  std::uint64_t seed_;
  double area_ = 0;                        // of the candidates' surfaces, on average, m^2
  std::vector<EventLog::Moment> moments_;  // that the last resting pose is from
  std::optional<std::size_t> closed_at_;   // reading that before_lift_ is of
  Hypotheses before_lift_;                 // in the closed hand, in its mount
  Hypotheses resting_, last_;              // last: of the last estimate, in the world
  bool all_touches_explained_ = true;      // by one pose of a candidate
  std::vector<bool> ruled_out_;            // candidates that are not searched for any more
  localization::ObjectProbabilities probabilities_;
};

}  // namespace palpate::estimation
