// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "palpate/plotting/plot.hpp"
#include "plotting/plot_axis.hpp"
#include "plotting/svg.hpp"

namespace palpate::plotting {

/// How one series looks.
struct SeriesStyle {
  std::string color;
  std::string dash;  ///< attribute, or nothing for a solid line
  int shape;         ///< of its points
};

SeriesStyle series_style(std::size_t index);

/// The area that the data are drawn in, px.
struct PlotFrame {
  Scale x, y;
  double left, right, top, bottom;

  Eigen::Vector2d at(double x_value, double y_value) const { return {x(x_value), y(y_value)}; }
};

/// Extents of all that is drawable, along x and y.
struct PlotExtents {
  Extent x, y;
};

/// Leaves room for title, legend, labels and ticks. @throws BadInput as make_scale()
PlotFrame make_frame(const Plot& plot, const PlotExtents& extents);

/// Grid, ticks and labels; they go beneath the data.
void draw_axes(const Plot& plot, const PlotFrame& frame, SvgBody& svg);

/// Title and legend.
void draw_heading(const Plot& plot, const PlotFrame& frame, SvgBody& svg);

/// A point of one of four shapes.
void draw_point(const Eigen::Vector2d& at, int shape, std::string_view color, SvgBody& svg);

}  // namespace palpate::plotting
