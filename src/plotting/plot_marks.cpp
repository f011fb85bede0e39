// SPDX-License-Identifier: Apache-2.0
#include "plotting/plot_marks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "palpate/core/error.hpp"
#include "palpate/core/statistics.hpp"

namespace palpate::plotting {
namespace {

using Point = Eigen::Vector2d;

constexpr double kGroupWidth = 0.76;     // of the distance between categories
constexpr std::size_t kDottedLine = 40;  // a line of at most so many points shows them

void need_equal(std::size_t have, std::size_t want, const std::string& name, std::string_view what,
                std::string_view per) {
  if (have == want) return;
  throw palpate::BadInput(
      fmt::format("series \"{}\" of a plot: {} {} for {} {}", name, have, what, want, per));
}

struct Checker {
  const Plot& plot;

  void operator()(const LineSeries& s) const {
    need_equal(s.y.size(), s.x.size(), s.name, "y", "x");
  }
  void operator()(const ScatterSeries& s) const {
    need_equal(s.y.size(), s.x.size(), s.name, "y", "x");
  }
  void operator()(const BarSeries& s) const {
    need_equal(s.values.size(), plot.categories.size(), s.name, "bars", "categories");
  }
  void operator()(const BoxSeries& s) const {
    need_equal(s.samples.size(), plot.categories.size(), s.name, "boxes", "categories");
  }
};

struct Includer {
  const Plot& plot;
  PlotExtents& extents;

  void pair(double x, double y) const {
    if (!drawable(plot.x, x) || !drawable(plot.y, y)) return;
    extents.x.include(plot.x, x);
    extents.y.include(plot.y, y);
  }
  template <class Pairs>
  void pairs(const Pairs& s) const {
    for (std::size_t i = 0; i < s.x.size(); ++i) pair(s.x[i], s.y[i]);
  }
  void operator()(const LineSeries& s) const { pairs(s); }
  void operator()(const ScatterSeries& s) const { pairs(s); }
  void operator()(const BarSeries& s) const {
    for (std::size_t i = 0; i < s.values.size(); ++i) {
      const double x = static_cast<double>(i);
      if (!drawable(plot.y, s.values[i])) continue;
      pair(x, s.values[i]);
      pair(x, 0);
    }
  }
  void operator()(const BoxSeries& s) const {
    for (std::size_t i = 0; i < s.samples.size(); ++i) {
      for (const double y : s.samples[i]) pair(static_cast<double>(i), y);
    }
  }
};

/// Quartiles, median and the ends of the whiskers.
struct BoxShape {
  double lowest, low, middle, high, highest;
};

/// @param sorted  at least one value
BoxShape box_shape(const std::vector<double>& sorted) {
  const double low = quantile(sorted, 0.25), high = quantile(sorted, 0.75);
  const double reach = 1.5 * (high - low);
  const auto first = std::lower_bound(sorted.begin(), sorted.end(), low - reach);
  const auto last = std::upper_bound(sorted.begin(), sorted.end(), high + reach);
  return {std::min(*first, low), low, median(sorted), high, std::max(*(last - 1), high)};
}

class Painter {
 public:
  Painter(const Plot& plot, const PlotFrame& frame, const SeriesStyle& style, Slot slot,
          std::string_view clip, SvgBody& svg)
      : plot_(plot), frame_(frame), style_(style), slot_(slot), clip_(clip), svg_(svg) {}

  void operator()(const LineSeries& s) const {
    std::vector<Point> run;
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      if (drawable(plot_.x, s.x[i]) && drawable(plot_.y, s.y[i])) {
        run.push_back(frame_.at(s.x[i], s.y[i]));
        if (s.x.size() <= kDottedLine) dot(run.back());
      } else {
        draw_run(run);
        run.clear();
      }
    }
    draw_run(run);
  }

  void operator()(const ScatterSeries& s) const {
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      if (frame_.x.shows(s.x[i]) && frame_.y.shows(s.y[i])) {
        draw_point(frame_.at(s.x[i], s.y[i]), style_.shape, style_.color, svg_);
      }
    }
  }

  void operator()(const BarSeries& s) const {
    const double foot = frame_.y.logarithmic() ? frame_.y.low() : 0;
    for (std::size_t i = 0; i < s.values.size(); ++i) {
      if (!drawable(plot_.y, s.values[i])) continue;
      const double x = center(i), half = 0.46 * width();
      svg_.rectangle(frame_.at(x - half, foot), frame_.at(x + half, s.values[i]),
                     fmt::format(R"(fill="{}" fill-opacity="0.85" {})", style_.color, clip_));
    }
  }

  void operator()(const BoxSeries& s) const {
    for (std::size_t i = 0; i < s.samples.size(); ++i) {
      std::vector<double> sorted;
      for (const double y : s.samples[i]) {
        if (drawable(plot_.y, y)) sorted.push_back(y);
      }
      std::sort(sorted.begin(), sorted.end());
      if (!sorted.empty()) box(center(i), sorted);
    }
  }

 private:
  double width() const { return kGroupWidth / static_cast<double>(slot_.count); }

  double center(std::size_t category) const {
    const double middle = (static_cast<double>(slot_.count) - 1) / 2;
    return static_cast<double>(category) + (static_cast<double>(slot_.index) - middle) * width();
  }

  void dot(const Point& at) const {
    svg_.circle(at, 2.8, fmt::format(R"(fill="{}" {})", style_.color, clip_));
  }

  void draw_run(const std::vector<Point>& run) const {
    if (run.size() == 1) dot(run[0]);
    if (run.size() < 2) return;
    svg_.polyline(run, fmt::format(R"(stroke="{}" stroke-width="2" stroke-linejoin="round" {} {})",
                                   style_.color, style_.dash, clip_));
  }

  void box(double x, const std::vector<double>& sorted) const {
    const BoxShape shape = box_shape(sorted);
    const double half = 0.36 * width();
    const std::string line =
        fmt::format(R"(stroke="{}" stroke-width="1.5" {})", style_.color, clip_);
    svg_.line(frame_.at(x, shape.lowest), frame_.at(x, shape.low), line);
    svg_.line(frame_.at(x, shape.high), frame_.at(x, shape.highest), line);
    for (const double end : {shape.lowest, shape.highest}) {
      svg_.line(frame_.at(x - half / 2, end), frame_.at(x + half / 2, end), line);
    }
    svg_.rectangle(frame_.at(x - half, shape.low), frame_.at(x + half, shape.high),
                   fmt::format(R"(fill="{}" fill-opacity="0.3" {})", style_.color, line));
    svg_.line(frame_.at(x - half, shape.middle), frame_.at(x + half, shape.middle),
              fmt::format(R"(stroke="{}" stroke-width="2.6" {})", style_.color, clip_));
    for (const double y : sorted) {
      if ((y < shape.lowest || y > shape.highest) && frame_.y.shows(y)) outlier(frame_.at(x, y));
    }
  }

  void outlier(const Point& at) const {
    svg_.circle(at, 2.6,
                fmt::format(R"(fill="none" stroke="{}" stroke-width="1.2")", style_.color));
  }

  const Plot& plot_;
  const PlotFrame& frame_;
  const SeriesStyle& style_;
  Slot slot_;
  std::string_view clip_;
  SvgBody& svg_;
};

}  // namespace

void check_series(const Plot& plot, const PlotSeries& series) { std::visit(Checker{plot}, series); }

void include_series(const Plot& plot, const PlotSeries& series, PlotExtents& extents) {
  std::visit(Includer{plot, extents}, series);
}

void draw_series(const Plot& plot, const PlotFrame& frame, const PlotSeries& series,
                 const SeriesStyle& style, Slot slot, std::string_view clip, SvgBody& svg) {
  std::visit(Painter(plot, frame, style, slot, clip, svg), series);
}

}  // namespace palpate::plotting
