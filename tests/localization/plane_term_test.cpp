// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/plane_term.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "localization/likelihood/surface_error.hpp"
#include "localization/scenes.hpp"
#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

constexpr double kSigma = 0.001;  // m

Evidence met(const Eigen::Vector3d& normal, double height) {
  Evidence evidence;
  evidence.surface_sigma = 0;
  evidence.planes = {{normal, height, kSigma}};
  return evidence;
}

double energy(const Evidence& evidence, const SearchPose& pose, double scale = 1) {
  const PlaneTerm term(model_of("box"), evidence, scale);
  return static_cast<double>(term.energy(pose, kNoBound));
}

/// Height of the lowest vertex of the box over the origin.
double lowest(const Eigen::Isometry3d& T, const Eigen::Vector3d& normal) {
  double low = std::numeric_limits<double>::infinity();
  for (const auto& vertex : model_of("box").object().mesh.vertices) {
    low = std::min(low, normal.dot(T * vertex));
  }
  return low;
}

SearchPose search_pose(const Eigen::Isometry3d& T) {
  return {T.linear().cast<float>(), T.translation().cast<float>()};
}

TEST(PlaneTerm, TheLowestCornerLiesOnThePlane) {
  RandomStream random(1, "poses");
  for (int i = 0; i < 20; ++i) {
    const Eigen::Isometry3d T = random_pose(random);
    const Eigen::Vector3d normal = random.normal3().normalized();
    const double height = lowest(T, normal);
    const double on = energy(met(normal, height), search_pose(T));
    EXPECT_NEAR(energy(met(normal, height - 0.001), search_pose(T)) - on, 0.5, 0.02);
    EXPECT_NEAR(energy(met(normal, height + 0.002), search_pose(T)) - on, 2, 0.08);
  }
}

TEST(PlaneTerm, ErrorsOfTheSurfaceAndTheScaleOfTheNoiseWidenIt) {
  const Eigen::Vector3d up(0, 0, 1);
  const Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const double height = lowest(T, up);
  const auto rise = [&](double surface, double scale) {
    Evidence there = met(up, height), above = met(up, height + 0.002);
    there.surface_sigma = above.surface_sigma = surface;
    there = with_surface_error(there), above = with_surface_error(above);
    return energy(above, search_pose(T), scale) - energy(there, search_pose(T), scale);
  };
  EXPECT_NEAR(rise(0, 2) / rise(0, 1), 0.25, 0.03);
  EXPECT_NEAR(rise(kSigma, 1) / rise(0, 1), 0.5, 0.03);
}

TEST(PlaneTerm, IsNoughtWhereThePlaneIsMet) {
  const Evidence evidence = met({0, 0, 1}, lowest(Eigen::Isometry3d::Identity(), {0, 0, 1}));
  EXPECT_NEAR(energy(evidence, SearchPose()), 0, 1e-3);
  EXPECT_GE(energy(evidence, SearchPose()), 0);
}

TEST(PlaneTerm, SomethingElseMayHaveMetThePlane) {
  const Evidence evidence = met({0, 0, 1}, 0.3);
  const double far = energy(evidence, SearchPose());
  EXPECT_LT(far, 10);  // 0.5 (300 / 1)^2 otherwise
  EXPECT_NEAR(far, energy(met({0, 0, 1}, 0.5), SearchPose()), 1e-3);
}

TEST(PlaneTerm, LinearizesItself) {
  RandomStream random(2, "poses");
  for (int i = 0; i < 20; ++i) {
    const Eigen::Isometry3d T = random_pose(random);
    const Eigen::Vector3d normal = random.normal3().normalized();
    const Evidence evidence = met(normal, lowest(T, normal) + 0.0005);
    const PlaneTerm term(model_of("box"), evidence, 1);
    const SearchPose pose = search_pose(T);
    NormalEquations equations;
    term.linearize(pose, equations);
    for (int axis = 0; axis < 6; ++axis) {
      const auto moved = [&](float step) {
        Eigen::Matrix<float, 6, 1> x = Eigen::Matrix<float, 6, 1>::Zero();
        x[axis] = step;
        const SearchPose there{turn_by(x.head<3>()) * pose.R, pose.t + x.tail<3>()};
        return static_cast<double>(term.energy(there, kNoBound));
      };
      const float h = axis < 3 ? 1e-3F : 1e-4F;
      const double slope = (moved(h) - moved(-h)) / (2 * static_cast<double>(h));
      EXPECT_NEAR(equations.g[axis], slope, 0.05 * std::abs(slope) + 0.5) << axis;
    }
  }
}

TEST(Localize, PlanesThatTheObjectTouchedMakeItsPoseExact) {
  const auto& model = model_of("bracket");
  SceneOptions few;
  few.contacts = 6;
  few.normal_noise = 0.1;
  double before = 0, after = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Scene scene = make_scene(model, few, RandomStream(seed, "scene"));
    PosePrior prior;
    const Vector6d sigmas = (Vector6d() << 0.06, 0.06, 0.06, 0.004, 0.004, 0.004).finished();
    Eigen::Isometry3d off = scene.truth;
    off.linear() = exp_so3(Eigen::Vector3d(0.05, -0.04, 0.03)) * off.linear();
    prior.components.push_back({off, 0.98, sigmas.cwiseAbs2().asDiagonal()});
    scene.evidence.prior = prior;
    const auto error = [&] {
      const auto posterior = localize(model, scene.evidence, RandomStream(seed));
      return pose_error(posterior.modes.front().T_frame_object, scene.truth,
                        model.object().symmetries)
          .rotation;
    };
    before += error();
    for (const Eigen::Vector3d& n :
         {Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(0.4, 0, 1), Eigen::Vector3d(-0.2, 0.35, 1),
          Eigen::Vector3d(-0.2, -0.35, 1)}) {
      const Eigen::Vector3d normal = n.normalized();
      double low = std::numeric_limits<double>::infinity();
      for (const auto& vertex : model.object().mesh.vertices) {
        low = std::min(low, normal.dot(scene.truth * vertex));
      }
      scene.evidence.planes.push_back({normal, low, 0.0005});
    }
    after += error();
  }
  EXPECT_LT(after, 0.7 * before);
}

TEST(Localize, RefusesAPlaneThatCannotBe) {
  Scene scene = make_scene(model_of("box"), {}, RandomStream(1, "scene"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const PlaneContact& plane :
       {PlaneContact{{0, 0, 2}, 0, kSigma}, PlaneContact{{0, 0, nan}, 0, kSigma},
        PlaneContact{{0, 0, 1}, nan, kSigma}, PlaneContact{{0, 0, 1}, 0, 0}}) {
    scene.evidence.planes = {plane};
    EXPECT_THROW(localize(model_of("box"), scene.evidence, RandomStream(1)), BadInput);
  }
}

}  // namespace
}  // namespace palpate::localization
