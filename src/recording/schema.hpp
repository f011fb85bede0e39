// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "palpate/recording/recording.hpp"

namespace palpate::recording {

// Names inside the file.
inline constexpr const char* kHeaderText = "header/json";
inline constexpr const char* kVertices = "header/vertices";
inline constexpr const char* kTriangles = "header/triangles";
inline constexpr const char* kContactCounts = "frames/contact_counts";
inline constexpr const char* kContacts = "frames/contacts";
inline constexpr const char* kContactErrors = "frames/contact_errors";  // from version 3 on
inline constexpr const char* kBiotacs = "frames/biotacs";               // from version 2 on
inline constexpr const char* kEvents = "events/json_lines";
inline constexpr const char* kEstimates = "estimates/json_lines";
inline constexpr const char* kBeliefs = "beliefs/json_lines";  // absent in older files

inline constexpr int kContactWidth = 9;       ///< p, n, f
inline constexpr int kContactErrorWidth = 2;  ///< of the point, of the normal
/// Of one BioTac: pdc, tdc, tac, e1..e19, pac 1..22, and whether pac is interpolated.
inline constexpr int kBiotacWidth = 4 + hand::kElectrodes + hand::kPacSamples;
inline constexpr int kFramesPerChunk = 100;

/// A quantity that every frame holds, and its dataset.
struct FrameField {
  const char* name;
  int width;
  bool may_be_absent;  ///< NaN where absent
  double most;         ///< that a magnitude may be, in the field's unit
  void (*get)(const Frame&, double* values);
  void (*set)(const double* values, Frame&);
};

/// The quantities of a frame, other than its contacts and channels.
std::vector<FrameField> frame_fields(const hand::Description& hand);

/// A frame whose values all have their sizes.
Frame empty_frame(const hand::Description& hand);

/// Appends the channels of a frame's BioTacs as kBiotacWidth counts a finger; -1 where one is
/// missing.
/// @throws BadInput unless there is one a finger, or for counts beyond 16 bits
void append_biotacs(const hand::HandReading& reading, std::vector<std::int16_t>& counts);

/// The channels of a frame's BioTacs from kBiotacWidth counts a finger.
void set_biotacs(const std::int16_t* counts, hand::HandReading& reading);

}  // namespace palpate::recording
