// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>
#include <vector>

#include "palpate/localization/evidence.hpp"

namespace palpate::localization {

/// Largest standard deviation of points per axis, m: contacts that are more than 30 mm off the
/// surface count as spurious, and poses from points that are all less exact would be too sure.
inline constexpr double kMaxPointNoise = 0.01;
/// The same of single points, m, which may say that they tell little.
inline constexpr double kMaxPointSigma = 0.1;

/// How exact contacts from a file are taken to be.
struct ContactNoise {
  double point = 0.001;    ///< per axis, m
  double normal = 0.1745;  ///< per tangent axis, rad
};

/// Contacts of a CSV text with the columns x,y,z (m) and, optionally, nx,ny,nz (outward normal of
/// the object, of unit length within 1 %; empty cells: none), point_sigma (m), normal_sigma (rad;
/// empty: as `noise` says), group (an integer: at least one contact of a group touches; empty: this
/// one does), t (s), finger (a name or an index) and fx,fy,fz (N), in any order. Skipped are
/// columns without a name and sigma_deg, error_deg and flags, which `palpate sense` writes. Rows
/// are put in the order of t.
///
/// @param source  named in errors, as in "contacts.csv:3: ..."
/// @throws BadInput for a missing or unknown column, a row of another length, a value that is no
///         finite number, a normal of another length, a sigma that is not positive or more than
///         kMaxPointSigma or pi/2, or a group below 0
std::vector<tactile::Contact> parse_contacts(std::string_view text, std::string_view source,
                                             const ContactNoise& noise = {});

/// The line of the text, from 1 on, of each of the contacts that parse_contacts() makes of it.
/// @throws BadInput as parse_contacts()
std::vector<std::size_t> contact_lines(std::string_view text, std::string_view source);

/// As parse_contacts, from a file. @throws BadInput also if the file cannot be read
std::vector<tactile::Contact> read_contacts(const std::filesystem::path& path,
                                            const ContactNoise& noise = {});

/// Planes that the held object was let down on, of a CSV with the columns nx,ny,nz (normal to the
/// object's side, of unit length within 1 %), height (of the plane over the frame's origin, along
/// the normal, m) and, optionally, sigma (of the height, m; empty: PlaneContact's own), in any
/// order; columns without a name are skipped.
///
/// @throws BadInput for a missing or unknown column, a value that is no finite number, a normal of
///         another length, an implausible height or a sigma that is not positive
std::vector<PlaneContact> read_plane_contacts(const std::filesystem::path& path);

}  // namespace palpate::localization
