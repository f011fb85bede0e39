// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <memory>
#include <set>

#include "palpate/core/assets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"

namespace palpate::simulation {
namespace {

hand::Description shadow() { return load_shadow_hand(asset("shadow_hand/right_hand.xml")); }

int link_named(const hand::Description& hand, const std::string& name) {
  for (std::size_t i = 0; i < hand.links.size(); ++i) {
    if (hand.links[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

/// The maker's model as the simulator itself moves it.
class Oracle {
 public:
  Oracle()
      : model_(mj_loadXML(asset("shadow_hand/right_hand.xml").c_str(), nullptr, nullptr, 0),
               mj_deleteModel),
        data_(mj_makeData(model_.get()), mj_deleteData) {}

  void set(const hand::JointVector& joints) {
    for (int i = 0; i < hand::kShadowJoints; ++i) {
      const auto name = "rh_" + std::string(hand::kShadowJointNames[static_cast<std::size_t>(i)]);
      const int id = mj_name2id(model_.get(), mjOBJ_JOINT, name.c_str());
      data_->qpos[model_->jnt_qposadr[id]] = joints[i];
    }
    mj_kinematics(model_.get(), data_.get());
  }

  Eigen::Isometry3d pose(const std::string& link) const {
    const int id = mj_name2id(model_.get(), mjOBJ_BODY, ("rh_" + link).c_str());
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    T.translation() = Eigen::Vector3d(data_->xpos + 3 * id);
    T.linear() = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>(data_->xmat + 9 * id);
    return T;
  }

 private:
  std::unique_ptr<mjModel, void (*)(mjModel*)> model_;
  std::unique_ptr<mjData, void (*)(mjData*)> data_;
};

TEST(Description, MovesAsTheSimulatorMovesIt) {
  const hand::Description hand = shadow();
  ASSERT_EQ(hand.links.size(), 25u);  // forearm, wrist, palm, metacarpal and the fingers
  Oracle oracle;
  RandomStream random(1);
  for (int trial = 0; trial < 50; ++trial) {
    hand::JointVector joints(hand::kShadowJoints);
    for (int i = 0; i < hand::kShadowJoints; ++i) joints[i] = random.uniform(-1.5, 1.5);
    oracle.set(joints);
    const auto T_mount_link = hand::forward_kinematics(hand, joints);
    const auto palm = static_cast<std::size_t>(hand.palm);
    for (std::size_t i = 0; i < hand.links.size(); ++i) {
      const Eigen::Isometry3d expected =
          oracle.pose("palm").inverse() * oracle.pose(hand.links[i].name);
      const Eigen::Isometry3d actual = T_mount_link[palm].inverse() * T_mount_link[i];
      EXPECT_LT((expected.matrix() - actual.matrix()).cwiseAbs().maxCoeff(), 1e-9)
          << hand.links[i].name;
    }
  }
}

TEST(Description, GraspsAtTheMountOriginPalmDown) {
  const hand::Description hand = shadow();
  const Eigen::Isometry3d T_mount_palm = hand::forward_kinematics(
      hand, hand::JointVector::Zero(hand::kShadowJoints))[static_cast<std::size_t>(hand.palm)];
  EXPECT_LT((T_mount_palm * Eigen::Vector3d(0.005, -0.045, 0.08)).norm(), 1e-12);
  const Eigen::Matrix3d& R = T_mount_palm.linear();
  EXPECT_LT((R.col(0) - Eigen::Vector3d::UnitY()).norm(), 1e-12);
  EXPECT_LT((R.col(1) - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_LT((R.col(2) - Eigen::Vector3d::UnitX()).norm(), 1e-12);
}

TEST(Description, EveryJointMovesOneLink) {
  const hand::Description hand = shadow();
  std::set<int> joints;
  for (const hand::Link& link : hand.links) {
    if (link.joint >= 0) {
      EXPECT_TRUE(joints.insert(link.joint).second);
      EXPECT_NEAR(link.axis.norm(), 1.0, 1e-6);
    }
  }
  EXPECT_EQ(joints.size(), static_cast<std::size_t>(hand::kShadowJoints));
}

TEST(Description, TipsAreCapsulesOfSevenMillimetres) {
  const hand::Description hand = shadow();
  for (std::size_t i = 0; i < hand::kShadowFingers; ++i) {
    const auto& tip = hand.fingers[i].tip;
    EXPECT_DOUBLE_EQ(tip.radius, 0.007);
    EXPECT_NEAR(tip.b.z() + tip.radius, i == 0 ? 0.0275 : 0.0265, 1e-12);
    EXPECT_GT(tip.b.z(), tip.a.z());
    EXPECT_LT(tip.a.head<2>().norm() + tip.b.head<2>().norm(), 1e-12);
  }
  EXPECT_EQ(hand.links[static_cast<std::size_t>(hand.fingers[0].link)].name, "thdistal");
  EXPECT_EQ(hand.links[static_cast<std::size_t>(hand.fingers[4].link)].name, "lfdistal");
}

TEST(Description, SpheresCoverThePartsThatTouch) {
  const hand::Description hand = shadow();
  EXPECT_GT(hand.spheres.size(), 60u);
  EXPECT_LT(hand.spheres.size(), 160u) << "every check of collisions looks at each";
  std::set<std::string> covered;
  for (const hand::LinkSphere& sphere : hand.spheres) {
    covered.insert(hand.links[static_cast<std::size_t>(sphere.link)].name);
    EXPECT_GT(sphere.radius, 0.002);
  }
  for (const char* name : {"palm", "ffproximal", "mfmiddle", "rfdistal", "thmiddle", "thdistal",
                           "lfmetacarpal", "forearm"}) {
    EXPECT_TRUE(covered.contains(name)) << name;
  }
}

TEST(Description, SpheresOfATipLieWithinItsCapsule) {
  const hand::Description hand = shadow();
  for (const hand::LinkSphere& sphere : hand.spheres) {
    for (std::size_t i = 0; i < hand::kShadowFingers; ++i) {
      if (sphere.link != hand.fingers[i].link) continue;
      EXPECT_LE(sphere.radius, hand.fingers[i].tip.radius);
      EXPECT_GE(sphere.center.z(), hand.fingers[i].tip.a.z() - 1e-12);
      EXPECT_LE(sphere.center.z(), hand.fingers[i].tip.b.z() + 1e-12);
    }
  }
}

TEST(Description, AMissingFileIsNamed) {
  try {
    load_shadow_hand("/no/such/hand.xml");
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("/no/such/hand.xml"), std::string::npos);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

TEST(HandVisuals, DrawsEveryLinkThatHasAMesh) {
  const hand::Description hand = shadow();
  const hand::HandVisuals visuals = load_hand_visuals(hand);
  EXPECT_EQ(visuals.meshes.size(), 12u);
  EXPECT_GE(visuals.parts.size(), 22u);
  for (const hand::VisualPart& part : visuals.parts) {
    EXPECT_FALSE(visuals.meshes.at(part.mesh).triangles.empty());
    EXPECT_GE(part.color.minCoeff(), 0);
    EXPECT_LE(part.color.maxCoeff(), 1);
  }
}

TEST(HandVisuals, ATipsMeshIsWhereItsCapsuleIs) {
  const hand::Description hand = shadow();
  const hand::HandVisuals visuals = load_hand_visuals(hand);
  const int distal = link_named(hand, "ffdistal");
  for (const hand::VisualPart& part : visuals.parts) {
    if (part.link != distal) continue;
    const auto mesh = geometry::transformed(part.T_link_mesh, visuals.meshes.at(part.mesh));
    const Eigen::AlignedBox3d box = geometry::bounds(mesh);
    EXPECT_TRUE(box.contains(0.5 * (hand.fingers[1].tip.a + hand.fingers[1].tip.b)));
    EXPECT_TRUE(box.contains(hand.fingers[1].tip.b));
    EXPECT_LT(box.sizes().maxCoeff(), 0.05);
  }
}

}  // namespace
}  // namespace palpate::simulation
