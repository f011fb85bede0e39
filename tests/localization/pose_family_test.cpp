// SPDX-License-Identifier: Apache-2.0
#include "localization/search/pose_family.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "palpate/core/random.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

/// Turns about a line every 2 degrees, with the flips if asked; not sorted.
std::vector<Eigen::Quaterniond> turns_about(const Eigen::Vector3d& axis, bool flips) {
  std::vector<Eigen::Quaterniond> group;
  const Eigen::Quaterniond flip(Eigen::AngleAxisd(M_PI, frame_with_z(axis).col(0)));
  for (int k = 0; k < 180; ++k) {
    group.emplace_back(Eigen::AngleAxisd(2 * M_PI * (k * 7 % 180) / 180, axis));
    if (flips) group.push_back(group.back() * flip);
  }
  return group;
}

/// The turns of a body of revolution are looked through with a bound; each by itself is not.
class FamilyOfTurns : public ::testing::TestWithParam<bool> {
 protected:
  FamilyOfTurns()
      : line_(random_.unit_vector()),
        listed_(turns_about(line_, GetParam())),
        group_(listed_),
        family_({Eigen::Quaterniond(random_.rotation()), 0.05 * random_.normal3()},
                {0.05 * random_.normal3(), random_.unit_vector(), 0.6}) {}

  /// Near the family, by up to about twice the tolerance, turned by some symmetry.
  PosePoint near() {
    const PosePoint member = family_.at(random_.uniform(-0.7, 0.7));
    const Eigen::Quaterniond off(exp_so3(0.06 * random_.normal3()));
    return {off * member.q * listed_[random_.index(listed_.size())].conjugate(),
            member.t + 0.005 * random_.normal3()};
  }
  PosePoint anywhere() {
    return {Eigen::Quaterniond(random_.rotation()), 0.02 * random_.normal3()};
  }

  RandomStream random_{7};
  Eigen::Vector3d line_;
  std::vector<Eigen::Quaterniond> listed_;
  SymmetryGroup group_;
  SymmetryGroup none_{Eigen::Quaterniond::Identity()};
  PoseFamily family_;
};

TEST_P(FamilyOfTurns, HoldsWhatItHoldsAfterAnyListedTurn) {
  ASSERT_FALSE(group_.turns().empty());
  int held = 0, others = 0;
  for (int i = 0; i < 2000; ++i) {
    const PosePoint pose = i % 4 == 0 ? anywhere() : near();
    bool any = false;
    for (const auto& s : listed_) any = any || family_.contains({pose.q * s, pose.t}, none_);
    EXPECT_EQ(family_.contains(pose, group_), any);
    ++(any ? held : others);
  }
  EXPECT_GT(held, 300);
  EXPECT_GT(others, 300);
}

TEST_P(FamilyOfTurns, MatchesAsTheBestListedTurn) {
  for (int i = 0; i < 1000; ++i) {
    const PosePoint pose = i % 4 == 0 ? anywhere() : near();
    PoseFamily::Match best = family_.match(pose, none_);
    for (const auto& s : listed_) {
      const auto other = family_.match({pose.q * s, pose.t}, none_);
      if (relative_error(other.error) < relative_error(best.error)) best = other;
    }
    const auto found = family_.match(pose, group_);
    EXPECT_EQ(found.along, best.along);
    EXPECT_EQ(found.error.rotation, best.error.rotation);
    EXPECT_EQ(found.error.translation, best.error.translation);
    EXPECT_EQ(found.image.q.coeffs(), best.image.q.coeffs());
  }
}

INSTANTIATE_TEST_SUITE_P(Localization, FamilyOfTurns, ::testing::Bool());

TEST(SymmetryGroup, ListsTurnsOfBodiesOfRevolutionOnly) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 2, 3).normalized();
  const SymmetryGroup flips(turns_about(axis, true));
  ASSERT_EQ(flips.turns().size(), 2U);
  EXPECT_EQ(flips.turns()[0].turns.size(), 180U);
  EXPECT_EQ(flips.turns()[1].turns.size(), 180U);
  EXPECT_TRUE(SymmetryGroup{Eigen::Quaterniond::Identity()}.turns().empty());
}

}  // namespace
}  // namespace palpate::localization
