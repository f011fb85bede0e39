// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/output_folder.hpp"

#include <gtest/gtest.h>

#include "core/error_message.hpp"
#include "core/temporary_folder.hpp"
#include "palpate/core/file.hpp"

namespace palpate {
namespace {

namespace fs = std::filesystem;

TEST(OutputFolder, BelongsToOneRunAtATime) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a" / "run";
  for (int again = 0; again < 2; ++again) {
    const OutputFolder first(path, {}, false);
    for (const bool force : {false, true}) {
      EXPECT_NE(error_message([&] { OutputFolder(path, {}, force); }).find("in use"),
                std::string::npos);
    }
  }
  EXPECT_TRUE(fs::is_empty(path));  // the lock leaves nothing behind
}

TEST(OutputFolder, OverwritesOnlyByForce) {
  const TemporaryFolder folder;
  write_file_atomically(folder.path() / "report.json", "{}");
  write_file_atomically(folder.path() / "notes.txt", "mine");
  const std::string message = error_message([&] {
    OutputFolder(folder.path(), {"x.h5", "report.json"}, false);
  });
  EXPECT_NE(message.find("report.json"), std::string::npos);
  EXPECT_NE(message.find("--force"), std::string::npos);
  EXPECT_TRUE(fs::exists(folder.path() / "report.json"));
  const OutputFolder output(folder.path(), {"x.h5", "report.json"}, true);
  EXPECT_FALSE(fs::exists(folder.path() / "report.json"));
  EXPECT_TRUE(fs::exists(folder.path() / "notes.txt"));
}

TEST(OutputFolder, IsFreeAfterARefusal) {
  const TemporaryFolder folder;
  write_file_atomically(folder.path() / "x", "");
  EXPECT_NE(error_message([&] { OutputFolder(folder.path(), {"x"}, false); }), "");
  const OutputFolder output(folder.path(), {"y"}, false);
}

}  // namespace
}  // namespace palpate
