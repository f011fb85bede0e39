// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/tactile/sensors/taxel_array.hpp"

namespace palpate::tactile {

/// A taxel of an array that sends raw values, in the frame of the fingertip's distal link.
struct TaxelCell {
  Eigen::Vector3d p;  ///< middle, m
  Eigen::Vector3d n;  ///< outward unit normal of the skin
  double gain = 1;    ///< N per unit of the value
  double zero = 0;    ///< value without a contact
};

/// Taxels by the finger's name, in the order of the values.
using TaxelLayout = std::map<std::string, std::vector<TaxelCell>, std::less<>>;

/// A layout as CSV: `finger,x,y,z,nx,ny,nz` and, optionally, `gain,zero`; one row a taxel.
/// @throws BadInput, naming the line, for what is missing or cannot be
TaxelLayout parse_taxel_layout(std::string_view text, std::string_view source);
TaxelLayout read_taxel_layout(const std::filesystem::path& path);

/// The contacts of an array's values, in the frame of the cells.
/// @throws BadInput for another number of values than of cells, and for a value that is not finite
///         or a force that no finger has
std::vector<Contact> contacts_of_values(const std::vector<TaxelCell>& cells,
                                        std::span<const double> values,
                                        const TaxelOptions& options = {});

}  // namespace palpate::tactile
