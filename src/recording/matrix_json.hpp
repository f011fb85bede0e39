// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "palpate/core/error.hpp"
#include "palpate/core/plausible.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::recording {

/// @throws BadInput or nlohmann::json::exception unless json is a finite number
inline double finite_from_json(const nlohmann::json& json) {
  const double value = json.get<double>();
  if (!std::isfinite(value)) throw BadInput(fmt::format("a value is {}", value));
  return value;
}

/// Entries of a matrix, row by row.
template <class Derived>
nlohmann::json matrix_to_json(const Eigen::MatrixBase<Derived>& matrix) {
  nlohmann::json json = nlohmann::json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) json.push_back(matrix(i, j));
  }
  return json;
}

/// @throws BadInput unless json is an array of exactly the matrix's entries, all finite
template <class Matrix>
Matrix matrix_from_json(const nlohmann::json& json) {
  Matrix matrix;
  if (!json.is_array() || json.size() != static_cast<std::size_t>(matrix.size())) {
    throw BadInput(fmt::format("expected {} numbers, found {}", matrix.size(),
                               json.is_array() ? fmt::to_string(json.size()) : json.type_name()));
  }
  std::size_t k = 0;
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) matrix(i, j) = finite_from_json(json[k++]);
  }
  return matrix;
}

inline nlohmann::json pose_to_json(const Eigen::Isometry3d& T) {
  return matrix_to_json(T.matrix());
}

/// @throws BadInput unless it is a rigid motion, by a length that can be
inline Eigen::Isometry3d pose_from_json(const nlohmann::json& json) {
  const auto matrix = matrix_from_json<Eigen::Matrix4d>(json);
  check_plausible(matrix.col(3).head<3>(), kMaxLength, "a translation");
  std::array<double, 16> values;
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data()) = matrix;
  return pose_from_row_major(values);
}

/// @throws BadInput unless it is a rotation
inline Eigen::Matrix3d rotation_from_json(const nlohmann::json& json) {
  return rigid(matrix_from_json<Eigen::Matrix3d>(json), "a matrix");
}

/// @throws BadInput unless it is a number in low..high
inline double plausible_from_json(const nlohmann::json& json, double low, double high,
                                  std::string_view what) {
  return plausible(json.get<double>(), low, high, what);
}

/// @throws BadInput unless it is a vector of components up to `most`
inline Eigen::Vector3d vector_from_json(const nlohmann::json& json, double most = kMaxLength) {
  const auto v = matrix_from_json<Eigen::Vector3d>(json);
  check_plausible(v, most, "a component");
  return v;
}

}  // namespace palpate::recording
