// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "common.hpp"
#include "palpate/core/error.hpp"
#include "view_stream.hpp"

namespace palpate::app {
namespace {

TEST(WithoutRos2, ItsCommandsSayWhatIsMissing) {
  CLI::App program;
  Command chosen;
  add_ros2(program, chosen);
  program.parse("ros2 estimate --object mug");
  ASSERT_TRUE(chosen);
  EXPECT_THROW(chosen(), BadInput);
  EXPECT_THROW(view_stream({}, {}), BadInput);
}

}  // namespace
}  // namespace palpate::app
