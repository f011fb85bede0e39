// SPDX-License-Identifier: Apache-2.0
#include "palpate/geometry/objects/generated_shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numbers>

#include "geometry/objects/solids.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/repair/mesh_repair.hpp"

namespace palpate::geometry {
namespace {

constexpr std::string_view kPrefix = "generated:";
constexpr std::uint64_t kMaxNames = 10000;
constexpr double kScanError = 0.0003;  // m, rms
constexpr double kBroken = 0.006;      // m, most by which a symmetry is broken
constexpr double kFewest = 1000, kMost = 50000;
constexpr double kMargin = 0.008;  // m, about the shape

struct Draft {
  Solid solid;
  Eigen::Vector3d half;  ///< of a box that holds it, m
  double wall = 0;       ///< its thinnest part, m; 0: nothing is thin
};

bool bernoulli(RandomStream& random, double probability) { return random.uniform() < probability; }

/// Half axes of household objects: one to two sides that a hand may span, one longer.
Eigen::Vector3d draw_half(RandomStream& random) {
  return {random.uniform(0.017, 0.042), random.uniform(0.012, 0.040), random.uniform(0.018, 0.095)};
}

Draft draw_superquadric(RandomStream& random) {
  const Eigen::Vector3d half = draw_half(random);
  const double e2 = random.uniform(0.2, 1.6), e1 = random.uniform(0.2, 1.3);
  return {superquadric(half, e1, e2), half};
}

Draft draw_loft(RandomStream& random) {
  const Eigen::Vector3d half = draw_half(random);
  const Loft loft{.a = half.x(),
                  .b = half.y(),
                  .h = half.z(),
                  .e = random.uniform(0.2, 1.2),
                  .taper = random.uniform(0, 0.6),
                  .twist = bernoulli(random, 0.3) ? random.uniform(0, 0.4) : 0,
                  .bend = bernoulli(random, 0.4) ? random.uniform(0, 0.03) : 0};
  const double wide = std::max(half.x(), half.y());
  return {lofted(loft), {wide + loft.bend, wide, half.z()}};
}

Draft draw_revolved(RandomStream& random) {
  const double radius = random.uniform(0.018, 0.042), h = random.uniform(0.02, 0.095);
  std::vector<double> radii;
  for (int i = 0; i < 5; ++i) radii.push_back(radius * random.uniform(0.55, 1));
  return {revolved(std::move(radii), h), {1.1 * radius, 1.1 * radius, h}};
}

Draft draw_body(RandomStream& random) {
  const double kind = random.uniform();
  return kind < 0.35  ? draw_superquadric(random)
         : kind < 0.7 ? draw_loft(random)
                      : draw_revolved(random);
}

/// A place on the body's side, somewhat inside of it.
Eigen::Isometry3d place_on(const Draft& draft, RandomStream& random) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = random.rotation();
  const double angle = random.uniform(0, 2 * std::numbers::pi);
  T.translation() << 0.7 * draft.half.x() * std::cos(angle), 0.7 * draft.half.y() * std::sin(angle),
      random.uniform(-0.8, 0.8) * draft.half.z();
  return T;
}

/// Opens the body as a cup, or joins or cuts away another.
void combine(Draft& draft, RandomStream& random) {
  if (bernoulli(random, 0.3)) {
    draft.wall = random.uniform(0.003, 0.005);
    draft.solid = hollowed(draft.solid, draft.wall, 0.85 * draft.half.z());
    return;
  }
  if (!bernoulli(random, 0.5)) return;
  const Eigen::Vector3d half = random.uniform(0.4, 0.7) * draft.half;
  const double e2 = random.uniform(0.2, 1.2), e1 = random.uniform(0.2, 1.2);
  Solid other = moved(place_on(draft, random), superquadric(half, e1, e2));
  if (bernoulli(random, 0.5)) {
    draft.solid = cut(draft.solid, std::move(other));
    return;
  }
  draft.solid = joined(draft.solid, std::move(other), 0.004);
  draft.half.array() += half.maxCoeff();
}

void add_handle(Draft& draft, RandomStream& random) {
  const double radius = random.uniform(0.004, 0.006), reach = random.uniform(0.02, 0.035);
  const double top = random.uniform(0.3, 0.7) * draft.half.z(), x = 0.75 * draft.half.x();
  // It stays outside of a hollow body's wall by ending within it.
  draft.solid = joined(draft.solid, handle(x, reach, -top, top, radius), 0.002);
  draft.half.x() += reach + radius;
  draft.wall = draft.wall > 0 ? draft.wall : 2 * radius;
}

/// A bump on one side and, at times, none to be seen: what breaks the symmetry is 0 to 6 mm high.
void break_symmetry(Draft& draft, RandomStream& random) {
  const double height = random.uniform(0, kBroken);
  const Eigen::Vector3d half = draft.half;
  const Eigen::Vector3d at(0.6 * half.x(), 0.3 * half.y(), random.uniform(0.2, 0.8) * half.z());
  const double width = random.uniform(0.008, 0.02);
  draft.solid = [solid = draft.solid, at, height, width](const Eigen::Vector3d& p) {
    return solid(p) - height * std::exp(-(p - at).squaredNorm() / (2 * width * width));
  };
  draft.half.array() += height;
}

TriangleMesh largest_part(const TriangleMesh& mesh) {
  std::vector<TriangleMesh> parts = components(mesh);
  if (parts.empty()) return {};
  return *std::ranges::max_element(parts, {}, [](const TriangleMesh& part) { return area(part); });
}

/// Extracts the surface with about as many triangles as asked for, as far as thin walls allow.
TriangleMesh mesh_of(const Draft& draft, double triangles) {
  const Eigen::Vector3d half = draft.half.array() + kMargin;
  const Eigen::AlignedBox3d box(-half, half);
  const auto count = [](const TriangleMesh& mesh) {
    return static_cast<double>(mesh.triangles.size());
  };
  double cell = half.maxCoeff() / 16;
  TriangleMesh mesh = extract_surface(draft.solid, box, cell);
  cell *= std::sqrt(std::max(count(mesh), 100.0) / triangles);
  if (draft.wall > 0) cell = std::min(cell, draft.wall / 1.5);
  for (int attempt = 0; attempt < 8; ++attempt) {
    mesh = largest_part(extract_surface(draft.solid, box, cell));
    if (count(mesh) > kMost) {
      cell *= 1.02 * std::sqrt(count(mesh) / kMost);
    } else if (count(mesh) < kFewest) {
      cell *= 0.98 * std::sqrt(std::max(count(mesh), 100.0) / kFewest);
    } else {
      break;
    }
  }
  return mesh;
}

std::uint64_t whole_number(std::string_view text, std::string_view name) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) {
    throw BadInput(fmt::format(
        "'{}' names no generated object: '{}' is followed by a whole number, at least 0", name,
        kPrefix));
  }
  return value;
}

/// Appends the names of a range; false if the name is none.
bool append_range(const std::string& name, std::vector<std::string>& all) {
  const auto dash = name.find('-');
  if (!name.starts_with(kPrefix) || dash == std::string::npos) return false;
  const std::string_view text = name;
  const auto first = whole_number(text.substr(kPrefix.size(), dash - kPrefix.size()), name);
  const auto last = whole_number(text.substr(dash + 1), name);
  if (last < first || last - first >= kMaxNames) {
    throw BadInput(fmt::format("'{}' is no range of 1 to {} objects", name, kMaxNames));
  }
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    all.push_back(fmt::format("{}{}", kPrefix, seed));
  }
  return true;
}

}  // namespace

TriangleMesh generated_shape(std::uint64_t seed) {
  RandomStream random(seed, "generated shape");
  Draft draft = draw_body(random);
  combine(draft, random);
  if (bernoulli(random, 0.25)) add_handle(draft, random);
  if (bernoulli(random, 0.4)) break_symmetry(draft, random);
  draft.solid = scanned(draft.solid, kScanError, random.fork("scan"));
  return mesh_of(draft, kFewest * std::pow(kMost / kFewest, random.uniform()));
}

std::optional<std::uint64_t> generated_seed(std::string_view name) {
  if (!name.starts_with(kPrefix)) return std::nullopt;
  return whole_number(name.substr(kPrefix.size()), name);
}

std::vector<std::string> expand_object_names(const std::vector<std::string>& names) {
  std::vector<std::string> all;
  for (const std::string& name : names) {
    if (!append_range(name, all)) all.push_back(name);
  }
  return all;
}

}  // namespace palpate::geometry
