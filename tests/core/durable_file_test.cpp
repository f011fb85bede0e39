// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/durable_file.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "core/error_message.hpp"
#include "core/temporary_folder.hpp"
#include "core/write_faults.hpp"
#include "palpate/core/cache.hpp"
#include "palpate/core/file.hpp"

namespace palpate {
namespace {

namespace fs = std::filesystem;

TEST(DurableFile, AppendsAndTruncates) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "log";
  append_durably(path, "one\n");
  append_durably(path, "two\n");
  EXPECT_EQ(read_file(path), "one\ntwo\n");
  DurableFile file(path, DurableFile::Mode::modify);
  file.truncate(4);
  file.close();
  EXPECT_EQ(read_file(path), "one\n");
}

TEST(DurableFile, NamesThePathAndTheReason) {
  const TemporaryFolder folder;
  const fs::path missing = folder.path() / "missing";
  EXPECT_EQ(error_message([&] { DurableFile(missing, DurableFile::Mode::modify); }),
            "cannot write " + missing.string() + ": No such file or directory");
  EXPECT_EQ(error_message([&] { append_durably("/dev/full", "x"); }),
            "cannot write /dev/full: No space left on device");
}

TEST(DurableFile, NoFaultOfAnyCallLeavesHalfOfAFile) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "sub" / "file";
  const std::string before(5000, 'a'), after(70000, 'b');
  for (const bool exists : {false, true}) {
    const int calls = faults::try_all(
        folder.path(),
        [&] {
          fs::remove_all(path.parent_path());
          if (exists) write_file_atomically(path, before);
        },
        [&] { write_file_atomically(path, after); },
        [&](const faults::Fault& fault, const faults::Outcome& outcome) {
          const std::string found = fs::exists(path) ? read_file(path) : "";
          EXPECT_TRUE(found == after || (outcome.failed && found == (exists ? before : "")))
              << fault.call;
          if (outcome.failed) {
            EXPECT_NE(outcome.message.find(faults::words(fault)), std::string::npos)
                << outcome.message;
          }
          if (!fault.stays) {
            EXPECT_FALSE(fs::exists(path.string() + ".partial"));
          }
        });
    EXPECT_GE(calls, 6);
  }
}

TEST(DurableFile, NoFaultOfAnyCallMakesTheCacheAnswerWrongly) {
  const TemporaryFolder folder;
  const ScopedVariable variable("PALPATE_CACHE", folder.path().string());
  const int calls = faults::try_all(
      folder.path(), [&] { write_cache("key", "old"); }, [] { write_cache("key", "new"); },
      [&](const faults::Fault&, const faults::Outcome& outcome) {
        EXPECT_FALSE(outcome.failed);
        const auto found = read_cache("key");
        EXPECT_TRUE(found == "old" || found == "new");
      });
  EXPECT_GE(calls, 5);
}

}  // namespace
}  // namespace palpate
