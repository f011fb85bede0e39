// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/version.hpp"

#include <gtest/gtest.h>

#include <regex>
#include <string>

namespace palpate {
namespace {

TEST(Version, HasThreeNumbers) {
  EXPECT_TRUE(std::regex_match(std::string(version()), std::regex(R"(\d+\.\d+\.\d+)")));
}

}  // namespace
}  // namespace palpate
