// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/worker_pool.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/error_message.hpp"

namespace palpate {
namespace {

class Pool : public testing::TestWithParam<int> {};

TEST_P(Pool, CallsEachIndexOnceInEveryCall) {
  WorkerPool pool(GetParam());
  EXPECT_EQ(pool.threads(), GetParam());
  std::vector<std::atomic<int>> calls(7);
  for (int call = 1; call <= 100; ++call) {
    pool.run(calls.size(), [&](std::size_t index) { ++calls[index]; });
    for (const auto& count : calls) ASSERT_EQ(count, call);  // all have ended
  }
}

TEST_P(Pool, WorksAfterItsThreadsFellAsleep) {
  WorkerPool pool(GetParam());
  std::atomic<int> calls = 0;
  for (int i = 0; i < 3; ++i) {
    pool.run(4, [&](std::size_t) { ++calls; });
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  EXPECT_EQ(calls, 12);
}

TEST_P(Pool, RethrowsAndGoesOn) {
  WorkerPool pool(GetParam());
  for (int i = 0; i < 20; ++i) {
    EXPECT_THROW(pool.run(50,
                          [](std::size_t index) {
                            if (index % 10 == 9) throw std::runtime_error("no");
                          }),
                 std::runtime_error);
  }
  std::atomic<std::size_t> sum = 0;
  pool.run(10, [&](std::size_t index) { sum += index; });
  EXPECT_EQ(sum, 45U);
}

TEST_P(Pool, NothingToDo) {
  WorkerPool pool(GetParam());
  pool.run(0, [](std::size_t) { FAIL(); });
}

INSTANTIATE_TEST_SUITE_P(Threads, Pool, testing::Values(1, 2, 8));

TEST(WorkerPool, UsesSeveralThreads) {
  WorkerPool pool(2);
  // Each of two calls waits for the other: with one thread they would time out.
  std::atomic<int> arrived = 0;
  pool.run(2, [&](std::size_t) {
    ++arrived;
    for (int i = 0; i < 10000 && arrived < 2; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(arrived, 2);
  });
}

/// Its threads are not in the child, which must neither wait for them nor for their end.
TEST(WorkerPool, RunsInTheCallersThreadAfterAFork) {
  auto pool = std::make_unique<WorkerPool>(3);
  pool->run(3, [](std::size_t) {});
  const pid_t child = fork();
  if (child == 0) {
    alarm(20);
    std::vector<int> order;
    pool->run(5, [&](std::size_t index) { order.push_back(static_cast<int>(index)); });
    std::vector<int> expected(5);
    std::iota(expected.begin(), expected.end(), 0);
    pool.reset();
    _exit(order == expected ? 0 : 1);
  }
  int status = -1;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
}

TEST(WorkerPool, RefusesFewerThanOneThread) {
  EXPECT_NE(error_message([] { const WorkerPool pool(0); }).find("0 threads"), std::string::npos);
}

}  // namespace
}  // namespace palpate
