// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/world/object_step.hpp"

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "palpate/core/assets.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/grasping/force_closure.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/simulation/world/open_loop_grasp.hpp"
#include "palpate/simulation/world/world.hpp"
#include "simulation/scenes.hpp"

namespace palpate::simulation {
namespace {

constexpr double kTimeStep = 0.002;  // s, the default of WorldOptions

/// A bar to take from above, and the steps of a grasp of it.
struct RecordedGrasp {
  geometry::KnownObject object = cuboid({0.12, 0.04, 0.05}, 0.2);
  World world{object, without_noise(), 1};
  std::vector<ObjectStep> steps;
  bool lifted = false;

  RecordedGrasp() {
    world.observe([this](const ObjectStep& step) { steps.push_back(step); });
    OpenLoopGrasp grasp;
    grasp.side = false;
    grasp.height = 0.04;
    grasp.start.yaw = 0.5 * M_PI;
    lifted = run_open_loop_grasp(world, grasp);
  }
};

const RecordedGrasp& recorded_grasp() {
  static const RecordedGrasp grasp;
  return grasp;
}

grasping::GraspContacts grasp_contacts(const ObjectStep& step) {
  grasping::GraspContacts contacts;
  for (const ObjectContact& contact : step.contacts) {
    if (contact.link < 0) continue;
    contacts.push_back({contact.T_world_contact, contact.link, contact.model, contact.friction});
  }
  return contacts;
}

Eigen::VectorXd contact_wrenches(const ObjectStep& step) {
  std::vector<double> values;
  for (const ObjectContact& contact : step.contacts) {
    if (contact.link < 0) continue;
    values.insert(values.end(), contact.wrench.data(), contact.wrench.data() + 6);
  }
  return Eigen::VectorXd::Map(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// The last step in which the object hangs in the hand alone.
const ObjectStep& held_step() {
  const auto& steps = recorded_grasp().steps;
  const auto found = std::find_if(steps.rbegin(), steps.rend(), [](const ObjectStep& step) {
    return grasp_contacts(step).size() >= 2 && grasp_contacts(step).size() == step.contacts.size();
  });
  return found == steps.rend() ? steps.back() : *found;
}

TEST(ObjectStep, TheGraspHolds) {
  EXPECT_TRUE(recorded_grasp().lifted);
  EXPECT_GE(grasp_contacts(held_step()).size(), 2u);
}

TEST(ObjectStep, ForcesMakeTheChangeOfMomentum) {
  double largest = 0;
  for (const ObjectStep& step : recorded_grasp().steps) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const ObjectContact& contact : step.contacts) {
      sum += contact.T_world_contact.linear() * contact.wrench.tail<3>();
    }
    const Eigen::Vector3d expected = step.momentum_change / kTimeStep - step.gravity;
    ASSERT_LT((sum - expected).norm(), 0.02 * std::max(expected.norm(), step.gravity.norm()))
        << "at " << step.time << " s";
    largest = std::max(largest, sum.norm());
  }
  EXPECT_GT(largest, 1);
}

TEST(ObjectStep, ForcesStayWithinTheFrictionConeOfTheReportedNormal) {
  std::size_t within = 0, count = 0;
  for (const ObjectStep& step : recorded_grasp().steps) {
    for (const ObjectContact& contact : step.contacts) {
      const double force = contact.wrench.tail<3>().norm();
      if (force < 0.01) continue;
      within += grasping::is_within_cone(contact.model, contact.friction,
                                         grasping::transmission(contact.model) * contact.wrench,
                                         1e-6 * force);
      ++count;
    }
  }
  ASSERT_GT(count, 1000u);
  EXPECT_GE(static_cast<double>(within), 0.99 * static_cast<double>(count));
}

TEST(ObjectStep, TipContactsAreThoseOfTheTrueSurface) {
  const geometry::MeshQuery mesh(recorded_grasp().object.mesh);
  std::size_t count = 0;
  for (const ObjectStep& step : recorded_grasp().steps) {
    for (const ObjectContact& contact : step.contacts) {
      if (contact.finger < 0) continue;
      const Eigen::Vector3d out = -contact.T_world_contact.linear().col(0);
      const Eigen::Vector3d point =
          contact.T_world_contact.translation() - 0.5 * contact.distance * out;
      const Eigen::Vector3d p = step.T_world_object.inverse() * point;
      EXPECT_LT(mesh.closest_point(p).distance, 2e-5);
      ++count;
    }
  }
  EXPECT_GT(count, 1000u);
}

TEST(ObjectStep, TipsAreWhereTheHandsModelHasThem) {
  const ObjectStep& step = held_step();
  const hand::Description& hand = recorded_grasp().world.hand_model();
  const auto T_mount_link = hand::forward_kinematics(hand, step.joints);
  for (const ObjectContact& contact : step.contacts) {
    if (contact.finger < 0) continue;
    const auto& tip = hand.fingers[static_cast<std::size_t>(contact.finger)].tip;
    const auto link =
        static_cast<std::size_t>(hand.fingers[static_cast<std::size_t>(contact.finger)].link);
    const Eigen::Isometry3d T = step.T_world_mount * T_mount_link[link];
    EXPECT_EQ(contact.link, static_cast<int>(link));
    EXPECT_LT((T * tip.a - contact.capsule.a).norm(), 1e-9);
    EXPECT_LT((T * tip.b - contact.capsule.b).norm(), 1e-9);
  }
}

TEST(ObjectStep, GraspMatrixBalancesTheHeldObject) {
  const ObjectStep& step = held_step();
  const grasping::GraspContacts contacts = grasp_contacts(step);
  const Eigen::Vector3d center = step.T_world_object.translation();
  const Vector6d wrench =
      grasping::object_wrench(grasping::grasp_matrix(contacts, center), contact_wrenches(step));
  const Eigen::Vector3d force = step.momentum_change / kTimeStep - step.gravity;
  EXPECT_LT((wrench.tail<3>() - force).norm(), 0.02 * step.gravity.norm());
  EXPECT_LT(wrench.head<3>().norm(), 0.05 * step.gravity.norm() * 0.05);  // at rest: no moment
}

TEST(ObjectStep, TheHeldObjectIsInForceClosureAndItsWeightCanBeBalanced) {
  const ObjectStep& step = held_step();
  const grasping::GraspContacts contacts = grasp_contacts(step);
  const Eigen::Vector3d center = step.T_world_object.translation();
  EXPECT_TRUE(grasping::force_closure(contacts).closed);
  Vector6d weight = Vector6d::Zero();
  weight.tail<3>() = -step.gravity;
  const grasping::Balance balance = grasping::balance_wrench(contacts, center, weight);
  ASSERT_EQ(balance.status, grasping::BalanceStatus::balanced);
  // The solver's forces also balance it, and none that do are smaller than the least.
  const Eigen::VectorXd solver = contact_wrenches(step);
  const auto cost = [&](const Eigen::VectorXd& w) {
    double sum = 0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      const auto& contact = contacts[i];
      Eigen::VectorXd u =
          grasping::transmission(contact.model) * w.segment<6>(static_cast<Eigen::Index>(6 * i));
      if (contact.model == grasping::ContactModel::soft_finger)
        u[3] /= contact.friction.eccentricity;
      u[0] *= contact.friction.sliding;
      sum += u.squaredNorm();
    }
    return sum;
  };
  EXPECT_LE(cost(balance.contact_wrenches), 1.05 * cost(solver));
}

/// The simulator's own Jacobian of the maker's hand, its palm where the mount's model has it.
Eigen::MatrixXd simulators_jacobian(const hand::Description& hand, const hand::JointVector& joints,
                                    const grasping::GraspContacts& contacts) {
  const std::unique_ptr<mjModel, void (*)(mjModel*)> model(
      mj_loadXML(asset("shadow_hand/right_hand.xml").c_str(), nullptr, nullptr, 0), mj_deleteModel);
  const std::unique_ptr<mjData, void (*)(mjData*)> data(mj_makeData(model.get()), mj_deleteData);
  std::array<int, hand::kShadowJoints> dofs{};
  for (std::size_t i = 0; i < dofs.size(); ++i) {
    const int id = mj_name2id(model.get(), mjOBJ_JOINT,
                              ("rh_" + std::string(hand::kShadowJointNames[i])).c_str());
    data->qpos[model->jnt_qposadr[id]] = joints[static_cast<int>(i)];
    dofs[i] = model->jnt_dofadr[id];
  }
  mj_kinematics(model.get(), data.get());
  mj_comPos(model.get(), data.get());
  const auto T_mount_link = hand::forward_kinematics(hand, joints);
  Eigen::MatrixXd J(6 * static_cast<Eigen::Index>(contacts.size()), hand::kShadowJoints);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const int body = contacts[i].link + 1;
    const Eigen::Isometry3d& T_mount = T_mount_link[static_cast<std::size_t>(contacts[i].link)];
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R_own_link(data->xmat + 9 * body);
    const Eigen::Vector3d p_link = T_mount.inverse() * contacts[i].T_mount_contact.translation();
    const Eigen::Vector3d p_own = R_own_link * p_link + Eigen::Vector3d(data->xpos + 3 * body);
    std::vector<double> jacp(3 * static_cast<std::size_t>(model->nv)), jacr(jacp.size());
    mj_jac(model.get(), data.get(), jacp.data(), jacr.data(), p_own.data(), body);
    const Eigen::Matrix3d R_contact_own = contacts[i].T_mount_contact.linear().transpose() *
                                          T_mount.linear() * R_own_link.transpose();
    for (std::size_t k = 0; k < dofs.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      const auto row = static_cast<Eigen::Index>(6 * i);
      const auto read = [&](const std::vector<double>& values) {
        const auto nv = static_cast<std::size_t>(model->nv);
        const auto dof = static_cast<std::size_t>(dofs[k]);
        return Eigen::Vector3d(values[dof], values[nv + dof], values[2 * nv + dof]);
      };
      J.block<3, 1>(row, column) = R_contact_own * read(jacr);
      J.block<3, 1>(row + 3, column) = R_contact_own * read(jacp);
    }
  }
  return J;
}

TEST(ObjectStep, HandJacobianIsTheSimulatorsInTheGrasp) {
  const ObjectStep& step = held_step();
  const World& world = recorded_grasp().world;
  const hand::JointVector& joints = step.joints;
  grasping::GraspContacts contacts = grasp_contacts(step);
  for (auto& contact : contacts) {
    contact.T_mount_contact = step.T_world_mount.inverse() * contact.T_mount_contact;
  }
  const Eigen::MatrixXd J = grasping::hand_jacobian(world.hand_model(), joints, contacts);
  const Eigen::MatrixXd expected = simulators_jacobian(world.hand_model(), joints, contacts);
  EXPECT_GT(J.norm(), 1);
  EXPECT_LT((J - expected).cwiseAbs().maxCoeff(), 1e-9);
  const Eigen::VectorXd w = contact_wrenches(step);
  EXPECT_LT((grasping::joint_torques(J, w) - expected.transpose() * w).norm(), 1e-9);
}

TEST(ObjectStep, ObservingChangesNothingAndEnds) {
  World watched(block(), {}, 5), alone(block(), {}, 5);
  int seen = 0;
  watched.observe([&](const ObjectStep&) { ++seen; });
  const hand::HandReading a = press_block(watched);
  const hand::HandReading b = press_block(alone);
  EXPECT_EQ(a.joints, b.joints);
  EXPECT_EQ(seen, 100 * 5);
  watched.observe({});
  watched.hand().step(open_hand(0.3));
  EXPECT_EQ(seen, 100 * 5);
}

TEST(ObjectStep, ConvexTipsMeetTheParts) {
  WorldOptions options = without_noise();
  options.exact_tips = false;
  World world(trough(), options, 1);
  const hand::HandReading reading = press_block(world, 200, 0.04);
  int touching = 0;
  for (const auto& contacts : reading.contacts) touching += contacts.empty() ? 0 : 1;
  EXPECT_GE(touching, 1);
}

}  // namespace
}  // namespace palpate::simulation
