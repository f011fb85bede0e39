// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/force_distribution.hpp"

#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>

#include "palpate/core/error.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::grasping {
namespace {

constexpr int kEdges = 4;           // of a linearised friction cone
constexpr double kLeverArm = 0.03;  // m: a moment of 1 N times this counts like a force of 1 N
constexpr double kEvenness = 0.02;  // weight of an even share against balance
constexpr int kIterations = 400;

/// Nearest point with non-negative coordinates that sum to 1 (Duchi et al., ICML 2008).
Eigen::VectorXd onto_simplex(const Eigen::VectorXd& x) {
  std::vector<double> sorted(x.data(), x.data() + x.size());
  std::sort(sorted.begin(), sorted.end(), std::greater<>());
  double sum = 0, shift = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    sum += sorted[i];
    const double candidate = (sum - 1) / static_cast<double>(i + 1);
    if (sorted[i] > candidate) shift = candidate;
  }
  return (x.array() - shift).max(0.0).matrix();
}

/// Edges of the friction cones, as forces of the fingers on the object that press with 1.
Eigen::Matrix3Xd cone_edges(std::span<const tactile::Contact> contacts, double friction) {
  Eigen::Matrix3Xd edges(3, static_cast<Eigen::Index>(kEdges * contacts.size()));
  Eigen::Index column = 0;
  for (const auto& contact : contacts) {
    const Eigen::Vector3d t = contact.n.unitOrthogonal();
    const Eigen::Vector3d b = contact.n.cross(t);
    for (const Eigen::Vector3d& side : {t, b, Eigen::Vector3d(-t), Eigen::Vector3d(-b)}) {
      edges.col(column++) = -contact.n + friction * side;
    }
  }
  return edges;
}

Eigen::Vector3d middle_of(std::span<const tactile::Contact> contacts) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& contact : contacts) sum += contact.p;
  return sum / static_cast<double>(contacts.size());
}

Vector6d wrench(const Eigen::Vector3d& arm, const Eigen::Vector3d& force) {
  Vector6d result;
  result << force, arm.cross(force) / kLeverArm;
  return result;
}

Eigen::MatrixXd wrenches(std::span<const tactile::Contact> contacts, const Eigen::Matrix3Xd& edges,
                         const Eigen::Vector3d& center) {
  Eigen::MatrixXd W(6, edges.cols());
  for (Eigen::Index i = 0; i < edges.cols(); ++i) {
    W.col(i) = wrench(contacts[static_cast<std::size_t>(i / kEdges)].p - center, edges.col(i));
  }
  return W;
}

}  // namespace

ForceDistribution distribute_forces(std::span<const tactile::Contact> contacts, double friction,
                                    double total, const std::optional<Load>& load) {
  ForceDistribution result;
  if (contacts.empty()) {
    result.wrench_residual = std::numeric_limits<double>::infinity();
    return result;
  }
  const Eigen::Matrix3Xd edges = cone_edges(contacts, friction);
  const Eigen::Vector3d center = middle_of(contacts);
  const Eigen::MatrixXd W = wrenches(contacts, edges, center);
  const Vector6d borne =
      load ? Vector6d(wrench(load->point - center, load->force / total)) : Vector6d::Zero();
  const Eigen::Index count = edges.cols();
  const Eigen::MatrixXd H = W.transpose() * W + kEvenness * Eigen::MatrixXd::Identity(count, count);
  const double step = 1 / H.trace();
  Eigen::VectorXd share = Eigen::VectorXd::Constant(count, 1.0 / static_cast<double>(count));
  Eigen::VectorXd ahead = share;
  for (int i = 0; i < kIterations; ++i) {  // projected gradient with momentum
    const Eigen::VectorXd next = onto_simplex(ahead - step * (H * ahead + W.transpose() * borne));
    ahead = next + i / (i + 3.0) * (next - share);
    share = next;
  }
  result.wrench_residual = (W * share + borne).norm();
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const auto first = static_cast<Eigen::Index>(k) * kEdges;
    result.forces.push_back(total * edges.middleCols<kEdges>(first) * share.segment<kEdges>(first));
  }
  return result;
}

/// Of the actuators, by virtual work; the tendon of a coupled pair pulls both joints alike.
hand::ActuatorVector drive_torques(const hand::Description& hand,
                                   const hand::JointVector& torques) {
  hand::ActuatorVector result = hand::ActuatorVector::Zero(hand.actuator_count());
  for (int i = 0; i < hand.actuator_count(); ++i) {
    const hand::Actuator& actuator = hand.actuators[static_cast<std::size_t>(i)];
    for (const hand::DrivenJoint& driven : actuator.joints) {
      result[i] += driven.share * torques[driven.joint];
    }
    if (actuator.coupling) result[i] /= 2;
  }
  return result;
}

hand::ActuatorVector pressing_torques(const hand::Description& hand,
                                      const hand::JointVector& joints,
                                      std::span<const tactile::Contact> contacts,
                                      std::span<const Eigen::Vector3d> forces) {
  if (contacts.size() != forces.size()) throw BadInput("as many forces as contacts are needed");
  const auto T_mount_link = hand::forward_kinematics(hand, joints);
  hand::JointVector torques = hand::JointVector::Zero(hand.joint_count());
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    const int link = hand.fingers[static_cast<std::size_t>(contacts[k].finger)].link;
    const Eigen::Vector3d p_link =
        T_mount_link[static_cast<std::size_t>(link)].inverse() * contacts[k].p;
    const hand::Jacobian J = hand::jacobian(hand, joints, link, p_link);
    torques += J.bottomRows<3>().transpose().lazyProduct(forces[k]);
  }
  return drive_torques(hand, torques);
}

}  // namespace palpate::grasping
