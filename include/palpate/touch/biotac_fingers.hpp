// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/touch/biotac_inverse.hpp"

namespace palpate::touch {

/// T_link_sensor: the sensor frame of a BioTac in the frame of the finger's distal link. Its origin
/// is the centre of the fingertip's half ball, x points along the tip, and z away from the side to
/// which the last joint flexes the finger.
Eigen::Isometry3d biotac_mount(const hand::HandModel& hand, int finger);

/// What one BioTac feels in a frame.
struct BiotacFeeling {
  unsigned flags = 0;                      ///< BiotacFlag, or-ed
  std::optional<InferredContact> contact;  ///< in the sensor frame
};

/// Feels contacts in the stream of one BioTac's frames, as they come.
///
/// The first kRestFrames sound frames are taken for rest. Rest then follows the readings slowly
/// while nothing touches. Nothing is inferred from a frame that is not usable (biotac_usable) or
/// older than the one before it.
class BiotacFinger {
 public:
  static constexpr int kRestFrames = 20;

  explicit BiotacFinger(std::shared_ptr<const BiotacInverse> inverse);

  /// @param infer  whether the contact is wanted; else only the sensor's state is followed
  BiotacFeeling step(const BiotacReading& reading, bool infer = true);

 private:
  unsigned fault_flags(const BiotacReading& reading);
  void learn_rest(const BiotacReading& reading);
  void follow_rest(const BiotacReading& reading);

  std::shared_ptr<const BiotacInverse> inverse_;
  std::optional<BiotacReading> last_;
  BiotacReading first_rest_, rest_;
  int rest_frames_ = 0;
  std::optional<BiotacDecoder> decoder_;
  /// Of each electrode: frames with the same count, and the pressures among them.
  struct Stillness {
    int frames = 0;
    double low = 0, high = 0;
  };
  std::array<Stillness, kElectrodes> still_;
};

/// The contacts of a hand's fingertips, from their BioTacs' channels alone.
class BiotacFingers {
 public:
  BiotacFingers(const hand::HandModel& hand, std::shared_ptr<const BiotacInverse> inverse);

  /// What each fingertip feels. @throws BadInput if the reading has no channels
  std::array<BiotacFeeling, hand::kFingers> feel(const hand::HandReading& reading);

  /// A felt contact in the frame of the finger's distal link.
  [[nodiscard]] hand::TipContact in_link(const InferredContact& contact, int finger) const;

  /// Puts the contacts that the channels tell of in the place of the reading's.
  void infer_contacts(hand::HandReading& reading);

  /// Follows the sensors' state through a reading of whose contacts nobody asks.
  void follow(const hand::HandReading& reading);

 private:
  std::array<BiotacFeeling, hand::kFingers> step(const hand::HandReading& reading, bool infer);

  std::vector<BiotacFinger> fingers_;
  std::array<Eigen::Isometry3d, hand::kFingers> mounts_;
};

}  // namespace palpate::touch
