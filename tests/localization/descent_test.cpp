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
  const EnergyMaker energy_at(model, evidence, LocalizerOptions{});
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

TEST(EnergyMaker, ExactContactsStartAsWideAsOthers) {
  const geometry::ObjectModel model(wedge());
  Evidence evidence;
  tactile::Contact contact;
  contact.p = {0, 0.025, 0};
  contact.n = {0, 1, 0};
  contact.normal_sigma = 0.1;
  evidence.contacts.push_back(contact);
  evidence.noise_scale_prior = evidence.size_prior = 0;
  const SearchPose off{Eigen::Matrix3f::Identity(), {0, 0.003F, 0}};
  const auto misfit_at_start = [&](double point_sigma) {
    evidence.contacts[0].point_sigma = point_sigma;
    const EnergyMaker energy_at(model, evidence, LocalizerOptions{});
    const Energy start = energy_at(energy_at.first_scale());
    return start(off) - start(SearchPose{Eigen::Matrix3f::Identity(), Eigen::Vector3f::Zero()});
  };
  const float usual = misfit_at_start(0.001);
  EXPECT_NEAR(usual, 0.5, 0.05);  // of one standard deviation
  EXPECT_NEAR(misfit_at_start(0.00001), usual, 0.01);
  EXPECT_NEAR(misfit_at_start(0.002), 0.125, 0.03);
}

TEST(EnergyMaker, TheLastScaleIsTheStatedNoise) {
  const geometry::ObjectModel model(wedge());
  Evidence evidence;
  tactile::Contact contact;
  contact.p = {0, 0.025, 0};
  contact.point_sigma = 0.00001;
  evidence.contacts.push_back(contact);
  LocalizerOptions narrow;
  narrow.first_point_sigma = 0;
  const SearchPose off{Eigen::Matrix3f::Identity(), {0, 0.00001F, 0}};
  EXPECT_EQ(EnergyMaker(model, evidence, {})(1)(off), EnergyMaker(model, evidence, narrow)(1)(off));
  EXPECT_EQ(EnergyMaker(model, evidence, narrow).first_scale(), 3);
  EXPECT_NEAR(EnergyMaker(model, evidence, {}).first_scale(), 300, 1e-9);
  evidence.contacts[0].point_sigma = 1e-310;
  EXPECT_NEAR(EnergyMaker(model, evidence, {}).first_scale(), 300, 1e-9);
}

}  // namespace
}  // namespace palpate::localization
