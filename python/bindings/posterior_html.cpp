// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "libraries.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::python {
namespace {

namespace lo = localization;

constexpr std::size_t kShown = 6;     // modes
constexpr std::size_t kPoints = 250;  // of the surface, for each mode
constexpr double kSize = 220;         // pixels, of a view
constexpr std::array kColors = {"#1f6fb2", "#d9622b", "#3a9a4b", "#8a56b3", "#b09020", "#7a7a7a"};

/// The object's surface at a pose, two coordinates of each point.
std::vector<Eigen::Vector2d> outline(const geometry::ObjectModel& model, const Eigen::Isometry3d& T,
                                     int across, int up) {
  std::vector<Eigen::Vector2d> points;
  const auto& surface = model.surface();
  const std::size_t step = std::max<std::size_t>(1, surface.size() / kPoints);
  for (std::size_t i = 0; i < surface.size(); i += step) {
    const Eigen::Vector3d p = T * surface[i].p.cast<double>();
    points.emplace_back(p[across], p[up]);
  }
  return points;
}

/// One view: the object at each mode, as opaque as the mode is heavy.
std::string view(const Posterior& posterior, int across, int up, const char* label) {
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  Eigen::AlignedBox2d box;
  const std::size_t shown = std::min(kShown, posterior.found.modes.size());
  for (std::size_t i = 0; i < shown; ++i) {
    outlines.push_back(
        outline(*posterior.model, posterior.found.modes[i].T_frame_object, across, up));
    for (const auto& p : outlines.back()) box.extend(p);
  }
  const double scale = 0.9 * kSize / std::max(1e-6, box.sizes().maxCoeff());
  std::string dots;
  for (std::size_t i = shown; i-- > 0;) {
    const double opacity = 0.15 + 0.75 * posterior.found.modes[i].weight;
    dots += fmt::format("<g fill='{}' fill-opacity='{:.2f}'>", kColors[i], opacity);
    for (const auto& p : outlines[i]) {
      const Eigen::Vector2d at = scale * (p - box.center());
      dots += fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='1.3'/>", kSize / 2 + at.x(),
                          kSize / 2 - at.y());
    }
    dots += "</g>";
  }
  return fmt::format(
      "<svg width='{0}' height='{0}' role='img' aria-label='{1}'>{2}<text x='4' y='12' "
      "font-size='11'>{1}</text></svg>",
      kSize, label, dots);
}

std::string row(const lo::Mode& mode, std::size_t index) {
  const Eigen::Vector3d w = log_so3(mode.T_frame_object.linear()) / kDegree;
  const Eigen::Vector3d t = 1e3 * mode.T_frame_object.translation();
  return fmt::format(
      "<tr><td style='color:{}'>&#9632;</td><td>{:.3f}</td><td>{:.3f}</td><td>({:.1f}, {:.1f}, "
      "{:.1f})</td><td>({:.1f}, {:.1f}, {:.1f})</td><td>{}</td></tr>",
      kColors[std::min(index, kColors.size() - 1)], mode.weight, lo::pose_probability(mode), w.x(),
      w.y(), w.z(), t.x(), t.y(), t.z(),
      mode.free_axis ? fmt::format("&plusmn;{:.0f} deg", mode.free_axis->extent / kDegree) : "");
}

}  // namespace

std::string posterior_html(const Posterior& posterior) {
  const auto& modes = posterior.found.modes;
  std::string rows;
  for (std::size_t i = 0; i < std::min(kShown, modes.size()); ++i) rows += row(modes[i], i);
  if (modes.size() > kShown) {
    rows += fmt::format("<tr><td colspan='6'>and {} more</td></tr>", modes.size() - kShown);
  }
  const std::string views = modes.empty() ? ""
                                          : view(posterior, 0, 1, "x right, y up") +
                                                view(posterior, 0, 2, "x right, z up");
  return fmt::format(
      "<div><b>{}</b>, probability {:.3f} (within 5 deg and 10 mm)<br>{}<table><tr><th></th>"
      "<th>weight</th><th>probability</th><th>rotation vector, deg</th><th>translation, mm</th>"
      "<th>free axis</th></tr>{}</table></div>",
      lo::to_string(posterior.found.status), lo::best_probability(posterior.found), views, rows);
}

}  // namespace palpate::python
