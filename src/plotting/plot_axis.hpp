// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "palpate/plotting/plot.hpp"

namespace palpate::plotting {

/// Whether the axis can show a value at all.
bool drawable(const PlotAxis& axis, double value);

/// Smallest and largest of the values met so far that the axis can show.
struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(const PlotAxis& axis, double value);
  bool empty() const { return low > high; }
};

struct Tick {
  double value;
  std::string label;
};

/// Maps the values between two limits to a line of pixels.
class Scale {
 public:
  Scale(double low, double high, bool logarithmic)
      : low_(low), high_(high), logarithmic_(logarithmic) {}

  /// Pixels of the two limits.
  void place(double at_low, double at_high);

  double operator()(double value) const;
  double low() const { return low_; }
  double high() const { return high_; }
  bool logarithmic() const { return logarithmic_; }
  bool shows(double value) const { return value >= low_ && value <= high_; }

 private:
  double low_, high_;
  bool logarithmic_;
  double at_low_ = 0, at_high_ = 1;
};

/// Scale that shows the extent with some air about it, except where the axis sets a limit.
/// @throws BadInput, with `name`, for limits that span nothing or too much, or are at or below 0 on
///         a logarithmic axis
Scale make_scale(const PlotAxis& axis, Extent extent, std::string_view name);

/// About `count` round values within the scale; powers of ten on a logarithmic scale that spans
/// enough of them.
std::vector<Tick> ticks(const Scale& scale, int count);

/// Lines without labels: 2..9 times the powers of ten of a logarithmic scale.
std::vector<double> minor_ticks(const Scale& scale);

}  // namespace palpate::plotting
