// SPDX-License-Identifier: Apache-2.0
#include "cloud_argument.hpp"

#include <fmt/format.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

#include <string>

#include "arrays.hpp"
#include "palpate/core/error.hpp"

namespace palpate::python {
namespace {

using geometry::PointCloud, geometry::PointView;

/// float64 or float32, native, with three numbers side by side in each row.
nb::object with_rows(nb::handle values, std::string_view what) {
  const nb::object numpy = nb::module_::import_("numpy");
  require_real(values, what);
  nb::object array = numpy.attr("asarray")(values);
  const bool is_float = array.attr("dtype").equal(numpy.attr("float64")) ||
                        array.attr("dtype").equal(numpy.attr("float32"));
  if (!is_float) array = numpy.attr("asarray")(array, nb::arg("dtype") = "float64");
  if (nb::cast<std::size_t>(array.attr("size")) == 0)
    return numpy.attr("zeros")(nb::make_tuple(0, 3));
  const nb::object shape = array.attr("shape");
  if (nb::len(shape) != 2 || nb::cast<int>(shape[1]) != 3) {
    throw BadInput(fmt::format("{} has shape {}, not (N, 3)", what, nb::str(shape).c_str()));
  }
  const nb::object strides = array.attr("strides");
  const auto item = nb::cast<std::int64_t>(array.attr("itemsize"));
  const bool in_place = nb::cast<bool>(array.attr("flags").attr("aligned")) &&
                        nb::cast<std::int64_t>(strides[1]) == item &&
                        nb::cast<std::int64_t>(strides[0]) % item == 0;
  return in_place ? array : numpy.attr("ascontiguousarray")(array);
}

template <class Number>
PointView view_as(nb::handle array) {
  using Rows = nb::ndarray<const Number, nb::shape<-1, 3>, nb::device::cpu>;
  const auto rows = nb::cast<Rows>(array);
  return {
      rows.data(), rows.shape(0),
      static_cast<std::ptrdiff_t>(rows.stride(0)) * static_cast<std::ptrdiff_t>(sizeof(Number))};
}

nb::object owner_of(nb::handle value, std::string_view what) {
  if (nb::isinstance<PointCloud>(value)) return nb::borrow(value);
  try {
    return with_rows(value, what);
  } catch (const nb::python_error& error) {
    throw BadInput(fmt::format("{}: {}", what, nb::cast<std::string>(nb::str(error.value()))));
  }
}

PointView view_of(nb::handle owner) {
  if (nb::isinstance<PointCloud>(owner)) return nb::cast<const PointCloud&>(owner);
  const bool is_double = nb::cast<std::int64_t>(owner.attr("itemsize")) == sizeof(double);
  return is_double ? view_as<double>(owner) : view_as<float>(owner);
}

}  // namespace

CloudArgument::CloudArgument(nb::handle value, std::string_view what)
    : owner_(owner_of(value, what)), view_(view_of(owner_)) {}

}  // namespace palpate::python
