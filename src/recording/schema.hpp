// SPDX-License-Identifier: Apache-2.0
#pragma once

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
inline constexpr const char* kEvents = "events/json_lines";
inline constexpr const char* kEstimates = "estimates/json_lines";

inline constexpr int kContactWidth = 9;  ///< p, n, f
inline constexpr int kFramesPerChunk = 100;

/// A quantity of fixed width that every frame holds, and its dataset.
struct FrameField {
  const char* name;
  int width;
  bool may_be_absent;  ///< NaN where absent
  void (*get)(const Frame&, double* values);
  void (*set)(const double* values, Frame&);
};

/// The quantities of a frame, other than its contacts.
std::span<const FrameField> frame_fields();

}  // namespace palpate::recording
