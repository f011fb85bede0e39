// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/assets.hpp"

#include <gtest/gtest.h>

#include "core/error_message.hpp"
#include "core/temporary_folder.hpp"
#include "palpate/core/file.hpp"

namespace palpate {
namespace {

TEST(Assets, AreFoundUnderTheChosenFolder) {
  const TemporaryFolder folder;
  const ScopedVariable chosen("PALPATE_ASSETS", folder.path().string());
  write_file_atomically(folder.path() / "hand" / "hand.xml", "x");
  EXPECT_EQ(asset("hand/hand.xml"), folder.path() / "hand" / "hand.xml");
}

TEST(Assets, AnEmptyVariableChoosesNothing) {
  const ScopedVariable chosen("PALPATE_ASSETS", "");
  const std::string message = error_message([] { asset("no such asset"); });
  EXPECT_EQ(message.front(), '/');  // the build's own folder, not the current one
}

TEST(Assets, MissingOneSaysHowToGetIt) {
  const TemporaryFolder folder;
  const ScopedVariable chosen("PALPATE_ASSETS", folder.path().string());
  const std::string message = error_message([] { asset("hand.xml"); });
  EXPECT_NE(message.find((folder.path() / "hand.xml").string()), std::string::npos);
  EXPECT_NE(message.find("PALPATE_ASSETS"), std::string::npos);
}

}  // namespace
}  // namespace palpate
