// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/eigen/dense.h>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "palpate/core/se3.hpp"

namespace palpate::python {

namespace nb = nanobind;

/// What numpy is given: C order, as the package promises.
using Rows3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Triangles = Eigen::Matrix<std::int32_t, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Pose4 = Eigen::Matrix<double, 4, 4, Eigen::RowMajor>;
using Covariance6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using Rotation3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// @throws BadInput for an array of which numpy would make numbers or truths without a word:
/// complex ones, times, text, and what is masked
void require_real(nb::handle array, std::string_view what);

/// Anything that numpy makes an array of (N, 3) of; its rows.
/// @throws BadInput, naming `what` and the shape that was given
std::vector<Eigen::Vector3d> points_from(nb::handle values, std::string_view what);

/// The same of (3,).
Eigen::Vector3d vector_from(nb::handle values, std::string_view what);

/// One number, or one for each of `count`.
std::vector<double> numbers_from(nb::handle values, std::size_t count, std::string_view what);

/// Numbers (N,).
std::vector<double> numbers_from(nb::handle values, std::string_view what);

/// Any two-dimensional array; (0, 0) for one without elements.
Matrix matrix_from(nb::handle values, std::string_view what);

/// A rigid motion (4, 4). @throws BadInput unless it is one to 1e-6
Eigen::Isometry3d pose_from(nb::handle values, std::string_view what);

/// A 6 x 6 matrix.
Matrix6d covariance_from(nb::handle values, std::string_view what);

Rows3 rows(const std::vector<Eigen::Vector3d>& points);
inline Pose4 pose(const Eigen::Isometry3d& T) { return T.matrix(); }

/// None or a value, as an argument has it.
inline bool is_given(nb::handle value) { return value.is_valid() && !value.is_none(); }

}  // namespace palpate::python
