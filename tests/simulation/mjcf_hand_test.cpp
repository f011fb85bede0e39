// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/hand/mjcf_hand.hpp"

#include <gtest/gtest.h>

#include "core/error_message.hpp"
#include "core/temporary_folder.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/random.hpp"

namespace palpate::simulation {
namespace {

MjcfHand adroit() { return {asset("adroit_hand/adroit_relocate.xml"), "palm"}; }
MjcfHand shadow() { return {asset("shadow_hand/right_hand.xml"), "rh_palm"}; }

Eigen::VectorXd random_joints(const MjcfHand& hand, RandomStream& random) {
  Eigen::VectorXd q(hand.lower().size());
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    q[i] = random.uniform(hand.lower()[i], hand.upper()[i]);
  }
  return q;
}

TEST(MjcfHand, ReadsTwoHands) {
  EXPECT_EQ(adroit().joint_names().size(), 22U);
  EXPECT_EQ(adroit().joint_names().front(), "FFJ3");
  EXPECT_EQ(shadow().joint_names().size(), 22U);
}

TEST(MjcfHand, JacobianIsTheDerivativeOfThePositions) {
  for (auto hand : {&adroit, &shadow}) {
    MjcfHand model = hand();
    const bool is_shadow = hand == &shadow;
    const std::vector<hand::HandPoint> points = {
        model.point(is_shadow ? "rh_thdistal" : "S_thtip"),
        model.point(is_shadow ? "rh_lfmiddle" : "lfmiddle")};
    RandomStream random(5);
    const Eigen::VectorXd q = random_joints(model, random);
    const auto here = model.evaluate(q, points);
    constexpr double kStep = 1e-6;
    for (Eigen::Index i = 0; i < q.size(); ++i) {
      Eigen::VectorXd moved = q;
      moved[i] += kStep;
      const Eigen::Matrix3Xd change =
          (model.evaluate(moved, points).positions - here.positions) / kStep;
      EXPECT_LT((change.reshaped() - here.jacobian.col(i)).norm(), 1e-5) << i;
    }
  }
}

TEST(MjcfHand, DistinguishesATipFromTheMiddleOfALink) {
  const MjcfHand hand = adroit();
  EXPECT_GT(hand.share_of_link(hand.point("S_mftip")), 0.7);
  EXPECT_NEAR(hand.share_of_link(hand.point("Tch_ffproximal")), 0.4, 0.15);
  EXPECT_EQ(hand.share_of_link(hand.point("ffdistal")), 0);
}

TEST(MjcfHand, RejectsBadInput) {
  MjcfHand hand = adroit();
  EXPECT_NE(error_message([&] { hand.point("S_sixth"); }).find("S_sixth"), std::string::npos);
  EXPECT_NE(
      error_message([] { MjcfHand(asset("adroit_hand/adroit_relocate.xml"), "paw"); }).find("paw"),
      std::string::npos);
  EXPECT_NE(error_message([] { MjcfHand("/nowhere/hand.xml", "palm"); }), "");
  EXPECT_NE(error_message([&] { hand.evaluate(Eigen::VectorXd::Zero(5), {}); }).find("5"),
            std::string::npos);
  const TemporaryFolder folder;
  write_file_atomically(folder.path() / "still.xml",
                        "<mujoco><worldbody><body name='palm'><geom size='.1'/></body></worldbody>"
                        "</mujoco>");
  EXPECT_NE(error_message([&] { MjcfHand(folder.path() / "still.xml", "palm"); }).find("moves"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate::simulation
