// SPDX-License-Identifier: Apache-2.0
#include "palpate/grasping/grasp_matrix.hpp"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate::grasping {
namespace {

void require_size(const char* what, Eigen::Index size, Eigen::Index expected) {
  if (size != expected) {
    throw BadInput(fmt::format("{} needs {} values, not {}", what, expected, size));
  }
}

void require_finite(const GraspContacts& contacts, const Eigen::Vector3d& p_mount_object) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    if (contacts[i].T_mount_contact.matrix().allFinite()) continue;
    const Eigen::Vector3d p = contacts[i].T_mount_contact.translation();
    throw BadInput(fmt::format("the frame of contact {} at ({}, {}, {}) m is not finite", i, p.x(),
                               p.y(), p.z()));
  }
  if (p_mount_object.allFinite()) return;
  throw BadInput(fmt::format("wrenches are taken at a finite point, not ({}, {}, {}) m",
                             p_mount_object.x(), p_mount_object.y(), p_mount_object.z()));
}

}  // namespace

Eigen::Isometry3d contact_frame(const Eigen::Vector3d& p_mount, const Eigen::Vector3d& n_mount) {
  if (!p_mount.allFinite() || !(std::abs(n_mount.norm() - 1) < 1e-3)) {
    throw BadInput(
        fmt::format("a contact needs a finite point and a unit normal, not ({}, {}, {}) m and "
                    "({}, {}, {}) of length {}",
                    p_mount.x(), p_mount.y(), p_mount.z(), n_mount.x(), n_mount.y(), n_mount.z(),
                    n_mount.norm()));
  }
  const Eigen::Matrix3d axes = frame_with_z(-n_mount.normalized());
  Eigen::Isometry3d T_mount_contact = Eigen::Isometry3d::Identity();
  T_mount_contact.linear() << axes.col(2), axes.col(0), axes.col(1);
  T_mount_contact.translation() = p_mount;
  return T_mount_contact;
}

GraspContacts grasp_contacts(const hand::Description& hand, const hand::HandReading& reading,
                             ContactModel model, const Friction& friction) {
  const auto T_mount_link = hand::forward_kinematics(hand, reading.joints);
  GraspContacts contacts;
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    const int link = hand.fingers[finger].link;
    const Eigen::Isometry3d& T = T_mount_link.at(static_cast<std::size_t>(link));
    for (const hand::TipContact& touch : reading.contacts[finger]) {
      contacts.push_back({contact_frame(T * touch.p, T.linear() * touch.n), link, model, friction});
    }
  }
  return contacts;
}

Eigen::MatrixXd grasp_matrix(const GraspContacts& contacts, const Eigen::Vector3d& p_mount_object) {
  require_finite(contacts, p_mount_object);
  Eigen::MatrixXd G(6, 6 * static_cast<Eigen::Index>(contacts.size()));
  Eigen::Index column = 0;
  for (const GraspContact& contact : contacts) {
    const Eigen::Matrix3d R = contact.T_mount_contact.linear();
    const Eigen::Vector3d arm = contact.T_mount_contact.translation() - p_mount_object;
    G.middleCols<6>(column) << R, skew(arm) * R, Eigen::Matrix3d::Zero(), R;
    column += 6;
  }
  return G;
}

Eigen::MatrixXd hand_jacobian(const hand::Description& hand, const hand::JointVector& joints,
                              const GraspContacts& contacts) {
  const auto T_mount_link = hand::forward_kinematics(hand, joints);
  Eigen::MatrixXd J(6 * static_cast<Eigen::Index>(contacts.size()), hand.joint_count());
  Eigen::Index row = 0;
  for (const GraspContact& contact : contacts) {
    if (contact.link < 0 || contact.link >= static_cast<int>(hand.links.size())) {
      throw BadInput(fmt::format("a contact names link {} of a hand with {} links", contact.link,
                                 hand.links.size()));
    }
    const Eigen::Isometry3d& T = T_mount_link[static_cast<std::size_t>(contact.link)];
    const Eigen::Vector3d p_link = T.inverse() * contact.T_mount_contact.translation();
    const auto J_mount = hand::jacobian(hand, joints, contact.link, p_link);
    const Eigen::Matrix3d R_contact_mount = contact.T_mount_contact.linear().transpose();
    J.middleRows<3>(row) = R_contact_mount * J_mount.topRows<3>();
    J.middleRows<3>(row + 3) = R_contact_mount * J_mount.bottomRows<3>();
    row += 6;
  }
  return J;
}

Eigen::MatrixXd transmission(const GraspContacts& contacts) {
  Eigen::Index rows = 0;
  for (const GraspContact& contact : contacts) rows += components(contact.model);
  const auto columns = 6 * static_cast<Eigen::Index>(contacts.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(rows, columns);
  Eigen::Index row = 0, column = 0;
  for (const GraspContact& contact : contacts) {
    const Eigen::MatrixXd own = transmission(contact.model);
    H.block(row, column, own.rows(), 6) = own;
    row += own.rows();
    column += 6;
  }
  return H;
}

Vector6d object_wrench(const Eigen::MatrixXd& G, const Eigen::VectorXd& contact_wrenches) {
  require_size("the wrench of the contacts", contact_wrenches.size(), G.cols());
  return G * contact_wrenches;
}

Eigen::VectorXd object_contact_twists(const Eigen::MatrixXd& G, const Vector6d& twist) {
  require_size("a grasp matrix's column", G.rows(), 6);
  return G.transpose() * twist;
}

Eigen::VectorXd hand_contact_twists(const Eigen::MatrixXd& J, const hand::JointVector& velocities) {
  require_size("a hand Jacobian's row", J.cols(), velocities.size());
  return J * velocities;
}

hand::JointVector joint_torques(const Eigen::MatrixXd& J, const Eigen::VectorXd& contact_wrenches) {
  require_size("the wrench of the contacts", contact_wrenches.size(), J.rows());
  return J.transpose() * contact_wrenches;
}

}  // namespace palpate::grasping
