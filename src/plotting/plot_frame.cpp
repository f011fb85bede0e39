// SPDX-License-Identifier: Apache-2.0
#include "plotting/plot_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpate::plotting {
namespace {

using Point = Eigen::Vector2d;

constexpr double kMargin = 16;      // px, as all lengths here
constexpr double kCharacter = 6.6;  // mean width in the labels' font
constexpr double kTitleHeight = 26;
constexpr double kLegendRow = 20;
constexpr double kSwatch = 24;
constexpr double kLabelRow = 22;
constexpr double kXTickSpacing = 85, kYTickSpacing = 48;
constexpr double kSlant = 35;  // deg, of category names that are too long to stand side by side

constexpr std::string_view kInk = R"(fill="#333333")";
constexpr std::string_view kGrid = R"(stroke="#e4e4e4" stroke-width="1")";
constexpr std::string_view kFaintGrid = R"(stroke="#f2f2f2" stroke-width="1")";
constexpr std::string_view kAxisLine = R"(stroke="#555555" stroke-width="1.2")";

double text_width(std::string_view text) {
  return kCharacter * static_cast<double>(character_count(text));
}

double widest(const std::vector<Tick>& ticks) {
  double width = 0;
  for (const Tick& tick : ticks) width = std::max(width, text_width(tick.label));
  return width;
}

struct LegendEntry {
  std::size_t series;
  std::string name;
  Point at;  // relative to the legend's upper left corner
};

/// Entries in rows that are no wider than the picture.
std::vector<LegendEntry> legend_entries(const Plot& plot) {
  std::vector<LegendEntry> entries;
  Point at(0, 0);
  for (std::size_t i = 0; i < plot.series.size(); ++i) {
    const std::string name = std::visit([](const auto& s) { return s.name; }, plot.series[i]);
    if (name.empty()) continue;
    const double width = kSwatch + text_width(name) + 22;
    if (at.x() > 0 && at.x() + width > plot.width - 5 * kMargin) at = Point(0, at.y() + kLegendRow);
    entries.push_back({i, name, at});
    at.x() += width;
  }
  return entries;
}

double heading_height(const Plot& plot) {
  const auto entries = legend_entries(plot);
  const double legend = entries.empty() ? 0 : entries.back().at.y() + kLegendRow + 4;
  return (plot.title.empty() ? 0 : kTitleHeight) + legend;
}

std::vector<Tick> category_ticks(const Plot& plot) {
  std::vector<Tick> result;
  for (const auto& name : plot.categories) {
    result.push_back({static_cast<double>(result.size()), name});
  }
  return result;
}

bool slanted(const Plot& plot) {
  if (plot.categories.empty()) return false;
  const double slot = (plot.width - 90) / static_cast<double>(plot.categories.size());
  return widest(category_ticks(plot)) > 0.95 * slot;
}

constexpr double radians(double degrees) { return degrees * std::numbers::pi / 180; }

double tick_row_height(const Plot& plot) {
  if (!slanted(plot)) return 22;
  return 22 + widest(category_ticks(plot)) * std::sin(radians(kSlant));
}

/// Room that a slanted first name needs to the left of its category.
double overhang(const Plot& plot) {
  if (!slanted(plot)) return 0;
  return kMargin / 2 + text_width(plot.categories[0]) * std::cos(radians(kSlant));
}

std::vector<Tick> x_ticks(const Plot& plot, const PlotFrame& frame) {
  if (!plot.categories.empty()) return category_ticks(plot);
  return ticks(frame.x, std::max(2, static_cast<int>((frame.right - frame.left) / kXTickSpacing)));
}

std::vector<Tick> y_ticks(const PlotFrame& frame) {
  return ticks(frame.y, std::max(2, static_cast<int>((frame.bottom - frame.top) / kYTickSpacing)));
}

Scale x_scale(const Plot& plot, const Extent& extent) {
  if (plot.categories.empty()) return make_scale(plot.x, extent, "x");
  return {-0.5, static_cast<double>(plot.categories.size()) - 0.5, false};
}

void draw_grid(const Plot& plot, const PlotFrame& frame, SvgBody& svg) {
  const auto across = [&](double y, std::string_view style) {
    svg.line({frame.left, frame.y(y)}, {frame.right, frame.y(y)}, style);
  };
  const auto upright = [&](double x, std::string_view style) {
    svg.line({frame.x(x), frame.top}, {frame.x(x), frame.bottom}, style);
  };
  for (const double y : minor_ticks(frame.y)) across(y, kFaintGrid);
  for (const double x : minor_ticks(frame.x)) upright(x, kFaintGrid);
  for (const Tick& tick : y_ticks(frame)) across(tick.value, kGrid);
  if (!plot.categories.empty()) return;
  for (const Tick& tick : x_ticks(plot, frame)) upright(tick.value, kGrid);
}

void draw_tick_labels(const Plot& plot, const PlotFrame& frame, SvgBody& svg) {
  const std::string end = fmt::format(R"(text-anchor="end" {})", kInk);
  const std::string middle = fmt::format(R"(text-anchor="middle" {})", kInk);
  for (const Tick& tick : y_ticks(frame)) {
    svg.text({frame.left - 8, frame.y(tick.value) + 4}, tick.label, end);
  }
  for (const Tick& tick : x_ticks(plot, frame)) {
    const double x = frame.x(tick.value);
    if (plot.categories.empty()) svg.line({x, frame.bottom}, {x, frame.bottom + 4}, kAxisLine);
    if (slanted(plot)) {
      svg.rotated_text({x + 4, frame.bottom + 14}, -kSlant, tick.label, end);
    } else {
      svg.text({x, frame.bottom + 18}, tick.label, middle);
    }
  }
}

void draw_axis_names(const Plot& plot, const PlotFrame& frame, SvgBody& svg) {
  const std::string style = fmt::format(R"(text-anchor="middle" font-size="13" {})", kInk);
  if (!plot.x.label.empty()) {
    svg.text({(frame.left + frame.right) / 2, plot.height - 12.0}, plot.x.label, style);
  }
  if (!plot.y.label.empty()) {
    svg.rotated_text({kMargin + 4, (frame.top + frame.bottom) / 2}, -90, plot.y.label, style);
  }
}

struct SwatchPainter {
  const SeriesStyle& style;
  Point center;
  SvgBody& svg;

  void operator()(const LineSeries&) const {
    svg.line(center - Point(10, 0), center + Point(10, 0),
             fmt::format(R"(stroke="{}" stroke-width="2.2" {})", style.color, style.dash));
  }
  void operator()(const ScatterSeries&) const { draw_point(center, style.shape, style.color, svg); }
  template <class Filled>
  void operator()(const Filled&) const {
    svg.rectangle(center - Point(6, 6), center + Point(6, 6),
                  fmt::format(R"(fill="{}" rx="2")", style.color));
  }
};

}  // namespace

SeriesStyle series_style(std::size_t index) {
  // Okabe & Ito, without their yellow, which is too faint on white.
  static constexpr std::string_view kColors[] = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                                 "#E69F00", "#56B4E9", "#555555"};
  static constexpr std::string_view kDashes[] = {"", R"(stroke-dasharray="7 4")",
                                                 R"(stroke-dasharray="2 3")"};
  const std::size_t colors = std::size(kColors);
  return {std::string(kColors[index % colors]),
          std::string(kDashes[index / colors % std::size(kDashes)]), static_cast<int>(index % 4)};
}

PlotFrame make_frame(const Plot& plot, const PlotExtents& extents) {
  PlotFrame frame{x_scale(plot, extents.x), make_scale(plot.y, extents.y, "y"), 0, 0, 0, 0};
  frame.top = kMargin + heading_height(plot);
  frame.bottom = plot.height - 8 - tick_row_height(plot) - (plot.x.label.empty() ? 0 : kLabelRow);
  frame.bottom = std::max(frame.bottom, frame.top + 20);
  frame.y.place(frame.bottom, frame.top);
  frame.left = kMargin + 8 + widest(y_ticks(frame)) + (plot.y.label.empty() ? 0 : kLabelRow);
  frame.left = std::max(frame.left, overhang(plot));
  frame.right = plot.width - 1.5 * kMargin;
  frame.x.place(frame.left, frame.right);
  return frame;
}

void draw_axes(const Plot& plot, const PlotFrame& frame, SvgBody& svg) {
  draw_grid(plot, frame, svg);
  draw_tick_labels(plot, frame, svg);
  draw_axis_names(plot, frame, svg);
}

void draw_heading(const Plot& plot, const PlotFrame& frame, SvgBody& svg) {
  svg.line({frame.left, frame.bottom}, {frame.right, frame.bottom}, kAxisLine);
  double top = kMargin;
  if (!plot.title.empty()) {
    svg.text({frame.left, top + 12}, plot.title,
             R"(font-size="15" font-weight="bold" fill="#111")");
    top += kTitleHeight;
  }
  for (const LegendEntry& entry : legend_entries(plot)) {
    const Point at = entry.at + Point(frame.left, top + 8);
    const SeriesStyle style = series_style(entry.series);
    std::visit(SwatchPainter{style, at + Point(10, 0), svg}, plot.series[entry.series]);
    svg.text(at + Point(kSwatch + 2, 4), entry.name, kInk);
  }
}

void draw_point(const Point& at, int shape, std::string_view color, SvgBody& svg) {
  const std::string style =
      fmt::format(R"(fill="{}" fill-opacity="0.8" stroke="#ffffff" stroke-width="0.6")", color);
  switch (shape) {
    case 0:
      return svg.circle(at, 3.6, style);
    case 1:
      return svg.rectangle(at - Point(3.3, 3.3), at + Point(3.3, 3.3), style);
    case 2:
      return svg.polygon({at + Point(0, -4.4), at + Point(4.2, 3.2), at + Point(-4.2, 3.2)}, style);
    default:
      return svg.polygon(
          {at + Point(0, -4.6), at + Point(4.6, 0), at + Point(0, 4.6), at + Point(-4.6, 0)},
          style);
  }
}

}  // namespace palpate::plotting
