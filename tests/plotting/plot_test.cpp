// SPDX-License-Identifier: Apache-2.0
#include "palpate/plotting/plot.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <regex>
#include <set>

#include "core/error_message.hpp"

namespace palpate::plotting {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// First group of each match.
std::vector<std::string> matches(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> result;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it) {
    result.push_back((*it)[1]);
  }
  return result;
}

std::vector<std::string> texts(const std::string& svg) { return matches(svg, ">([^<]*)</text>"); }

bool has_text(const std::string& svg, const std::string& text) {
  const auto all = texts(svg);
  return std::find(all.begin(), all.end(), text) != all.end();
}

Plot line_plot(std::vector<double> x, std::vector<double> y) {
  Plot plot;
  plot.series = {LineSeries{"line", std::move(x), std::move(y)}};
  return plot;
}

Plot bar_plot(std::vector<double> values) {
  Plot plot;
  for (std::size_t i = 0; i < values.size(); ++i) plot.categories.push_back(fmt::format("c{}", i));
  plot.series = {BarSeries{"bars", std::move(values)}};
  return plot;
}

Plot box_plot(std::vector<double> samples) {
  Plot plot;
  plot.categories = {"only"};
  plot.series = {BoxSeries{"box", {std::move(samples)}}};
  return plot;
}

/// Where the horizontal line or tick label of a value stands, px: labels are set 4 px lower.
double height_of_label(const std::string& svg, const std::string& label) {
  const auto found = matches(svg, "<text x=\"[^\"]*\" y=\"([^\"]*)\"[^>]*>" + label + "</text>");
  return found.empty() ? kNan : std::stod(found[0]) - 4;
}

TEST(Plot, ShowsTitleLabelsLegendAndRoundTicks) {
  Plot plot = line_plot({0, 5, 10}, {0, 0.5, 1});
  plot.title = "Convergence";
  plot.x.label = "time (s)";
  plot.y.label = "rate";
  const std::string svg = to_svg(plot);
  for (const char* text :
       {"Convergence", "time (s)", "rate", "line", "0", "2", "10", "0.2", "1.0"}) {
    EXPECT_TRUE(has_text(svg, text)) << text;
  }
}

TEST(Plot, IsTheSameEachTime) {
  EXPECT_EQ(to_svg(line_plot({0, 1}, {3, 4})), to_svg(line_plot({0, 1}, {3, 4})));
}

TEST(Plot, EscapesText) {
  Plot plot = line_plot({0, 1}, {0, 1});
  plot.title = "<R & \"t\">\n\x01 \xe9 caf\u00e9 \xed\xa0\x80";
  const std::string svg = to_svg(plot);
  EXPECT_TRUE(has_text(svg, "&lt;R &amp; &quot;t&quot;&gt;   \ufffd caf\u00e9 \ufffd\ufffd\ufffd"));
}

TEST(Plot, TicksAreFewRoundAndWithinTheFrame) {
  for (const double scale : {1e-12, 1e-3, 0.7, 1.0, 33.0, 1e5, 1e12}) {
    for (const double offset : {0.0, -0.6, 5.0}) {
      const std::string svg = to_svg(line_plot({0, 1}, {scale * offset, scale * (offset + 1)}));
      const auto heights = matches(svg, "text-anchor=\"end\"[^>]*>([^<]*)<");
      EXPECT_GE(heights.size(), 3u) << scale << " " << offset;
      EXPECT_LE(heights.size(), 14u) << scale << " " << offset;
      EXPECT_EQ(std::set(heights.begin(), heights.end()).size(), heights.size());
    }
  }
}

TEST(Plot, LinearAxisIsLinearAndUpwards) {
  const std::string svg = to_svg(line_plot({0, 1}, {0, 40}));
  const double at0 = height_of_label(svg, "0"), at20 = height_of_label(svg, "20");
  const double at40 = height_of_label(svg, "40");
  EXPECT_GT(at0, at40 + 100);
  EXPECT_NEAR(at20, (at0 + at40) / 2, 0.02);
}

TEST(Plot, LogarithmicAxisSpacesPowersEvenly) {
  Plot plot = line_plot({0, 1, 2}, {0.01, 1, 100});
  plot.y.logarithmic = true;
  const std::string svg = to_svg(plot);
  const double low = height_of_label(svg, "0.1"), high = height_of_label(svg, "10");
  EXPECT_NEAR(height_of_label(svg, "1"), (low + high) / 2, 0.02);
}

TEST(Plot, LogarithmicAxisOfALittleMoreThanNothingHasTicks) {
  Plot plot = line_plot({0, 1}, {1.2, 1.7});
  plot.y.logarithmic = true;
  EXPECT_GE(matches(to_svg(plot), "text-anchor=\"end\"[^>]*>([^<]*)<").size(), 3u);
}

TEST(Plot, LogarithmicAxisSkipsWhatIsNotPositive) {
  Plot plot = line_plot({0, 1, 2, 3, 4, 5}, {1, 10, 0, -5, 10, 100});
  plot.y.logarithmic = true;
  EXPECT_EQ(count(to_svg(plot), "<polyline"), 2u);
}

TEST(Plot, LineBreaksWhereAValueIsNotFinite) {
  const std::string svg =
      to_svg(line_plot({0, 1, 2, kNan, 4, 5, 6}, {1, 2, kInfinity, 3, 4, 5, 6}));
  EXPECT_EQ(count(svg, "<polyline"), 2u);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(Plot, ALonePointOfALineIsADot) {
  std::vector<double> x(101), y(101, kNan);
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = static_cast<double>(i);
  y[50] = 1;
  EXPECT_EQ(count(to_svg(line_plot(x, y)), "<circle"), 1u);
}

TEST(Plot, ScatterDrawsEachFinitePoint) {
  Plot plot;
  plot.series = {ScatterSeries{"", {0, 1, 2, kNan}, {0, 1, kNan, 3}}};
  EXPECT_EQ(count(to_svg(plot), "<circle"), 2u);
}

TEST(Plot, ScatterLeavesOutWhatIsBeyondTheLimits) {
  Plot plot;
  plot.series = {ScatterSeries{"", {0, 1, 2}, {0, 1, 1e300}}};
  plot.y.low = 0;
  plot.y.high = 1;
  EXPECT_EQ(count(to_svg(plot), "<circle"), 2u);
}

TEST(Plot, BarsStandOnZeroAndReachTheirValue) {
  const std::string svg = to_svg(bar_plot({1, -1, kNan}));
  const auto tops = matches(svg, R"re(<rect x="[^"]*" y="([^"]*)"[^>]*fill="#0072B2" fill-op)re");
  ASSERT_EQ(tops.size(), 2u);
  EXPECT_NEAR(std::stod(tops[0]), height_of_label(svg, "1.0"), 0.02);
  EXPECT_NEAR(std::stod(tops[1]), height_of_label(svg, "0"), 0.02);
}

// Quartiles 3 and 7, so that whiskers reach at most 1.5 * 4 beyond: -3 and 13.
TEST(Plot, BoxesFollowTukey) {
  const std::string svg = to_svg(box_plot({1, 2, 3, 4, 5, 6, 7, 8, 20, kNan}));
  const auto rows = matches(svg, R"re(<line [^>]*y2="([^"]*)" stroke="#0072B2")re");
  ASSERT_EQ(rows.size(), 5u);  // two stems, two caps, the median
  const double at2 = height_of_label(svg, "2"), at20 = height_of_label(svg, "20");
  const auto value = [&](const std::string& y) {
    return 2 + 18 * (std::stod(y) - at2) / (at20 - at2);
  };
  EXPECT_NEAR(value(rows[2]), 1, 0.01);
  EXPECT_NEAR(value(rows[3]), 8, 0.01);
  EXPECT_NEAR(value(rows[4]), 5, 0.01);
  const auto outliers = matches(svg, R"re(<circle [^>]*cy="([^"]*)")re");
  ASSERT_EQ(outliers.size(), 1u);
  EXPECT_NEAR(value(outliers[0]), 20, 0.01);
}

TEST(Plot, OneValueOrNoSpanIsDrawn) {
  EXPECT_EQ(count(to_svg(box_plot({3})), "fill-opacity=\"0.3\""), 1u);
  EXPECT_NO_THROW(to_svg(line_plot({2, 2}, {0, 0})));
  EXPECT_NO_THROW(to_svg(line_plot({1e15, 1e15 + 1}, {-1e-300, 1e-300})));
  Plot plot = line_plot({0}, {5});
  plot.y.logarithmic = true;
  EXPECT_NO_THROW(to_svg(plot));
}

TEST(Plot, SeriesHaveDifferentColors) {
  Plot plot;
  for (double i = 0; i < 7; ++i) plot.series.push_back(LineSeries{"s", {0, 1}, {i, i}});
  const auto colors = matches(to_svg(plot), R"re(<polyline [^>]*stroke="([^"]*)")re");
  ASSERT_EQ(colors.size(), 7u);
  EXPECT_EQ(std::set(colors.begin(), colors.end()).size(), 7u);
}

TEST(Plot, LegendLeavesOutNamelessSeries) {
  Plot plot = line_plot({0, 1}, {0, 1});
  plot.series.push_back(LineSeries{"", {0, 1}, {1, 0}});
  const auto all = texts(to_svg(plot));
  EXPECT_EQ(std::count(all.begin(), all.end(), "line"), 1);
  EXPECT_EQ(std::count(all.begin(), all.end(), ""), 0);
}

TEST(Plot, LongCategoriesAreSlanted) {
  Plot plot = bar_plot({1, 2, 3});
  EXPECT_EQ(to_svg(plot).find("rotate(-35)"), std::string::npos);
  plot.categories[0] = std::string(60, 'x');
  EXPECT_NE(to_svg(plot).find("rotate(-35)"), std::string::npos);
}

TEST(Plot, NothingToDrawIsRefused) {
  Plot empty;
  empty.title = "Empty";
  EXPECT_EQ(error_message([&] { to_svg(empty); }),
            "nothing to draw in the 0 series of plot \"Empty\"");
  EXPECT_THROW(to_svg(line_plot({}, {})), palpate::BadInput);
  EXPECT_THROW(to_svg(line_plot({1, kNan}, {kNan, 1})), palpate::BadInput);
  EXPECT_THROW(to_svg(box_plot({})), palpate::BadInput);
  Plot negative = line_plot({0, 1}, {-1, -2});
  negative.y.logarithmic = true;
  EXPECT_THROW(to_svg(negative), palpate::BadInput);
}

TEST(Plot, LengthsThatDifferAreRefused) {
  EXPECT_EQ(error_message([] {
              to_svg(line_plot({1, 2, 3}, {1, 2}));
            }),
            "series \"line\" of a plot: 2 y for 3 x");
  Plot bars = bar_plot({1, 2});
  bars.categories.clear();
  EXPECT_EQ(error_message([&] { to_svg(bars); }),
            "series \"bars\" of a plot: 2 bars for 0 categories");
  Plot boxes = box_plot({1});
  boxes.categories = {"a", "b"};
  EXPECT_THROW(to_svg(boxes), palpate::BadInput);
}

TEST(Plot, UnusableAxesAreRefused) {
  const auto refusal = [](auto change) {
    Plot plot = line_plot({1, 2}, {1, 2});
    change(plot);
    return error_message([&] { to_svg(plot); });
  };
  EXPECT_EQ(refusal([](Plot& p) { p.y.low = 3, p.y.high = 2; }),
            "the y axis of a plot cannot run from 3 to 2");
  EXPECT_NE(refusal([](Plot& p) { p.x.low = 1, p.x.high = 1; }), "");
  EXPECT_NE(refusal([](Plot& p) { p.y.high = kInfinity; }), "");
  EXPECT_NE(refusal([](Plot& p) { p.y.low = kNan; }), "");
  EXPECT_EQ(refusal([](Plot& p) { p.y.logarithmic = true, p.y.low = 0, p.y.high = 2; }),
            "the y axis of a plot cannot run from 0 to 2 logarithmically");
  EXPECT_NE(refusal([](Plot& p) { p.width = 100; }).find("100 x 440"), std::string::npos);
  EXPECT_THROW(to_svg(line_plot({0, 1}, {-1.7e308, 1.7e308})), palpate::BadInput);
  Plot categories = bar_plot({1});
  categories.x.logarithmic = true;
  EXPECT_THROW(to_svg(categories), palpate::BadInput);
}

}  // namespace
}  // namespace palpate::plotting
