// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace palpate::simulation {

/// By how much a world differs from what the robot is given of it; drawn once a world. "rms": the
/// root mean square of a vector's length; "up to": uniform between plus and minus that.
///
/// Figures of realistic(): repeatability and hand-eye calibration of industrial arms, data sheets
/// of force-torque sensors, torque estimates from motor currents, scans of household objects.
struct WorldErrors {
  double mount = 0;            ///< m rms, where the arm carries the hand
  double mount_angle = 0;      ///< rad rms
  double table_height = 0;     ///< m, up to
  double table_tilt = 0;       ///< rad, up to, about any horizontal axis
  double load_bias = 0;        ///< N rms, of the force on the mount, in the mount's frame
  double load_drift = 0;       ///< N/s, a component of it, up to
  double hand_weight = 0;      ///< share of it, up to: of the gravity that is taken off the load
  double torque = 0;           ///< share, up to: scale of an actuator's torque
  double torque_friction = 0;  ///< share of the largest torque: friction that is read along
  double friction = 0;         ///< up to, of hand and table
  double mass = 0;             ///< share, up to
  double center = 0;           ///< m rms, of the center of mass
  double scale = 0;            ///< share, up to: size of the object
  double surface = 0;          ///< m rms, of the object's surface: smooth dents and bulges
  double joint_zero = 0;       ///< rad rms, where a finger's joint and its drive have their zero
  double tip_radius = 0;       ///< m rms, by which a fingertip is larger or smaller
  double touch = 0;            ///< m rms, displacement of all contact points of a fingertip

  static WorldErrors realistic();

  template <class Visitor>
  void visit(Visitor&& v) {
    v.expert("mount", mount, 0.0, 0.02, "m rms, position of the hand on the arm");
    v.expert("mount_angle", mount_angle, 0.0, 0.2, "rad rms, orientation of the hand on the arm");
    v.expert("table_height", table_height, 0.0, 0.05, "m, largest error of the table's height");
    v.expert("table_tilt", table_tilt, 0.0, 0.1, "rad, largest tilt of the table");
    v.expert("load_bias", load_bias, 0.0, 5.0, "N rms, of the force on the mount");
    v.expert("load_drift", load_drift, 0.0, 0.1, "N/s, largest drift of the force on the mount");
    v.expert("hand_weight", hand_weight, 0.0, 0.5,
             "largest error of the hand's weight in that force, as a share");
    v.expert("torque", torque, 0.0, 0.5, "largest error of an actuator's torque, as a share");
    v.expert("torque_friction", torque_friction, 0.0, 0.5,
             "share of the largest torque, friction that is included in readings");
    v.expert("friction", friction, 0.0, 0.5, "largest error of the friction of hand and table");
    v.expert("mass", mass, 0.0, 0.9, "largest error of the object's mass, as a share");
    v.expert("center", center, 0.0, 0.05, "m rms, error of the object's centre of mass");
    v.expert("scale", scale, 0.0, 0.2, "largest error of the object's size, as a share");
    v.expert("surface", surface, 0.0, 0.01, "m rms, error of the object's surface");
    v.expert("joint_zero", joint_zero, 0.0, 0.2, "rad rms, zero of a joint's encoder and drive");
    v.expert("tip_radius", tip_radius, 0.0, 0.01, "m rms, error of a fingertip's radius");
    v.expert("touch", touch, 0.0, 0.02,
             "m rms, constant displacement of the contact points of a fingertip");
  }
};

}  // namespace palpate::simulation
