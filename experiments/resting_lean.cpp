// SPDX-License-Identifier: Apache-2.0
// How far objects lean whose surface and centre of mass are not as believed, against the standard
// deviation of RestingSlack.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "experiment.hpp"
#include "geometry/mesh/convex_hull.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/objects/resting_slack.hpp"
#include "simulation/world/drawn_errors.hpp"

namespace {

using namespace palpate;
using experiment::Options;

constexpr std::uint64_t kGenerated = 100;
constexpr std::size_t kDraws = 16;  // of a world, for each object
constexpr int kWays = 64;           // in which an object is leaned to find where it is lower
constexpr double kFirstStep = 0.01, kLastStep = 2e-4, kShrink = 0.6;  // rad
constexpr double kFallen = 0.5;  // rad; farther is another stable pose

/// What differs in the drawn worlds, and what the localizer allows for.
struct Errors {
  const char* name;
  double surface;  ///< m, rms of the displacement of each point
  double center;   ///< m, rms of the displacement of the centre of mass
  double surface_sigma, centroid_sigma;
};
constexpr std::array<Errors, 2> kErrors = {
    {{"surface", 0.0005, 0, 0.0003, 0},
     {"surface and centre of mass", 0.0005, 0.005, 0.0005, 0.003}}};

/// What decides how an object rests.
struct Body {
  std::vector<Eigen::Vector3d> hull;
  Eigen::Vector3d center;  ///< of mass
};

Body body_of(const geometry::KnownObject& object) {
  return {geometry::hull_corners(object.mesh.vertices), object.mass_properties.centroid};
}

/// Height of the centre of mass where that direction points up, m.
double height(const Body& body, const Eigen::Vector3d& up) {
  double low = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : body.hull) low = std::min(low, p.dot(up));
  return body.center.dot(up) - low;
}

/// The upward direction in which the body comes to rest, from one near it: downhill.
Eigen::Vector3d settle(const Body& body, const Eigen::Vector3d& first) {
  Eigen::Vector3d up = first;
  double lowest = height(body, up);
  for (double step = kFirstStep; step > kLastStep;) {
    const Eigen::Matrix3d frame = frame_with_z(up);
    const Eigen::Vector3d from = up;
    for (int i = 0; i < kWays; ++i) {
      const double way = 2 * std::numbers::pi * i / kWays;
      const Eigen::Vector3d side = std::cos(way) * frame.col(0) + std::sin(way) * frame.col(1);
      const Eigen::Vector3d leaning = std::cos(step) * from + std::sin(step) * side;
      const double found = height(body, leaning);
      if (found >= lowest) continue;
      lowest = found;
      up = leaning;
    }
    if (up == from) step *= kShrink;
    if (up.dot(first) < std::cos(kFallen)) break;
  }
  return up;
}

/// Of the leans of all stable poses of an object, each over its standard deviation.
struct Leans {
  std::vector<double> degrees, standardized;
  int fallen = 0;
};

void append(const Leans& more, Leans& all) {
  all.degrees.insert(all.degrees.end(), more.degrees.begin(), more.degrees.end());
  all.standardized.insert(all.standardized.end(), more.standardized.begin(),
                          more.standardized.end());
  all.fallen += more.fallen;
}

Leans leans_of(const geometry::KnownObject& known, const Errors& errors, std::size_t draws,
               const RandomStream& random) {
  const Body believed = body_of(known);
  Leans leans;
  for (std::size_t draw = 0; draw < draws; ++draw) {
    const simulation::WorldErrors world{.center = errors.center, .surface = errors.surface};
    const Body body =
        body_of(simulation::differing_object({known, {}}, world, random.fork("draw", draw)).object);
    for (const geometry::StablePose& pose : known.stable_poses) {
      const geometry::RestingSlack slack(believed.hull, pose);
      const Eigen::Vector3d up = pose.R_table_object.row(2).transpose();
      const Eigen::Vector3d leaning = settle(body, up);
      if (leaning.dot(up) < std::cos(kFallen)) {
        ++leans.fallen;
        continue;
      }
      for (const int i : {0, 1}) {
        const double lean = std::abs(leaning.dot(slack.directions()[static_cast<std::size_t>(i)]));
        const double sigma = slack.lean(i, errors.surface_sigma, errors.centroid_sigma);
        leans.degrees.push_back(lean * kDegreesPerRadian);
        leans.standardized.push_back(lean / std::max(sigma, kLastStep));
      }
    }
  }
  return leans;
}

std::vector<std::string> generated(const Options& options) {
  std::vector<std::string> names;
  for (std::uint64_t i = 0; i < (options.quick ? 1 : kGenerated); ++i) {
    names.push_back(fmt::format("generated:{}", options.seed + i));
  }
  return names;
}

void add_row(const std::string& objects, const Errors& errors, const Leans& leans,
             experiment::Table& table) {
  const auto within = [&](double sigmas) {
    const auto held =
        std::ranges::count_if(leans.standardized, [&](double lean) { return lean < sigmas; });
    return fmt::format("{:.3f}",
                       static_cast<double>(held) / static_cast<double>(leans.standardized.size()));
  };
  table.add_row({objects, errors.name, fmt::format("{}", leans.degrees.size() / 2),
                 fmt::format("{}", leans.fallen), fmt::format("{:.2f}", median(leans.degrees)),
                 within(1), within(2), within(3)});
}

void measure(const Options& options) {
  experiment::Table table({"objects", "differs", "objects at rest", "fell", "median lean deg",
                           "within 1 sigma", "within 2 sigma", "within 3 sigma"});
  const std::size_t draws = options.quick ? 1 : kDraws;
  const auto built_in =
      options.quick ? std::vector<std::string>{"box"} : geometry::built_in_objects();
  for (const auto& [label, names] :
       {std::pair{"built-in", built_in}, std::pair{"generated", generated(options)}}) {
    for (const Errors& errors : kErrors) {
      std::vector<Leans> found(names.size());
      parallel_for(names.size(), options.threads, [&](std::size_t i) {
        const RandomStream random(options.seed, names[i]);
        found[i] = leans_of(geometry::load_known_object(names[i]), errors, draws, random);
      });
      Leans all;
      for (const Leans& leans : found) append(leans, all);
      add_row(label, errors, all, table);
    }
  }
  table.publish(options, "resting_lean",
                "leans of objects at rest in worlds drawn at random, in two directions, over the "
                "standard deviation that RestingSlack gives, without that of the table's tilt; a "
                "normal distribution holds 0.683, 0.954 and 0.997 within 1, 2 and 3");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "resting_lean",
                         "Leans of objects whose surface and centre of mass are not as believed",
                         measure);
}
