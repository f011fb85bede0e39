// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/biotac/inverse.hpp"

namespace palpate::tactile {

/// T_link_sensor: the sensor frame of a BioTac in the frame of the finger's distal link. Its origin
/// is the centre of the fingertip's half ball, x points along the tip, and z away from the side to
/// which the last joint flexes the finger.
Eigen::Isometry3d biotac_mount(const hand::Description& hand, int finger);

/// What one BioTac measures in a frame: the contact, as estimated from its channels.
struct BiotacEstimate {
  unsigned flags = 0;                      ///< BiotacFlag, or-ed
  std::optional<InferredContact> contact;  ///< in the sensor frame
  std::optional<double> pressure;          ///< change of pdc from rest, counts; where known
};

/// Estimates contacts from the stream of one BioTac's frames, as they come.
///
/// The first kRestFrames sound frames are taken for rest. Rest then follows the readings slowly
/// while nothing touches. Nothing is inferred from a frame that is not usable (biotac_usable),
/// older than the one before it, or without a finite time (`missing`). After frames that were lost
/// or not usable for longer than a late frame takes, smoothing starts again.
class BiotacFinger {
 public:
  static constexpr int kRestFrames = 20;

  explicit BiotacFinger(std::shared_ptr<const BiotacInverse> inverse);

  /// @param infer  whether the contact is wanted; else only the sensor's state is followed
  BiotacEstimate step(const BiotacReading& reading, bool infer = true);

 private:
  unsigned fault_flags(const BiotacReading& reading);
  void learn_rest(const BiotacReading& reading);
  void follow_rest(const BiotacReading& reading);

  std::shared_ptr<const BiotacInverse> inverse_;
  std::optional<BiotacReading> last_;
  BiotacReading first_rest_, rest_;
  int rest_frames_ = 0;
  std::optional<BiotacDecoder> decoder_;
  double decoded_time_ = 0;  // s, of the last frame that was decoded
  /// Of each electrode: frames with the same count, and the pressures among them.
  struct Stillness {
    int frames = 0;
    double low = 0, high = 0;
  };
  std::array<Stillness, kElectrodes> still_;
};

/// Which way a fingertip was moving when it met something.
class MeetingWay {
 public:
  /// @param p_tip  in the world, m, of the next tick
  void follow(const Eigen::Vector3d& p_tip, bool touching);

  /// Unit, in the world; nothing where nothing touches, or the tip had hardly moved.
  [[nodiscard]] const std::optional<Eigen::Vector3d>& way() const { return way_; }

 private:
  std::deque<Eigen::Vector3d> places_;  // the last, the newest at the back
  std::optional<Eigen::Vector3d> way_;
  bool touching_ = false;
};

/// The contacts of a hand's fingertips, from their BioTacs' channels alone.
///
/// Each says how far its normal may be off by the inverse's variance of its place on the curved
/// tip. The skin itself is known, so that the point across the surface is off by the second order
/// of that only.
///
/// Where the pressure shows a touch whose place no electrode measures (light, or beside the
/// electrodes), the contact is blunt: it lies on the tip's ball on the side to which the tip moved
/// when it met the object, with as large an error as that has.
class BiotacFingers {
 public:
  /// Standard deviations of blunt contacts.
  static constexpr double kBluntNormal = 0.6;    // rad
  static constexpr double kBluntPoint = 0.0015;  // m

  BiotacFingers(const hand::Description& hand, std::shared_ptr<const BiotacInverse> inverse);

  /// Of each fingertip. @throws BadInput if the reading has no channels
  std::vector<BiotacEstimate> estimate(const hand::HandReading& reading);

  /// An estimated contact in the frame of the finger's distal link.
  [[nodiscard]] hand::TipContact in_link(const InferredContact& contact, int finger) const;

  /// Puts the contacts inferred from the channels in the place of the reading's.
  void infer_contacts(hand::HandReading& reading);

  /// Follows the sensors' state through a reading of whose contacts nobody asks.
  void follow(const hand::HandReading& reading);

 private:
  using TipPoses = std::vector<Eigen::Isometry3d>;

  std::vector<BiotacEstimate> step(const hand::HandReading& reading, bool infer);
  /// Of the distal links, in the world.
  [[nodiscard]] TipPoses tip_poses(const hand::HandReading& reading) const;
  [[nodiscard]] std::optional<hand::TipContact> blunt_contact(std::size_t finger,
                                                              const Eigen::Matrix3d& R_world_link,
                                                              double pressure) const;

  hand::Description hand_;
  double pressure_gain_;  // counts/N
  std::vector<BiotacFinger> fingers_;
  std::vector<Eigen::Isometry3d> mounts_;
  std::vector<MeetingWay> ways_;
};

}  // namespace palpate::tactile
