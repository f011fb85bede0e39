// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace palpate::simulation {

/// Noise of the readers, per reading (conventions: "Readers add seeded noise by default").
struct SensorNoise {
  double point = 0.001;                 ///< m, per axis
  double normal = 0.17453292519943295;  ///< rad, per tangent axis (10 deg)
  double force = 0.05;                  ///< N, per axis
  double joint = 0.008726646259971648;  ///< rad (0.5 deg)
  double link = 0.002;                  ///< m, how far each link is from the model (rms)
  double load = 0.02;                   ///< N, of the force on the mount, per axis
  double mount = 0;                     ///< m, of the mount's position, per axis
  double mount_angle = 0;               ///< rad, of its attitude, per angle
  double mount_delay = 0;               ///< s, by which the mount's pose is old
  double touch_delay = 0;               ///< s, by which the contacts are old
  double touch_threshold = 0;           ///< N, of a contact's normal force: less is not sensed
  double touch_correlation = 0;         ///< s, of the noise of points and normals; 0: none

  static SensorNoise realistic();

  template <class Visitor>
  void visit(Visitor&& v) {
    v("point", point, 0.0, 0.05, "m, noise of contact points, per axis");
    v("normal", normal, 0.0, 1.0, "rad, noise of contact normals, per tangent axis");
    v("force", force, 0.0, 10.0, "N, noise of contact forces, per axis");
    v("joint", joint, 0.0, 0.2, "rad, noise of joint angles");
    v("link", link, 0.0, 0.02, "m, displacement of each link in the hand, rms");
    v("load", load, 0.0, 10.0, "N, noise of the force on the mount, per axis");
    v.expert("mount", mount, 0.0, 0.01, "m, noise of the mount's position, per axis");
    v.expert("mount_angle", mount_angle, 0.0, 0.1,
             "rad, noise of the mount's orientation, per angle");
    v.expert("mount_delay", mount_delay, 0.0, 0.5, "s, delay of the mount's pose");
    v.expert("touch_delay", touch_delay, 0.0, 0.5, "s, delay of contacts");
    v.expert("touch_threshold", touch_threshold, 0.0, 5.0,
             "N, least force of a contact that is sensed");
    v.expert("touch_correlation", touch_correlation, 0.0, 1000.0,
             "s, correlation time of the noise of contact points and normals");
  }
};

}  // namespace palpate::simulation
