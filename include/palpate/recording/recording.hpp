// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/core/se3.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/hand/hand.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/tactile/contacts/contact.hpp"

namespace palpate::recording {

inline constexpr int kFormatVersion = 4;        ///< the newest
inline constexpr int kOldestFormatVersion = 1;  ///< that is still read

/// What holds for a whole recording: enough to run the estimator from the recording alone.
struct RecordingHeader {
  std::string program_version;
  std::uint64_t seed = 0;
  geometry::KnownObject object;
  hand::Description hand;
  std::string config_toml;  ///< resolved configuration
  /// Contacts carry what the sensors say of their errors. Such a recording has format version 3;
  /// without, it is 2.
  bool sensor_reported_errors = false;
};

/// What only a simulator knows. For judging and drawing; never for estimating.
struct FrameTruth {
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  hand::JointVector joints;  ///< rad
};

/// One tick: what was sensed at its end, and what was commanded for it.
struct Frame {
  hand::HandReading reading;
  hand::HandCommand command;
  std::optional<FrameTruth> truth;
};

enum class EventKind { begin, note, end };
std::string_view to_string(EventKind kind);

/// What happens in the course of the work; the text of an `end` is the phase's outcome.
struct Event {
  double time = 0;  ///< s
  EventKind kind = EventKind::note;
  std::string phase;
  std::string text;
};

/// Rotations about a line, by -extent..+extent (rad), that the estimate cannot distinguish.
struct FreeAxisRecord {
  Eigen::Vector3d point;      ///< on the line, in the world, m
  Eigen::Vector3d direction;  ///< unit
  double extent = 0;          ///< rad; pi: all round
  /// Of the mode's weight, near its pose (localization::FreeAxis); older recordings have none.
  std::optional<double> share = std::nullopt;
};

/// One of the poses that an estimate holds for credible.
struct PoseModeRecord {
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
  double weight = 0;
  Matrix6d covariance = Matrix6d::Zero();  ///< of [rotation; translation], world axes
  std::optional<FreeAxisRecord> free_axis;
};

/// An estimate of the object's pose, in the world, and what it was made from.
struct EstimateRecord {
  double time = 0;                         ///< s
  std::string status;                      ///< "certain", "ambiguous" or "no_pose"
  std::vector<PoseModeRecord> modes;       ///< heaviest first
  std::vector<tactile::Contact> contacts;  ///< in the world
};

/// A pose, and the share of a belief that it stands for.
struct CrediblePoseRecord {
  double probability = 0;
  Eigen::Isometry3d T_world_object = Eigen::Isometry3d::Identity();
};

/// What was believed of the object's pose at a time: single poses, most probable first.
struct BeliefRecord {
  double time = 0;       ///< s
  std::string source;    ///< "prior", "touch", "grasp" or "online"
  bool in_hand = false;  ///< the poses go with the palm from here on, else they stay
  std::vector<CrediblePoseRecord> poses;
};

/// Entropy of a belief, nats. What its poses lack of 1 counts as poses of which none is more
/// probable than the least of those, because the most probable ones are listed.
double entropy(const BeliefRecord& belief);

/// A whole recording in memory. Without the truth it holds no more than a real hand could sense.
struct Recording {
  RecordingHeader header;
  std::vector<Frame> frames;
  std::vector<Event> events;
  std::vector<EstimateRecord> estimates;
  std::vector<BeliefRecord> beliefs;  ///< none in files of before 2026-11-24
  bool finished = true;               ///< false: what was flushed before the writer stopped
};

/// Reads a recording, or the ".partial" file of one that was never finished.
///
/// @throws BadInput, naming the path and what is wrong, for a file that is missing, is not a
///         recording, has another format version, is damaged, or holds a sensed value that is not
///         finite
Recording read_recording(const std::filesystem::path& path);

}  // namespace palpate::recording
