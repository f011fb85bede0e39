// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nanobind/nanobind.h>

#include <string_view>

#include "palpate/geometry/cloud/point_cloud.hpp"

namespace palpate::python {

/// A cloud where Python has it: a PointCloud, or the rows of an array (N, 3) of float64 or float32,
/// whatever lies between them. Anything else that numpy makes an array of is copied, once.
class CloudArgument {
 public:
  /// @throws BadInput, naming `what`
  CloudArgument(nanobind::handle value, std::string_view what);

  /// Valid as long as this.
  const geometry::PointView& view() const { return view_; }

 private:
  nanobind::object owner_;
  geometry::PointView view_;
};

}  // namespace palpate::python
