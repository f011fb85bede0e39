// SPDX-License-Identifier: Apache-2.0
#include "arrays.hpp"

#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <string>

#include "palpate/core/error.hpp"

namespace palpate::python {

namespace {

/// Not all that has a mask() is masked: a pandas.Series has a method of that name.
/// @throws BadInput where values of a numpy.ma array, or of one in a list of them, are masked
void require_unmasked(nb::handle array, std::string_view what) {
  const nb::object masked = nb::module_::import_("numpy").attr("ma").attr("MaskedArray");
  if (nb::isinstance<nb::list>(array) || nb::isinstance<nb::tuple>(array)) {
    for (const nb::handle part : array) {
      if (nb::isinstance(part, masked)) require_unmasked(part, what);
    }
    return;
  }
  if (!nb::isinstance(array, masked)) return;
  if (nb::cast<bool>(nb::bool_(array.attr("mask").attr("any")()))) {
    throw BadInput(fmt::format("{}: some values are masked", what));
  }
}

}  // namespace

/// Of an array numpy drops imaginary parts and masks, counts the seconds of times, and reads text.
/// Other libraries' tensors have types of their own: what numpy makes of them is looked at.
void require_real(nb::handle array, std::string_view what) {
  require_unmasked(array, what);
  if (!nb::hasattr(array, "dtype")) return;
  const nb::module_ numpy = nb::module_::import_("numpy");
  nb::object type = array.attr("dtype");
  if (!nb::isinstance(type, numpy.attr("dtype"))) {
    type = numpy.attr("asarray")(array).attr("dtype");
  }
  const auto kind = nb::cast<std::string>(type.attr("kind"));
  if (kind.find_first_of("cmMVSU") != std::string::npos) {
    throw BadInput(fmt::format("{}: {} is no real number", what, nb::str(type).c_str()));
  }
}

namespace {

using Array = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;

std::string shape_of(const Array& array) {
  std::string text;
  for (std::size_t i = 0; i < array.ndim(); ++i) {
    text += fmt::format("{}{}", i == 0 ? "" : ", ", array.shape(i));
  }
  return fmt::format("({}{})", text, array.ndim() == 1 ? "," : "");
}

/// @throws BadInput where numpy finds no numbers in it
Array array_from(nb::handle values, std::string_view what) {
  const nb::object numpy = nb::module_::import_("numpy");
  try {
    require_real(values, what);
    auto array = nb::cast<Array>(
        numpy.attr("asarray")(values, nb::arg("dtype") = "float64", nb::arg("order") = "C"));
    if (!nb::hasattr(values, "dtype")) require_real(numpy.attr("asarray")(values), what);
    return array;
  } catch (const nb::python_error& error) {
    throw BadInput(fmt::format("{}: {}", what, nb::cast<std::string>(nb::str(error.value()))));
  }
}

[[noreturn]] void refuse(const Array& array, std::string_view what, std::string_view wanted) {
  throw BadInput(fmt::format("{} has shape {}, not {}", what, shape_of(array), wanted));
}

}  // namespace

std::vector<Eigen::Vector3d> points_from(nb::handle values, std::string_view what) {
  const Array array = array_from(values, what);
  if (array.size() == 0) return {};
  if (array.ndim() != 2 || array.shape(1) != 3) refuse(array, what, "(N, 3)");
  std::vector<Eigen::Vector3d> points(array.shape(0));
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = Eigen::Map<const Eigen::Vector3d>(array.data() + 3 * i);
  }
  return points;
}

Eigen::Vector3d vector_from(nb::handle values, std::string_view what) {
  const Array array = array_from(values, what);
  if (array.ndim() != 1 || array.shape(0) != 3) refuse(array, what, "(3,)");
  return Eigen::Map<const Eigen::Vector3d>(array.data());
}

std::vector<double> numbers_from(nb::handle values, std::size_t count, std::string_view what) {
  const Array array = array_from(values, what);
  if (array.ndim() == 0) return std::vector<double>(count, *array.data());
  if (array.ndim() != 1 || array.shape(0) != count) {
    refuse(array, what, fmt::format("() or ({},)", count));
  }
  return {array.data(), array.data() + count};
}

std::vector<double> numbers_from(nb::handle values, std::string_view what) {
  const Array array = array_from(values, what);
  if (array.ndim() != 1) refuse(array, what, "(N,)");
  return {array.data(), array.data() + array.size()};
}

Matrix matrix_from(nb::handle values, std::string_view what) {
  const Array array = array_from(values, what);
  if (array.size() == 0) return {};
  if (array.ndim() != 2) refuse(array, what, "(rows, columns)");
  return Eigen::Map<const Matrix>(array.data(), static_cast<Eigen::Index>(array.shape(0)),
                                  static_cast<Eigen::Index>(array.shape(1)));
}

Eigen::Isometry3d pose_from(nb::handle values, std::string_view what) {
  const Array array = array_from(values, what);
  if (array.ndim() != 2 || array.shape(0) != 4 || array.shape(1) != 4)
    refuse(array, what, "(4, 4)");
  std::array<double, 16> numbers;
  std::copy_n(array.data(), 16, numbers.begin());
  try {
    return pose_from_row_major(numbers);
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("{}: {}", what, error.what()));
  }
}

Matrix6d covariance_from(nb::handle values, std::string_view what) {
  const Array array = array_from(values, what);
  if (array.ndim() != 2 || array.shape(0) != 6 || array.shape(1) != 6)
    refuse(array, what, "(6, 6)");
  return Eigen::Map<const Covariance6>(array.data());
}

Rows3 rows(const std::vector<Eigen::Vector3d>& points) {
  Rows3 result(static_cast<Eigen::Index>(points.size()), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    result.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
  }
  return result;
}

}  // namespace palpate::python
