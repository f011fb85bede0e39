// SPDX-License-Identifier: Apache-2.0
#include "palpate/plotting/plot.hpp"

#include <fmt/format.h>

#include "palpate/core/cache.hpp"
#include "palpate/core/error.hpp"
#include "plotting/plot_frame.hpp"
#include "plotting/plot_marks.hpp"
#include "plotting/svg.hpp"

namespace palpate::plotting {
namespace {

bool shares_categories(const PlotSeries& series) {
  return std::holds_alternative<BarSeries>(series) || std::holds_alternative<BoxSeries>(series);
}

PlotExtents checked_extents(const Plot& plot) {
  if (plot.width < 200 || plot.height < 150) {
    throw palpate::BadInput(
        fmt::format("a plot of {} x {} px is too small", plot.width, plot.height));
  }
  if (!plot.categories.empty() && plot.x.logarithmic) {
    throw palpate::BadInput("the x axis of a plot cannot have categories and be logarithmic");
  }
  PlotExtents extents;
  for (const PlotSeries& series : plot.series) {
    check_series(plot, series);
    include_series(plot, series, extents);
  }
  if (extents.y.empty()) {
    throw palpate::BadInput(fmt::format("nothing to draw in the {} series of plot \"{}\"",
                                        plot.series.size(), plot.title));
  }
  return extents;
}

void draw_all_series(const Plot& plot, const PlotFrame& frame, std::string_view clip,
                     SvgBody& svg) {
  std::size_t count = 0, slot = 0;
  for (const PlotSeries& series : plot.series) count += shares_categories(series);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    draw_series(plot, frame, plot.series[i], series_style(i), {slot, count}, clip, svg);
    slot += shares_categories(plot.series[i]);
  }
}

/// Pictures may share a page, so the clip's name depends on what it clips to.
std::string clip_name(const PlotFrame& frame) {
  return "frame-" +
         content_hash(fmt::format("{} {} {} {}", frame.left, frame.right, frame.top, frame.bottom))
             .substr(0, 8);
}

}  // namespace

std::string to_svg(const Plot& plot) {
  const PlotExtents extents = checked_extents(plot);
  const PlotFrame frame = make_frame(plot, extents);
  const std::string clip = clip_name(frame);
  SvgBody svg;
  svg.raw(fmt::format(R"(<title>{}</title>)", xml_text(plot.title)));
  svg.raw(fmt::format(R"(<clipPath id="{}">)", clip));
  svg.rectangle({frame.left, frame.top}, {frame.right, frame.bottom}, "");
  svg.raw("</clipPath>");
  svg.rectangle({0, 0}, {plot.width, plot.height}, R"(fill="#ffffff")");
  draw_axes(plot, frame, svg);
  draw_all_series(plot, frame, fmt::format("clip-path=\"url(#{})\"", clip), svg);
  draw_heading(plot, frame, svg);
  return fmt::format(R"(<svg xmlns="http://www.w3.org/2000/svg" version="1.1" role="img" )"
                     R"(width="{0}" height="{1}" viewBox="0 0 {0} {1}" )"
                     R"(font-family="Helvetica, Arial, 'DejaVu Sans', sans-serif" font-size="12">)"
                     "\n{2}</svg>\n",
                     plot.width, plot.height, svg.str());
}

}  // namespace palpate::plotting
