// SPDX-License-Identifier: Apache-2.0
#include "localization/search/descent.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "localization/likelihood/energy_maker.hpp"
#include "localization/scenes.hpp"
#include "palpate/geometry/objects/shapes.hpp"

namespace palpate::localization {
namespace {

/// Draws poses about one only, as proposals may that have missed its twin.
class NarrowProposal : public Proposal {
 public:
  explicit NarrowProposal(const Eigen::Isometry3d& T) : T_(T) {}
  SearchPose draw(RandomStream& random) const override {
    SearchPose pose{T_.linear().cast<float>(), T_.translation().cast<float>()};
    pose.R = turn_by(0.05F * random.normal3().cast<float>()) * pose.R;
    pose.t += 0.002F * random.normal3().cast<float>();
    return pose;
  }
  float energy(const SearchPose&) const override { return 0; }

 private:
  Eigen::Isometry3d T_;
};

/// A block of which one end is 1 mm thicker than the other.
geometry::KnownObject wedge() {
  geometry::TriangleMesh mesh = geometry::box_mesh({0.12, 0.05, 0.03});
  for (auto& v : mesh.vertices) v.z() *= 1 + v.x() / 0.06 / 30;
  return geometry::make_known_object("wedge", mesh, 0.1);
}

TEST(Descent, HalfTurnsAreRotationsByPi) {
  for (const Eigen::Matrix3d& turn : half_turns(wedge())) {
    EXPECT_NEAR(turn.determinant(), 1, 1e-9);
    EXPECT_NEAR(turn.trace(), -1, 1e-9);
    EXPECT_LT((turn * turn - Eigen::Matrix3d::Identity()).norm(), 1e-9);
  }
}

TEST(Descent, FindsTheTwinThatNoProposalLeadsTo) {
  const geometry::ObjectModel model(wedge());
  RandomStream random(3);
  Evidence evidence;
  const Eigen::Isometry3d truth = random_pose(random);
  for (const auto& point : model.surface()) {
    if (evidence.contacts.size() == 60) break;
    if (random.uniform() > 0.05) continue;
    tactile::Contact contact;
    contact.p = truth * point.p.cast<double>();
    contact.n = truth.linear() * point.n.cast<double>();
    contact.point_sigma = 0.0003;
    contact.normal_sigma = 0.1;
    evidence.contacts.push_back(contact);
  }
  Eigen::Isometry3d twin = truth;
  twin.linear() = truth.linear() * Eigen::Vector3d(-1, -1, 1).asDiagonal();
  const NarrowProposal proposal(twin);
  const EnergyMaker energy_at(model, evidence, 0.003);
  const SymmetryGroup symmetries({Eigen::Matrix3d::Identity()});
  DescentOptions options{.proposals = 50, .starts = 10, .first_scale = 3};
  const auto error_of_best = [&] {
    RandomStream draws(1);
    const auto basins = find_basins(
        proposal, [&](double s) { return energy_at(s); }, symmetries, options, draws);
    return pose_error(basins.front().pose.isometry(), truth, {Eigen::Matrix3d::Identity()});
  };
  EXPECT_GT(error_of_best().rotation, 3);
  options.near_symmetries = half_turns(model.object());
  EXPECT_LT(error_of_best().rotation, 0.02);
  EXPECT_LT(error_of_best().translation, 0.002);
}

}  // namespace
}  // namespace palpate::localization
