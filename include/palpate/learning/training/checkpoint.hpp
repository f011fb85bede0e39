// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>

namespace palpate::learning {

/// All that a training needs to go on where it was.
struct Checkpoint {
  std::string method;
  std::uint64_t seed = 0;
  int iteration = 0;
  std::string settings;  ///< resolved options, as TOML
  std::map<std::string, Eigen::MatrixXd> arrays;

  /// The array of that name. @throws BadInput if there is none
  const Eigen::MatrixXd& array(const std::string& name) const;
  /// The array of that name, of one column. @param rows  that it must have; -1: any
  /// @throws BadInput if there is none, or it has another size or a value that is not finite
  Eigen::VectorXd column(const std::string& name, Eigen::Index rows = -1) const;
};

/// Writes a checkpoint atomically: whoever reads it finds a whole one, this or the one before.
/// A line of JSON, then the arrays' numbers as doubles, little endian, column by column.
void save_checkpoint(const std::filesystem::path& path, const Checkpoint& checkpoint);

/// @throws BadInput, naming the file: missing, of another format or version, or of a size that does
///         not fit what its first line announces
Checkpoint load_checkpoint(const std::filesystem::path& path);

}  // namespace palpate::learning
