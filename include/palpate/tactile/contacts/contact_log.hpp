// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/tactile/contacts/finger_sample.hpp"

namespace palpate::tactile {

/// The frames of one finger from a log of contacts.
struct FingerLog {
  std::string finger;
  double period = hand::kTick;  ///< s between frames
  std::vector<FingerFrame> frames;
  /// Outward normal of the object that the log gives for each frame, unit, where it gives one.
  std::vector<std::optional<Eigen::Vector3d>> normals;
};

/// A finger's name becomes the name of its files and a cell of CSV files.
/// @param source  named in the error
/// @throws BadInput for one that is empty or has more than 200 bytes, begins with a dot, or holds a
///         slash, a comma or a control character
void check_finger_name(std::string_view name, const std::string& source);

/// Reads a CSV of contacts, one a row: columns finger, t and the vectors p, f and, optionally, n
/// (px,py,pz or x,y,z; fx,fy,fz; nx,ny,nz) and tn (tnx,tny,tnz: outward normal of the object as the
/// fingertip's own shape has it; zero where the tip gives none); others are ignored. Rows of one
/// finger that follow each other with the same t are one frame of simultaneous contacts; those of
/// them with the same p and f are one contact. A t of whole numbers only counts ticks.
///
/// @param tick  s, of one tick; if not given, 0.1, and t has to go on by 1
/// @throws BadInput, naming the file and line, for a file that cannot be read, a missing column, a
///         finger without a proper name, a cell that is no number (nan is one), a time that is
///         infinite or beyond 1e10 s, a tick though t has fractions, and ticks in steps other than
///         1 (their median) unless it is stated how long one is
std::vector<FingerLog> read_contact_log(const std::filesystem::path& path,
                                        std::optional<double> tick = std::nullopt);

}  // namespace palpate::tactile
