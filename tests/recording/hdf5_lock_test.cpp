// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/hdf5_lock.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "palpate/core/error.hpp"
#include "palpate/recording/recording.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::recording {
namespace {

TEST(Hdf5Lock, IsOneForAll) {
  const std::scoped_lock lock(hdf5_mutex());
  bool taken = true;
  std::thread([&taken] {
    taken = hdf5_mutex().try_lock();
    if (taken) hdf5_mutex().unlock();
  }).join();
  EXPECT_FALSE(taken);
}

TEST(Hdf5Lock, IsFreeAfterAReaderHasFailed) {
  TestFolder folder;
  EXPECT_THROW(read_recording(folder / "missing.h5"), BadInput);
  ASSERT_TRUE(hdf5_mutex().try_lock());
  hdf5_mutex().unlock();
}

}  // namespace
}  // namespace palpate::recording
