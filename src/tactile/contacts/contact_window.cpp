// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/contacts/contact_window.hpp"

#include <algorithm>
#include <cmath>

#include "palpate/tactile/contacts/reported_error.hpp"

namespace palpate::tactile {
namespace {

constexpr double kSamePlace = 0.005;    // m
constexpr double kSameDirection = 0.5;  // cosine
constexpr double kLastingShare = 1.0 / 3;

/// Contacts of one tip that belong together, summed; those of smaller error count more.
struct Cluster {
  int count = 0;
  double weight = 0;
  double point_variance = 0, normal_variance = 0;  // as the sensor itself reports
  Eigen::Vector3d p = Eigen::Vector3d::Zero();
  Eigen::Vector3d n = Eigen::Vector3d::Zero();
  Eigen::Vector3d f = Eigen::Vector3d::Zero();

  bool takes(const hand::TipContact& contact) const {
    if ((p / weight - contact.p).norm() >= kSamePlace) return false;
    if (n.isZero(0) || contact.n.isZero(0)) return n.isZero(0) && contact.n.isZero(0);
    return n.normalized().dot(contact.n) > kSameDirection;
  }
  void add(const hand::TipContact& contact) {
    const double sigma = contact.normal_sigma;
    const double share = sigma > 0 ? 1 / (sigma * sigma) : 1;
    ++count;
    weight += share;
    point_variance += share * contact.point_sigma * contact.point_sigma;
    normal_variance += share * sigma * sigma;
    p += share * contact.p;
    n += share * contact.n;
    f += share * contact.f;
  }
};

bool sound(const hand::TipContact& contact) {
  return contact.p.allFinite() && contact.n.allFinite() && contact.f.allFinite() &&
         (contact.n.isZero(0) || contact.n.norm() > 0.5) && has_valid_errors(contact);
}

std::vector<Cluster> cluster_tip(std::span<const hand::HandReading> window, std::size_t finger) {
  std::vector<Cluster> clusters;
  for (const auto& reading : window) {
    for (const auto& contact : reading.contacts[finger]) {
      if (!sound(contact)) continue;
      const auto home = std::find_if(clusters.begin(), clusters.end(),
                                     [&](const Cluster& c) { return c.takes(contact); });
      (home == clusters.end() ? clusters.emplace_back() : *home).add(contact);
    }
  }
  return clusters;
}

/// Of the mean contact. Averaging takes away noise, but not what a sensor reports of its error:
/// that changes little while a contact lasts.
double point_variance(const Cluster& cluster, const ContactErrorModel& errors) {
  if (cluster.normal_variance > 0) return cluster.point_variance / cluster.weight;
  return errors.point * errors.point / cluster.count;
}

double normal_sigma(const Cluster& cluster, const ContactErrorModel& errors) {
  if (cluster.normal_variance > 0) return std::sqrt(cluster.normal_variance / cluster.weight);
  return errors.normal / std::sqrt(cluster.count);
}

/// Variance per axis of a point fixed to the link, from joint noise and misplaced links.
double kinematic_variance(const hand::Description& hand, const hand::JointVector& joints, int link,
                          const Eigen::Vector3d& p_link, const ContactErrorModel& errors,
                          std::size_t readings) {
  const auto J = hand::jacobian(hand, joints, link, p_link);
  const double joint_variance = errors.joint * errors.joint / static_cast<double>(readings);
  const double misplaced = static_cast<double>(hand::misplaced_links(hand, link).size());
  return (J.bottomRows<3>().squaredNorm() * joint_variance +
          misplaced * hand.kinematic_error * hand.kinematic_error) /
         3.0;
}

}  // namespace

hand::TipContact tip_contact(const Contact& contact) {
  return {contact.p, contact.n, contact.f, contact.point_sigma, contact.normal_sigma};
}

hand::JointVector mean_joints(std::span<const hand::HandReading> window) {
  hand::JointVector sum = hand::JointVector::Zero(window.front().joints.size());
  for (const auto& reading : window) sum += reading.joints;
  return sum / static_cast<double>(window.size());
}

double link_offset_sigma(const hand::Description& hand, int finger) {
  const int tip = hand.fingers.at(static_cast<std::size_t>(finger)).link;
  const double misplaced = static_cast<double>(hand::misplaced_links(hand, tip).size());
  return hand.kinematic_error * std::sqrt(misplaced / 3.0);
}

std::vector<Contact> lasting_contacts(std::span<const hand::HandReading> window,
                                      const hand::Description& hand,
                                      const ContactErrorModel& errors) {
  std::vector<Contact> contacts;
  if (window.empty()) return contacts;
  const hand::JointVector joints = mean_joints(window);
  const auto T_mount_link = hand::forward_kinematics(hand, joints);
  const double least = std::max(1.0, kLastingShare * static_cast<double>(window.size()));
  for (std::size_t finger = 0; finger < hand.fingers.size(); ++finger) {
    const int link = hand.fingers[finger].link;
    const auto& T = T_mount_link.at(static_cast<std::size_t>(link));
    for (const Cluster& cluster : cluster_tip(window, finger)) {
      if (cluster.count < least) continue;
      const Eigen::Vector3d p_link = cluster.p / cluster.weight;
      Contact contact;
      contact.finger = static_cast<int>(finger);
      contact.time = window.back().time;
      contact.p = T * p_link;
      contact.n = T.linear() * cluster.n.normalized();
      contact.f = T.linear() * cluster.f / cluster.weight;
      contact.point_sigma =
          std::sqrt(point_variance(cluster, errors) + errors.point_floor * errors.point_floor +
                    kinematic_variance(hand, joints, link, p_link, errors, window.size()));
      contact.normal_sigma = std::hypot(normal_sigma(cluster, errors), errors.normal_floor);
      contacts.push_back(contact);
    }
  }
  return contacts;
}

std::vector<Contact> contacts_with_normals(std::vector<Contact> contacts) {
  std::erase_if(contacts, [](const Contact& contact) { return !contact.has_normal(); });
  return contacts;
}

}  // namespace palpate::tactile
