// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/contacts/contact_window.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "hand/descriptions.hpp"
#include "palpate/core/random.hpp"
#include "palpate/hand/shadow.hpp"
#include "palpate/tactile/contacts/contact.hpp"
#include "palpate/tactile/contacts/reported_error.hpp"

namespace palpate::tactile {
namespace {

/// A palm with one hinged fingertip a finger, 0.1 m out.
hand::Description toy_hand() {
  hand::Description hand = hand::shadow_hand();
  hand.links.resize(6);
  hand.palm = 0;
  for (int finger = 0; finger < hand::kShadowFingers; ++finger) {
    auto& link = hand.links[static_cast<std::size_t>(finger + 1)];
    link.parent = 0;
    link.joint = finger;
    link.axis = Eigen::Vector3d::UnitZ();
    link.T_parent_link.translation() = Eigen::Vector3d(0.1, 0.02 * finger, 0);
    hand.fingers[static_cast<std::size_t>(finger)].link = finger + 1;
  }
  return hand;
}

std::vector<hand::HandReading> held(int readings, double noise, std::uint64_t seed) {
  RandomStream random(seed, "held");
  std::vector<hand::HandReading> window(static_cast<std::size_t>(readings),
                                        hand::resting_reading());
  for (auto& reading : window) {
    hand::TipContact contact;
    contact.p = Eigen::Vector3d(0.02, 0.005, 0) + noise * random.normal3();
    contact.n = (Eigen::Vector3d(0, 1, 0) + 100 * noise * random.normal3()).normalized();
    contact.f = Eigen::Vector3d(0, -2, 0);
    reading.contacts[1] = {contact};
  }
  return window;
}

TEST(LastingContacts, AverageInTheMountFrame) {
  const auto contacts = lasting_contacts(held(100, 0.001, 1), toy_hand(), {});
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].finger, 1);
  EXPECT_LT((contacts[0].p - Eigen::Vector3d(0.12, 0.025, 0)).norm(), 0.0005);
  EXPECT_GT(contacts[0].n.y(), std::cos(0.05));
  EXPECT_TRUE(contacts[0].f.isApprox(Eigen::Vector3d(0, -2, 0), 1e-9));
}

TEST(LastingContacts, UncertaintyIsThatOfTheErrorModel) {
  const ContactErrorModel errors{.joint = 0, .point_floor = 1e-5, .normal_floor = 1e-4};
  hand::Description hand = toy_hand();
  hand.kinematic_error = 0.003;
  const auto contacts = lasting_contacts(held(25, 0, 1), hand, errors);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].point_sigma, std::sqrt(1e-6 / 25 + 1e-10 + 9e-6 / 3), 1e-9);
  EXPECT_NEAR(contacts[0].normal_sigma, errors.normal / 5, 1e-6);
}

TEST(LastingContacts, WhatTheSensorReportsOfItsErrorTakesThePlaceOfTheModels) {
  auto window = held(25, 0, 1);
  for (auto& reading : window) {
    reading.contacts[1][0].point_sigma = 0.002;
    reading.contacts[1][0].normal_sigma = 0.3;
  }
  const ContactErrorModel errors{.joint = 0, .point_floor = 1e-3, .normal_floor = 0.4};
  const auto contacts = lasting_contacts(window, toy_hand(), errors);
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_NEAR(contacts[0].point_sigma, std::hypot(0.002, 1e-3), 1e-9);
  EXPECT_NEAR(contacts[0].normal_sigma, 0.5, 1e-9);  // averaging takes nothing away
}

TEST(LastingContacts, ReadingsOfSmallerErrorCountMore) {
  auto window = held(20, 0, 1);
  const Eigen::Vector3d sure = window[0].contacts[1][0].n;
  const Eigen::Vector3d doubtful = (sure + Eigen::Vector3d(0.5, 0, 0)).normalized();
  for (std::size_t i = 0; i < window.size(); ++i) {
    auto& contact = window[i].contacts[1][0];
    contact.normal_sigma = i % 2 ? 0.05 : 0.5;
    if (i % 2 == 0) contact.n = doubtful;
  }
  const ContactErrorModel errors{.normal_floor = 1e-4};
  const auto contacts = lasting_contacts(window, toy_hand(), errors);
  ASSERT_EQ(contacts.size(), 1u);
  // Weights are 100 to 1.
  EXPECT_GT(contacts[0].n.dot(sure), std::cos(0.01));
  EXPECT_NEAR(contacts[0].normal_sigma, std::sqrt(20 / (10 / 0.0025 + 10 / 0.25)), 1e-6);
}

TEST(LastingContacts, TwoPlacesOnOneTipStayApart) {
  auto window = held(30, 0, 1);
  for (auto& reading : window) {
    hand::TipContact other = reading.contacts[1][0];
    other.n = Eigen::Vector3d(1, 0, 0);
    reading.contacts[1].push_back(other);
  }
  EXPECT_EQ(lasting_contacts(window, toy_hand(), {}).size(), 2u);
}

TEST(LastingContacts, ThoseWithoutANormalAreKeptApartFromThoseWithOne) {
  auto window = held(30, 0, 1);
  for (auto& reading : window) {
    auto bare = reading.contacts[1][0];
    bare.n.setZero();
    reading.contacts[1].push_back(bare);
    bare.n = Eigen::Vector3d(0, 0.4, 0);  // no unit vector: the sensor is broken
    reading.contacts[4] = {bare};
  }
  const auto contacts = lasting_contacts(window, toy_hand(), {});
  ASSERT_EQ(contacts.size(), 2u);
  EXPECT_TRUE(contacts[0].has_normal());
  EXPECT_FALSE(contacts[1].has_normal());
  EXPECT_EQ(contacts[1].p, contacts[0].p);
  EXPECT_EQ(contacts[1].point_sigma, contacts[0].point_sigma);
  const auto kept = contacts_with_normals(contacts);
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_TRUE(kept[0].has_normal());
}

TEST(LastingContacts, PassingAndBrokenContactsAreDropped) {
  auto window = held(30, 0, 1);
  window[3].contacts[2] = window[3].contacts[1];
  for (auto& reading : window) {
    auto broken = reading.contacts[1][0];
    broken.p.x() = std::numeric_limits<double>::quiet_NaN();
    reading.contacts[4] = {broken};
  }
  const auto contacts = lasting_contacts(window, toy_hand(), {});
  ASSERT_EQ(contacts.size(), 1u);
  EXPECT_EQ(contacts[0].finger, 1);
}

TEST(LastingContacts, ContactsWhoseErrorsCannotBeAreDropped) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, infinity, -0.1}) {
    EXPECT_FALSE(is_standard_deviation(bad));
    for (const auto sigma : {&hand::TipContact::point_sigma, &hand::TipContact::normal_sigma}) {
      auto window = held(30, 0, 1);
      for (auto& reading : window) {
        auto broken = reading.contacts[1][0];
        broken.normal_sigma = broken.point_sigma = 0.1;
        EXPECT_TRUE(has_valid_errors(broken));
        broken.*sigma = bad;
        reading.contacts[4] = {broken};
      }
      const auto contacts = lasting_contacts(window, toy_hand(), {});
      ASSERT_EQ(contacts.size(), 1u) << bad;
      EXPECT_EQ(contacts[0].finger, 1);
    }
  }
}

TEST(TipContact, IsTheContactWithItsErrors) {
  Contact contact;
  contact.p = {1, 2, 3};
  contact.n = Eigen::Vector3d::UnitX();
  contact.f = {-2, 0, 1};
  contact.point_sigma = 0.002;
  contact.normal_sigma = 0.3;
  const hand::TipContact tip = tip_contact(contact);
  EXPECT_EQ(tip.p, contact.p);
  EXPECT_EQ(tip.n, contact.n);
  EXPECT_EQ(tip.f, contact.f);
  EXPECT_EQ(tip.point_sigma, 0.002);
  EXPECT_EQ(tip.normal_sigma, 0.3);
}

TEST(LastingContacts, NoReadingsNoContacts) {
  EXPECT_TRUE(lasting_contacts({}, toy_hand(), {}).empty());
}

}  // namespace
}  // namespace palpate::tactile
