// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <iterator>
#include <thread>

#include "core/write_faults.hpp"
#include "palpate/recording/writer.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::recording {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(RecordingFaultTest, NoFaultOfAnyCallSealsAFileThatIsNotWhole) {
  const TestFolder folder;
  const fs::path path = folder / "run.h5", partial = folder / "run.h5.partial";
  const Recording recording = toy_recording(230);
  write_recording(path, recording);
  const std::string whole = bytes_of(path);
  const int calls = faults::try_all(
      path.parent_path(), [&] { fs::remove(path), fs::remove(partial); },
      [&] { write_recording(path, recording); },
      [&](const faults::Fault& fault, const faults::Outcome& outcome) {
        SCOPED_TRACE(fault.call);
        SCOPED_TRACE(faults::words(fault));
        if (outcome.failed) {
          EXPECT_NE(outcome.message.find(faults::words(fault)), std::string::npos)
              << outcome.message;
        } else {
          EXPECT_TRUE(fs::exists(path));  // the fault did not matter, as of a call that is repeated
        }
        if (fs::exists(path)) {
          EXPECT_TRUE(bytes_of(path) == whole);
        }
        // Sealed too early, it would be believed under its temporary name as well.
        if (bytes_of(partial).substr(0, 60).find("finished ") == 20) {
          EXPECT_TRUE(bytes_of(partial) == whole);
        }
      });
  EXPECT_GT(calls, 50);  // or nothing was tried
}

TEST(RecordingFaultTest, ARecordingOfWhichAPartCouldNotBeWrittenIsNeverFinished) {
  const TestFolder folder;
  const fs::path path = folder / "run.h5";
  const Recording recording = toy_recording(20);
  const auto outcome =
      faults::run(path.parent_path(), {.call = 60, .error = ENOSPC, .stays = false}, [&] {
        Writer writer(path, recording.header);
        for (int i = 0; i < 100; ++i) {
          try {
            writer.event(recording.events[0]);
          } catch (const BadInput&) {
          }
        }
        writer.finish();
      });
  EXPECT_TRUE(outcome.failed);
  EXPECT_NE(outcome.message.find("not finished"), std::string::npos) << outcome.message;
  EXPECT_FALSE(fs::exists(path));
}

TEST(RecordingFaultTest, EqualRecordingsAreEqualByteForByteWheneverTheyAreMade) {
  const TestFolder folder;
  const Recording recording = toy_recording(120);
  write_recording(folder / "a.h5", recording);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // file times count seconds
  write_recording(folder / "b.h5", recording);
  EXPECT_TRUE(bytes_of(folder / "a.h5") == bytes_of(folder / "b.h5"));
}

}  // namespace
}  // namespace palpate::recording
