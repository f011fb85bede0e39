// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/fnv1a.hpp"

#include <gtest/gtest.h>

namespace palpate {
namespace {

TEST(Fnv1a, HashesAsItsAuthorsSay) {
  EXPECT_EQ(fnv1a(""), 0xcbf29ce484222325u);
  EXPECT_EQ(fnv1a("a"), 0xaf63dc4c8601ec8cu);
  EXPECT_EQ(fnv1a("foobar"), 0x85944171f73967e8u);
}

TEST(Fnv1a, GoesOnFromAnotherHash) { EXPECT_EQ(fnv1a("bar", fnv1a("foo")), fnv1a("foobar")); }

}  // namespace
}  // namespace palpate
