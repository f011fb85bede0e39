// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/thinning.hpp"

#include <gtest/gtest.h>

#include "palpate/core/random.hpp"

namespace palpate::localization {
namespace {

tactile::Contact contact_at(double x, double y, double z) {
  tactile::Contact contact;
  contact.p = {x, y, z};
  contact.n = {0, 0, 1};
  return contact;
}

Evidence evidence_of(std::vector<tactile::Contact> contacts) {
  Evidence evidence;
  evidence.contacts = std::move(contacts);
  return evidence;
}

std::size_t count(Evidence evidence) { return thinned(std::move(evidence)).contacts.size(); }

TEST(Thinned, SamplesOfARestingTouchCountOnce) {
  RandomStream random(1);
  Evidence evidence;
  for (int touch = 0; touch < 3; ++touch) {
    for (int row = 0; row < 100; ++row) {
      tactile::Contact contact = contact_at(0.02 * touch, 0, 0);
      contact.p += 1e-4 * random.normal3();
      contact.n = (contact.n + 0.02 * random.normal3()).normalized();
      evidence.contacts.push_back(contact);
    }
  }
  const Evidence kept = thinned(evidence);
  ASSERT_EQ(kept.contacts.size(), 3);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(kept.contacts[i].p, evidence.contacts[100 * i].p);
}

TEST(Thinned, ASlideIsATouchEveryTwoPointSigmas) {
  Evidence evidence;
  for (int row = 0; row < 200; ++row) evidence.contacts.push_back(contact_at(1e-4 * row, 0, 0));
  EXPECT_NEAR(static_cast<double>(count(evidence)), 10, 1);
}

TEST(Thinned, RepeatsAreNearerThanTwoPointSigmasAndThreeMillimetres) {
  tactile::Contact exact = contact_at(0, 0, 0);
  exact.point_sigma = 1e-4;
  tactile::Contact coarse = contact_at(0, 0, 0);
  coarse.point_sigma = 0.02;
  EXPECT_EQ(count(evidence_of({exact, contact_at(1.9e-4, 0, 0)})), 1);
  EXPECT_EQ(count(evidence_of({exact, contact_at(2.1e-4, 0, 0)})), 2);
  EXPECT_EQ(count(evidence_of({coarse, contact_at(2.9e-3, 0, 0)})), 1);
  EXPECT_EQ(count(evidence_of({coarse, contact_at(3.1e-3, 0, 0)})), 2);
}

TEST(Thinned, ContactsThatDifferAreKept) {
  const tactile::Contact first = contact_at(0, 0, 0);
  tactile::Contact turned = contact_at(1e-4, 0, 0);
  turned.n = Eigen::Vector3d(1, 0, 1).normalized();
  EXPECT_EQ(count(evidence_of({first, turned})), 2);

  tactile::Contact without_normal = contact_at(1e-4, 0, 0);
  without_normal.n.setZero();
  EXPECT_EQ(count(evidence_of({first, without_normal})), 2);

  tactile::Contact index = contact_at(0, 0, 0), thumb = contact_at(1e-4, 0, 0);
  index.finger = 1;
  thumb.finger = 0;
  EXPECT_EQ(count(evidence_of({index, thumb})), 2);

  tactile::Contact candidate = contact_at(0, 0, 0);
  candidate.group = 3;
  EXPECT_EQ(count(evidence_of({candidate, candidate})), 2);
}

TEST(Thinned, OfContactsWithAnOffsetOnlyCopiesCountOnce) {
  Evidence evidence =
      evidence_of({contact_at(0, 0, 0), contact_at(1e-4, 0, 0), contact_at(0, 0, 0)});
  evidence.offsets.resize(2);
  evidence.offsets[0].members = {{0}, {2}};
  evidence.offsets[1].members = {{1}};
  const Evidence kept = thinned(evidence);
  ASSERT_EQ(kept.contacts.size(), 2);
  ASSERT_EQ(kept.offsets[0].members.size(), 1);
  EXPECT_EQ(kept.offsets[0].members[0].contact, 0);
  ASSERT_EQ(kept.offsets[1].members.size(), 1);
  EXPECT_EQ(kept.offsets[1].members[0].contact, 1);
}

TEST(Thinned, AtMost64ContactsAreKeptInTheirOrder) {
  Evidence evidence;
  for (int row = 0; row < 200; ++row) evidence.contacts.push_back(contact_at(0.01 * row, 0, 0));
  const Evidence kept = thinned(evidence);
  ASSERT_EQ(kept.contacts.size(), 64);
  for (std::size_t i = 1; i < 64; ++i) {
    EXPECT_GT(kept.contacts[i].p.x(), kept.contacts[i - 1].p.x());
  }
}

}  // namespace
}  // namespace palpate::localization
