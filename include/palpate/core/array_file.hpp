// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace palpate {

/// Named matrices of finite float32 as a file: a trained model's weights.
///
/// Layout: a text header "palpate KIND VERSION", one line "NAME ROWS COLUMNS" a matrix, "end"; then
/// the values, little endian, column by column; then their 64-bit FNV-1a sum, little endian.
class ArrayFile {
 public:
  ArrayFile(std::string kind, int version) : kind_(std::move(kind)), version_(version) {}

  /// @throws BadInput if the name is empty, used already or holds a blank, or a value is not finite
  void add(const std::string& name, Eigen::MatrixXf values);

  [[nodiscard]] std::string bytes() const;

  /// @param source  named in errors
  /// @throws BadInput unless the bytes are exactly such a file of that kind and version: nothing
  ///         missing, nothing beyond, the sum right, every value finite
  static ArrayFile parse(std::string_view bytes, const std::string& source, const std::string& kind,
                         int version);

  /// The matrix of that name. @param rows, columns  its size; -1: any
  /// @throws BadInput if there is none, or it has another size
  [[nodiscard]] const Eigen::MatrixXf& get(const std::string& name, Eigen::Index rows = -1,
                                           Eigen::Index columns = -1) const;

 private:
  std::string kind_, source_;
  int version_;
  std::vector<std::pair<std::string, Eigen::MatrixXf>> arrays_;
};

}  // namespace palpate
