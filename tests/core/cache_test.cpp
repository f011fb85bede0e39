// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/cache.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/temporary_folder.hpp"
#include "palpate/core/file.hpp"

namespace palpate {
namespace {

namespace fs = std::filesystem;

class Cache : public ::testing::Test {
 protected:
  fs::path only_entry() const {
    EXPECT_EQ(folder_.files().size(), 1u);
    return folder_.files().at(0);
  }

  const TemporaryFolder folder_;
  const ScopedVariable place_{"PALPATE_CACHE", folder_.path().string()};
};

TEST(ContentHash, MatchesThePublishedVectorsOfFnv1a128) {
  EXPECT_EQ(content_hash(""), "6c62272e07bb014262b821756295c58d");
  EXPECT_EQ(content_hash("a"), "d228cb696f1a8caf78912b704e4a8964");
  EXPECT_EQ(content_hash("foobar"), "343e1662793c64bf6f0d3597ba446f18");
}

TEST(ContentHash, SeesEveryByte) {
  const std::string zeros(3, '\0');
  EXPECT_NE(content_hash(zeros), content_hash(zeros + '\0'));
  EXPECT_NE(content_hash("\xff"), content_hash("\x7f"));
}

TEST_F(Cache, GivesBackWhatWasKept) {
  const std::string bytes("a\0b\nc\r\n\xff", 8);
  EXPECT_EQ(read_cache("parts"), std::nullopt);
  write_cache("parts", bytes);
  EXPECT_EQ(read_cache("parts"), bytes);
  EXPECT_EQ(read_cache("other"), std::nullopt);
  write_cache("empty", "");
  EXPECT_EQ(read_cache("empty"), "");
}

TEST_F(Cache, KeepsTheLatest) {
  write_cache("key", "first, and longer");
  write_cache("key", "second");
  EXPECT_EQ(read_cache("key"), "second");
  EXPECT_EQ(folder_.files().size(), 1u);
}

TEST_F(Cache, AnyDamageIsAMiss) {
  write_cache("key", "some bytes");
  const std::string entry = read_file(only_entry());
  for (std::size_t i = 0; i < entry.size(); ++i) {
    std::string damaged = entry;
    damaged[i] = static_cast<char>(damaged[i] ^ 1);
    write_file_atomically(only_entry(), damaged);
    EXPECT_EQ(read_cache("key"), std::nullopt) << "byte " << i;
    write_file_atomically(only_entry(), entry.substr(0, i));
    EXPECT_EQ(read_cache("key"), std::nullopt) << "cut at " << i;
  }
  write_file_atomically(only_entry(), entry + "x");
  EXPECT_EQ(read_cache("key"), std::nullopt);
  write_cache("key", "some bytes");
  EXPECT_EQ(read_cache("key"), "some bytes");
}

TEST_F(Cache, AnEntryNeverAnswersForAnotherKey) {
  write_cache("key", "bytes");
  const std::string entry = read_file(only_entry());
  write_file_atomically(folder_.path() / content_hash("other"), entry);
  EXPECT_EQ(read_cache("other"), std::nullopt);
}

TEST_F(Cache, AFolderInPlaceOfAnEntryIsAMiss) {
  fs::create_directories(folder_.path() / content_hash("key") / "inside");
  write_cache("key", "bytes");
  EXPECT_EQ(read_cache("key"), std::nullopt);
}

TEST_F(Cache, UnwritableIsNoCache) {
  write_file_atomically(folder_.path() / "file", "");
  const ScopedVariable below_a_file("PALPATE_CACHE", (folder_.path() / "file" / "x").string());
  EXPECT_NO_THROW(write_cache("key", "bytes"));
  EXPECT_EQ(read_cache("key"), std::nullopt);
}

TEST_F(Cache, FollowsTheEnvironment) {
  const ScopedVariable none("PALPATE_CACHE", std::nullopt);
  const ScopedVariable xdg("XDG_CACHE_HOME", (folder_.path() / "xdg").string());
  write_cache("key", "in xdg");
  EXPECT_TRUE(fs::exists(folder_.path() / "xdg" / "palpate" / content_hash("key")));
  const ScopedVariable relative("XDG_CACHE_HOME", "relative");
  const ScopedVariable home("HOME", folder_.path().string());
  write_cache("key", "at home");
  EXPECT_TRUE(fs::exists(folder_.path() / ".cache" / "palpate" / content_hash("key")));
  const ScopedVariable homeless("HOME", std::nullopt);
  EXPECT_NO_THROW(write_cache("key", "nowhere"));
  EXPECT_EQ(read_cache("key"), std::nullopt);
}

TEST_F(Cache, ManyWritersNeverLetAReaderSeeHalf) {
  const std::string one(20000, '1'), two(30000, '2');
  const auto write = [](const std::string& bytes) {
    for (int i = 0; i < 50; ++i) write_cache("key", bytes);
  };
  std::thread first(write, one), second(write, two);
  for (int i = 0; i < 100; ++i) {
    const auto seen = read_cache("key");
    EXPECT_TRUE(!seen || *seen == one || *seen == two);
  }
  first.join();
  second.join();
}

}  // namespace
}  // namespace palpate
