// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/file.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "core/error_message.hpp"
#include "core/temporary_folder.hpp"

namespace palpate {
namespace {

namespace fs = std::filesystem;

TEST(File, ReadsBackWhatWasWritten) {
  const TemporaryFolder folder;
  std::string bytes("a\0b\r\n\xff", 6);
  for (int i = 0; i < 100000; ++i) bytes += static_cast<char>(i);
  const fs::path path = folder.path() / "new" / "folders" / "file.bin";
  write_file_atomically(path, bytes);
  EXPECT_EQ(read_file(path), bytes);
  write_file_atomically(path, "");
  EXPECT_EQ(read_file(path), "");
}

TEST(File, LeavesNoPartialFile) {
  const TemporaryFolder folder;
  write_file_atomically(folder.path() / "file", "x");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST(File, FailedWriteNamesThePathAndLeavesNothing) {
  const TemporaryFolder folder;
  const fs::path target = folder.path() / "taken";
  fs::create_directories(target / "inside");
  EXPECT_NE(error_message([&] { write_file_atomically(target, "x"); }).find(target.string()),
            std::string::npos);
  EXPECT_FALSE(fs::exists(target.string() + ".partial"));
  EXPECT_TRUE(fs::exists(target / "inside"));
}

TEST(File, FileInThePlaceOfAFolderIsBadInput) {
  const TemporaryFolder folder;
  write_file_atomically(folder.path() / "file", "x");
  const fs::path below = folder.path() / "file" / "below";
  EXPECT_NE(error_message([&] { write_file_atomically(below, "y"); }), "");
  EXPECT_NE(error_message([&] { make_writable_folder(below); }), "");
}

TEST(File, ReadErrorsNameThePath) {
  const TemporaryFolder folder;
  const fs::path missing = folder.path() / "missing";
  EXPECT_EQ(error_message([&] { read_file(missing); }), missing.string() + " does not exist");
  EXPECT_EQ(error_message([&] { read_file(folder.path()); }),
            folder.path().string() + " is a folder");
}

TEST(File, WhatCannotBeOpenedIsNamedWithTheReason) {
  const TemporaryFolder folder;
  const fs::path loop = folder.path() / "loop";
  fs::create_symlink("loop", loop);
  EXPECT_EQ(error_message([&] { read_file(loop); }),
            "cannot read " + loop.string() + ": Too many levels of symbolic links");
}

TEST(File, ALinkStaysAndWhatItLeadsToIsReplaced) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "file", link = folder.path() / "link";
  write_file_atomically(file, "old");
  fs::create_symlink("file", link);
  write_file_atomically(link, "new");
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(read_file(file), "new");
}

TEST(File, ADeviceOrAPipeIsNotReplaced) {
  const TemporaryFolder folder;
  const fs::path pipe = folder.path() / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(error_message([&] { write_file_atomically(pipe, "x"); }),
            "cannot write " + pipe.string() + ": it is no file");
  EXPECT_TRUE(fs::is_fifo(pipe));
  EXPECT_FALSE(fs::exists(pipe.string() + ".partial"));
}

TEST(File, FailureAmidReadingIsBadInput) {
  // Opens like any file, but its first page cannot be read.
  const fs::path unreadable = "/proc/self/mem";
  if (!fs::exists(unreadable)) GTEST_SKIP() << "needs " << unreadable;
  EXPECT_EQ(error_message([&] { read_file(unreadable); }), "cannot read /proc/self/mem");
}

TEST(File, WritableFolderIsMadeAndStaysEmpty) {
  const TemporaryFolder folder;
  make_writable_folder(folder.path() / "a" / "b");
  EXPECT_TRUE(fs::is_empty(folder.path() / "a" / "b"));
  make_writable_folder(folder.path() / "a" / "b");
}

}  // namespace
}  // namespace palpate
