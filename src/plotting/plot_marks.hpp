// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "plotting/plot_frame.hpp"

namespace palpate::plotting {

/// Which of the bars or boxes that share a category.
struct Slot {
  std::size_t index, count;
};

/// @throws BadInput if the series' lengths do not fit together or to the categories
void check_series(const Plot& plot, const PlotSeries& series);

/// Adds what is drawable of the series. Bars also show their foot, unless the axis is logarithmic.
void include_series(const Plot& plot, const PlotSeries& series, PlotExtents& extents);

/// @param clip  attribute that keeps shapes within the frame
void draw_series(const Plot& plot, const PlotFrame& frame, const PlotSeries& series,
                 const SeriesStyle& style, Slot slot, std::string_view clip, SvgBody& svg);

}  // namespace palpate::plotting
