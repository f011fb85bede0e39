// SPDX-License-Identifier: Apache-2.0
#include "skills/safety/flicker_filter.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "palpate/core/random.hpp"

namespace palpate::skills {
namespace {

using Contacts = std::vector<hand::TipContact>;

constexpr int kFinger = 2;

hand::TipContact flash_at(double x) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  return {Eigen::Vector3d(x, 0, 0.02), up, -up};
}

/// @return how many of the readings of a fingertip were left with a contact
int count_passed(FlickerFilter& filter, int readings,
                 const std::function<Contacts(int reading)>& contacts_at) {
  int passed = 0;
  for (int i = 0; i < readings; ++i) {
    Contacts contacts = contacts_at(i);
    filter.filter(kFinger, contacts);
    passed += !contacts.empty();
  }
  return passed;
}

/// A tenth of the readings, at the same point.
std::function<Contacts(int)> flashes(std::uint64_t seed) {
  return [random = RandomStream(seed, "flashes")](int) mutable {
    return random.uniform() < 0.1 ? Contacts{flash_at(0)} : Contacts{};
  };
}

TEST(FlickerFilter, DelaysNoTouchOfAGoodSensor) {
  FlickerFilter filter;
  for (int touch = 0; touch < 20; ++touch) {
    count_passed(filter, 100, [](int) { return Contacts{}; });
    Contacts first = {flash_at(0)};
    filter.filter(kFinger, first);
    EXPECT_EQ(first.size(), 1u);
    EXPECT_EQ(count_passed(filter, 20, [](int i) { return Contacts{flash_at(1e-4 * i)}; }), 20);
  }
  EXPECT_FALSE(filter.noisy(kFinger));
}

TEST(FlickerFilter, ASingleFlashNowAndThenIsNoNoise) {
  FlickerFilter filter;
  const int passed = count_passed(
      filter, 6000, [](int i) { return i % 100 == 0 ? Contacts{flash_at(0)} : Contacts{}; });
  EXPECT_EQ(passed, 60);
  EXPECT_FALSE(filter.noisy(kFinger));
}

TEST(FlickerFilter, NoticesFlashesWithinSecondsAndTakesThemOut) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    FlickerFilter filter;
    const auto noise = flashes(seed);
    count_passed(filter, 400, noise);
    EXPECT_TRUE(filter.noisy(kFinger));
    EXPECT_FALSE(filter.noisy(kFinger + 1));
    EXPECT_LT(count_passed(filter, 2000, noise), 4);
  }
}

TEST(FlickerFilter, ANoisyFingertipStillSensesWhatLasts) {
  FlickerFilter filter;
  count_passed(filter, 1000, flashes(1));
  ASSERT_TRUE(filter.noisy(kFinger));
  const int lasting = count_passed(filter, 50, [](int) { return Contacts{flash_at(0.02)}; });
  EXPECT_EQ(lasting, 50 - (FlickerFilter::kLasting - 1));
}

TEST(FlickerFilter, TakesAFlashOutBesideARealContact) {
  FlickerFilter filter;
  count_passed(filter, 1000, flashes(1));
  Contacts both;
  for (int i = 0; i < 20; ++i) {
    both = {flash_at(0.02)};
    if (i == 19) both.push_back(flash_at(-0.02));
    filter.filter(kFinger, both);
  }
  ASSERT_EQ(both.size(), 1u);
  EXPECT_EQ(both.front().p.x(), 0.02);
}

}  // namespace
}  // namespace palpate::skills
