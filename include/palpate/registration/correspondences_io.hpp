// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "palpate/registration/correspondences.hpp"

namespace palpate::registration {

/// Correspondences of a CSV text with the header sx,sy,sz,tx,ty,tz (m) and, optionally,
/// snx,sny,snz,tnx,tny,tnz (normals, made unit vectors) and weight (>= 0); columns in any order,
/// others skipped whatever they hold.
/// @param source  named in errors, as in "pairs.csv:3: ..."
/// @throws BadInput for a missing column, a row of another length, a value that is no finite number
///         or a normal without direction
Correspondences parse_correspondences(std::string_view text, std::string_view source);

/// As parse_correspondences, from a file. @throws BadInput also if the file cannot be read
Correspondences read_correspondences(const std::filesystem::path& path);

}  // namespace palpate::registration
