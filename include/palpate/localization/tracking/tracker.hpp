// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// Contacts and motion of the fingertips at one instant.
struct TrackFrame {
  double time = 0;  ///< s
  std::vector<tactile::Contact> contacts;
  std::vector<Eigen::Vector3d> velocities;  ///< of the fingertip at each contact, m/s
};

struct TrackerOptions {
  double correlation_time =
      0.5;  ///< s over which the correlated part of the contacts' errors keeps
  double correlated_share = 0.5;  ///< of the variance of these errors
  double sliding = 0.005;         ///< rms speed of a fingertip on the surface, m/s, at first
  double velocity_noise = 0.002;  ///< rms error of a fingertip's velocity per axis, m/s
  double turning = 0.5;           ///< rms turning that is expected beforehand, rad/s
  double moving = 0.03;           ///< and moving, m/s
  double false_contacts = 0.05;   ///< prior share
  double slip_jump = 1.8;         ///< rise of a contact's mean energy that indicates a slip
  double slip_angle = 0.1745;     ///< spread of the poses searched after it, rad
  double slip_distance = 0.005;   ///< and m
  int slip_poses = 40;            ///< started a frame while it is searched
  double slip_search = 0.3;       ///< s after a slip in which it is searched

  template <class Visitor>
  void visit(Visitor&& v) {
    v("correlation_time", correlation_time, 1e-3, 100.0, "s, correlation time of contact errors");
    v("correlated_share", correlated_share, 0.01, 1.0,
      "correlated share of the variance of contact errors");
    v("sliding", sliding, 0.0, 1.0, "m/s rms, speed of a fingertip on the surface");
    v("velocity_noise", velocity_noise, 1e-5, 1.0, "m/s rms, error of fingertip velocity per axis");
    v("turning", turning, 1e-3, 100.0, "rad/s rms, prior angular velocity of the object");
    v("moving", moving, 1e-4, 10.0, "m/s rms, prior velocity of the object");
    v("false_contacts", false_contacts, 1e-3, 0.9, "prior probability that a contact is spurious");
    v("slip_jump", slip_jump, 0.1, 100.0, "rise of a contact's mean energy that indicates a slip");
    v("slip_angle", slip_angle, 0.0, 3.2, "rad, spread of the poses searched after a slip");
    v("slip_distance", slip_distance, 0.0, 0.1, "m, spread of the poses searched after a slip");
    v("slip_poses", slip_poses, 1, 1000,
      "number of poses started per frame during the search after a slip");
    v("slip_search", slip_search, 0.0, 0.5, "s, duration of the search after a slip");
  }
};

/// Follows an object that moves with the fingers and may slip in them: an iterated extended Kalman
/// filter for each mode, weighed by how well it explains the contacts.
///
/// The twist comes from the fingertips' velocities, which stick up to `sliding`; errors of contacts
/// keep for `correlation_time`, so that a frame's likelihood counts to the power dt / 2 tau. A slip
/// shows as a jump of the contacts' energy. Then poses about those before it are corrected by the
/// mean of all contacts since, in every frame again, until there are enough of them to go on.
class Tracker {
 public:
  /// @throws BadInput for a posterior without modes
  Tracker(const geometry::ObjectModel& model, const Posterior& start,
          const TrackerOptions& options = {}, RandomStream random = RandomStream(0, "tracker"));

  /// The modes after the frame, heaviest first; at most 16. A mode's weight is the probability that
  /// the object is within 5 deg and 10 mm of it (of its arc, where it has a free axis).
  ///
  /// A frame that is no later than the one before changes nothing; one without contacts, or long
  /// after the one before, lets the poses grow uncertain.
  /// @throws BadInput for values that are not finite or as many velocities as there are contacts
  ///         not
  const Posterior& update(const TrackFrame& frame);

  const Posterior& posterior() const { return posterior_; }
  int slips() const { return slips_; }  ///< found so far

 private:
  struct Hypothesis {
    Eigen::Isometry3d T;
    Matrix6d covariance;
    double log_weight = 0;
    std::optional<FreeAxis> free_axis;  ///< carried along with the pose
    void move_to(const Eigen::Isometry3d& pose);
  };
  struct TwistFit {
    Vector6d twist;  ///< [w; v] of the object, v at the point about which it was fitted
    Matrix6d covariance;
  };
  /// Least squares on v_k = v + w x (p_k - about), held by what motion is expected.
  TwistFit fit_twist(const TrackFrame& frame, const Eigen::Vector3d& about) const;
  /// s^2, by which the variance of the twist goes into that of the pose.
  [[nodiscard]] double twist_error_growth(double dt) const;
  void predict(const TrackFrame& frame, double dt, double gap, Hypothesis& hypothesis) const;
  void learn_sliding(const TrackFrame& frame, double dt);
  void correct(const Evidence& evidence, double trust, const Eigen::Isometry3d& start,
               Hypothesis& hypothesis) const;
  void watch_for_slip(const Evidence& evidence);
  void remember(const TrackFrame& frame, const Eigen::Isometry3d& motion);
  void search_slip(const Evidence& evidence, double dt);
  void prune();
  void publish();

  [[nodiscard]] bool searching() const { return !before_slip_.empty(); }

  const geometry::ObjectModel& model_;
  TrackerOptions options_;
  RandomStream random_;
  std::vector<Hypothesis> hypotheses_;
  Posterior posterior_;
  double velocity_variance_;  // of a fingertip's velocity about that of the object there, per axis
  double time_ = 0;
  bool started_ = false;
  std::vector<double> energies_;  // per contact, of the last frames at the predicted pose
  std::vector<std::vector<tactile::Contact>> recent_;  // frames, carried along to the present
  std::vector<tactile::Contact> errors_before_;        // mean ones, of the frames before the slip
  std::vector<std::size_t> learnt_frames_;             // of each of them
  std::vector<Hypothesis> before_slip_;                // carried along, while a slip is searched
  double searched_ = 0;                                // s since it was noticed
  int slips_ = 0;
};

}  // namespace palpate::localization
