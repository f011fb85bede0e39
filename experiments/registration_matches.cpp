// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "palpate/geometry/cloud/fpfh.hpp"
#include "palpate/geometry/cloud/normals.hpp"
#include "palpate/geometry/cloud/outlier_filter.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/registration/cloud_registration.hpp"
#include "palpate/tactile/contacts/contact_log.hpp"
#include "registration/problems.hpp"
#include "sliding_finger.hpp"

namespace {

using namespace palpate;
using namespace palpate::registration;
using experiment::Table;
using geometry::PointCloud;

PointCloud sampled(const geometry::TriangleMesh& mesh, std::size_t count, RandomStream random) {
  PointCloud cloud;
  for (const auto& s : geometry::sample_surface(mesh, count, random)) {
    cloud.points.push_back(s.point);
    cloud.normals.push_back(s.normal);
  }
  return cloud;
}

/// Contacts of fingertips swept over the bunny from the sides and from above, as the thesis' hand
/// senses it: 25 strokes of 40 contacts along planes through the object, with 1 mm and 10 deg of
/// noise, and a few contacts with something else.
PointCloud swept_contacts(RandomStream random) {
  constexpr int kStrokes = 25, kContacts = 40, kElsewhere = 20;
  const PointCloud surface = sampled(testing::bunny(), 60000, random.fork("surface"));
  PointCloud contacts;
  for (int stroke = 0; stroke < kStrokes; ++stroke) {
    const Eigen::Vector3d across = random.unit_vector();
    const double offset = random.uniform(-0.03, 0.03);
    std::vector<std::size_t> band;
    for (std::size_t i = 0; i < surface.size(); ++i) {
      if (std::abs(across.dot(surface.points[i]) - offset) < 5e-4) band.push_back(i);
    }
    for (int k = 0; k < kContacts && !band.empty(); ++k) {
      const std::size_t i = band[random.index(band.size())];
      contacts.points.push_back(surface.points[i] + 0.001 * random.normal3());
      contacts.normals.push_back(testing::tilted(surface.normals[i], 10, random));
    }
  }
  for (int k = 0; k < kElsewhere; ++k) {
    contacts.points.push_back(0.1 * random.unit_vector());
    contacts.normals.push_back(random.unit_vector());
  }
  return contacts;
}

/// Radius of features: five times the distance between points, as if they covered the surface.
double feature_radius(const PointCloud& a, const PointCloud& b, double area) {
  const auto fewer = static_cast<double>(std::min(a.size(), b.size()));
  return 5 * std::sqrt(area / fewer);
}

struct Matches {
  std::size_t all = 0, right = 0;  ///< right: closer than 5 mm, as both are in one frame
};

Matches match(const PointCloud& source, const PointCloud& target, double area) {
  const double radius = feature_radius(source, target, area);
  Matches matches;
  for (const auto& m :
       geometry::mutual_matches(geometry::fpfh(source, radius), geometry::fpfh(target, radius))) {
    ++matches.all;
    const auto &p = source.points[static_cast<std::size_t>(m.source)],
               &q = target.points[static_cast<std::size_t>(m.target)];
    matches.right += (p - q).norm() < 0.005;
  }
  return matches;
}

/// Contacts with a mesh, in its frame.
struct Sweep {
  std::string name, title;
  PointCloud contacts;
  const geometry::TriangleMesh& mesh;
};

void publish_matches(const experiment::Options& options, const Sweep& sweep) {
  const PointCloud& contacts = sweep.contacts;
  const double area = geometry::area(sweep.mesh);
  const PointCloud filtered =
      geometry::subset(contacts, geometry::statistical_inliers(contacts, {}));
  std::vector<std::size_t> sizes;
  for (std::size_t n = 100; n < 1000; n += 100) sizes.push_back(n);
  for (std::size_t n = 1000; n < 10000; n += 1000) sizes.push_back(n);
  for (std::size_t n = 10000; n <= 50000; n += 10000) sizes.push_back(n);
  if (options.quick) sizes = {100, 500, 1000};
  Table table({"target points", "matches", "within 5 mm", "matches, filtered",
               "within 5 mm, filtered", "thesis"});
  plotting::Plot plot{.title = "Mutual FPFH matches of swept contacts (thesis fig. 6.4)",
                      .x = {.label = "target points", .logarithmic = true},
                      .y = {.label = "matches"}};
  plotting::LineSeries lines[4] = {{.name = "all contacts", .x = {}, .y = {}},
                                   {.name = "of these within 5 mm", .x = {}, .y = {}},
                                   {.name = "filtered", .x = {}, .y = {}},
                                   {.name = "of these within 5 mm (filtered)", .x = {}, .y = {}}};
  for (const std::size_t n : sizes) {
    const PointCloud target = sampled(sweep.mesh, n, RandomStream(options.seed, "target"));
    const Matches raw = match(contacts, target, area), clean = match(filtered, target, area);
    table.add_row({fmt::format("{}", n), fmt::format("{}", raw.all), fmt::format("{}", raw.right),
                   fmt::format("{}", clean.all), fmt::format("{}", clean.right), "at most 2"});
    const std::size_t counts[4] = {raw.all, raw.right, clean.all, clean.right};
    for (int k = 0; k < 4; ++k) {
      lines[k].x.push_back(static_cast<double>(n));
      lines[k].y.push_back(static_cast<double>(counts[k]));
    }
  }
  for (auto& line : lines) plot.series.emplace_back(line);
  table.publish(options, sweep.name,
                fmt::format("{} {} ({} after the filter of 1000 neighbours and ratio "
                            "0.5) against targets of growing density",
                            contacts.size(), sweep.title, filtered.size()));
  experiment::publish_figure(options, "fig_6_4_" + sweep.name, plotting::to_svg(plot));
}

/// The contacts that touch_bunny recorded beside this experiment's folder, if it did, in the frame
/// of the object.
std::optional<Sweep> recorded_sweep(const experiment::Options& options,
                                    const geometry::KnownObject& object) {
  const auto file = options.out.parent_path() / "touch_bunny" / "contacts.csv";
  if (!std::filesystem::exists(file)) return std::nullopt;
  constexpr std::size_t kEvery = 10;  // neighbouring ticks touch the same place
  const Eigen::Vector3d shift(0, 0, object.stable_poses[0].height);
  PointCloud contacts;
  for (const auto& log : tactile::read_contact_log(file)) {
    for (std::size_t i = 0; i < log.frames.size(); i += kEvery) {
      if (!log.normals[i]) continue;
      contacts.points.push_back(log.frames[i].contacts.front().p - shift);
      contacts.normals.push_back(*log.normals[i]);
    }
  }
  return Sweep{"recorded", "contacts of the simulated fingers", contacts, object.mesh};
}

void experiment_matches(const experiment::Options& options) {
  publish_matches(
      options, {"matches", "swept contacts", swept_contacts(RandomStream(options.seed, "contacts")),
                testing::bunny()});
  const auto object = experiment::fixed_object("bunny", geometry::load_known_object("bunny").mesh);
  if (const auto recorded = recorded_sweep(options, object)) publish_matches(options, *recorded);
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(
      argc, argv, "registration_matches",
      "Thesis figure 6.4: feature matches of touched points against the density "
      "of the target; also of the contacts that touch_bunny has recorded beside.",
      experiment_matches);
}
