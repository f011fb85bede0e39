// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"

namespace palpate::tactile {

/// What is wrong with a sample. All but `gap`, `late` and `left_out` make it useless for
/// estimating.
enum class SampleFlag : unsigned {
  gap = 1u << 0,           ///< frames are missing before it, or its clock is a new one
  late = 1u << 1,          ///< it came later than half a period after its time
  repeated = 1u << 2,      ///< time or content is that of the last frame
  out_of_order = 1u << 3,  ///< its time lies before that of the last frame
  placeholder = 1u << 4,   ///< nothing but forces of exactly (0, -1, 0)
  no_force = 1u << 5,      ///< contacts, but no force that has a direction
  not_finite = 1u << 6,    ///< a value that is not finite
  no_contact = 1u << 7,    ///< the finger touches nothing
  far_apart = 1u << 8,     ///< contacts too far apart, in place or direction, to be one
  left_out = 1u << 9,      ///< of its contacts, some were not informative and are not in it
};
inline constexpr int kSampleFlags = 10;

/// The flag's name, as in "out_of_order".
std::string_view to_string(SampleFlag flag);

/// A set of flags.
class SampleFlags {
 public:
  void set(SampleFlag flag) { bits_ |= static_cast<unsigned>(flag); }
  void merge(SampleFlags other) { bits_ |= other.bits_; }
  [[nodiscard]] bool has(SampleFlag flag) const {
    return (bits_ & static_cast<unsigned>(flag)) != 0;
  }
  [[nodiscard]] bool any() const { return bits_ != 0; }
  /// Whether an estimator may use the sample.
  [[nodiscard]] bool usable() const;
  /// Names of all that are set, joined by "+"; empty if there are none.
  [[nodiscard]] std::string names() const;

 private:
  unsigned bits_ = 0;
};

/// One contact of a fingertip, in a frame that does not move.
struct FingerContact {
  Eigen::Vector3d p;  ///< point, m
  Eigen::Vector3d f;  ///< force of the finger on the object, N
  /// Outward normal of the object as the tip's own shape has it: the inward normal of the tip's
  /// surface at the contact, unit.
  std::optional<Eigen::Vector3d> tip_normal;
};

/// All that a fingertip senses in one tick.
struct FingerFrame {
  double time = 0;  ///< s
  std::vector<FingerContact> contacts;
};

/// The contacts of one tick as one: what the estimators are fed.
struct FingerSample {
  double time = 0;    ///< s
  Eigen::Vector3d p;  ///< centroid of the contacts, m; nan unless usable
  Eigen::Vector3d f;  ///< sum of their forces on the object, N; nan unless usable
  std::optional<Eigen::Vector3d> tip_normal;  ///< mean of theirs, unit
  SampleFlags flags;
};

struct SampleOptions {
  double period = hand::kTick;  ///< s between frames
  double min_force = 1e-3;      ///< N; less has no direction
  double one_contact = 0.008;   ///< m; contacts further apart are not one
  double one_direction = 1.0;   ///< rad; nor are those whose tip normals differ by more

  template <class Visitor>
  void visit(Visitor&& v) {
    v("period", period, 1e-5, 10.0, "s, time between frames");
    v("min_force", min_force, 0.0, 10.0, "N, least force whose direction is used");
    v("one_contact", one_contact, 0.0, 0.1,
      "m, distance above which contacts of a finger do not count as one");
    v("one_direction", one_direction, 0.0, 3.2,
      "rad, angle between tip normals above which contacts do not count as one");
  }
};

/// Turns the frames of one finger, as they come, into checked samples. Bad frames come out flagged,
/// never as plausible numbers; single contacts that are placeholders, not finite or without force
/// are left out of a frame that has better ones, which is flagged `left_out`. Frames before the
/// last one's time are `out_of_order`; the fifth in order of these (its clock was set back, or the
/// last one's time was wrong) begins a new order of time with a `gap`.
class SampleMaker {
 public:
  /// @throws BadInput for options out of range
  explicit SampleMaker(const SampleOptions& options = {});

  FingerSample next(const FingerFrame& frame);

 private:
  void check_time(const FingerFrame& frame, SampleFlags& flags);
  /// Takes the time of a frame before the last one's.
  bool is_of_new_clock(double time);

  SampleOptions options_;
  std::optional<FingerFrame> last_;
  int early_frames_ = 0;   // before its time, each shortly after the one before
  double early_time_ = 0;  // s, of the latest of these
};

/// What a finger senses in a reading, with the normals of its capsule tip, in the world.
FingerFrame finger_frame(const hand::HandReading& reading, const hand::Description& hand,
                         int finger);

}  // namespace palpate::tactile
