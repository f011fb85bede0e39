// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/parallel.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

#include "core/error_message.hpp"

namespace palpate {
namespace {

/// Takes turns of different length, so that the threads overtake one another.
void dawdle(std::size_t index) {
  std::this_thread::sleep_for(std::chrono::microseconds(index * 7919 % 300));
}

template <class Action>
std::string runtime_error(const Action& action) {
  try {
    action();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

class Parallel : public testing::TestWithParam<int> {};

TEST_P(Parallel, CallsEachIndexOnce) {
  std::vector<std::atomic<int>> calls(200);
  parallel_for(calls.size(), GetParam(), [&](std::size_t index) {
    dawdle(index);
    ++calls[index];
  });
  for (const auto& count : calls) EXPECT_EQ(count, 1);
}

TEST_P(Parallel, NothingToDo) {
  parallel_for(0, GetParam(), [](std::size_t) { FAIL(); });
  parallel_ordered(
      0, GetParam(), [](std::size_t i) { return i; }, [](std::size_t, std::size_t) { FAIL(); });
}

TEST_P(Parallel, RethrowsTheFailureOfTheLowestIndex) {
  const auto work = [](std::size_t index) {
    dawdle(1000 - index);
    if (index % 10 == 9) throw std::runtime_error(std::to_string(index));
  };
  EXPECT_EQ(runtime_error([&] { parallel_for(100, GetParam(), work); }), "9");
}

TEST_P(Parallel, DeliversInOrder) {
  std::vector<std::size_t> order;
  parallel_ordered(
      200, GetParam(),
      [](std::size_t index) {
        dawdle(index);
        return std::to_string(index * index);
      },
      [&](std::size_t index, const std::string& result) {
        EXPECT_EQ(result, std::to_string(index * index));
        order.push_back(index);
      });
  ASSERT_EQ(order.size(), 200u);
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
}

TEST_P(Parallel, DeliversAllBeforeAFailureAndNothingAfter) {
  std::vector<std::size_t> delivered;
  const auto produce = [](std::size_t index) {
    dawdle(index);
    if (index == 20 || index == 21) throw std::runtime_error(std::to_string(index));
    return index;
  };
  const auto consume = [&](std::size_t, std::size_t result) { delivered.push_back(result); };
  EXPECT_EQ(runtime_error([&] { parallel_ordered(100, GetParam(), produce, consume); }), "20");
  ASSERT_EQ(delivered.size(), 20u);
  EXPECT_EQ(delivered.back(), 19u);
}

TEST_P(Parallel, ConsumerThatThrowsIsNotCalledAgain) {
  int calls = 0;
  const auto produce = [](std::size_t index) {
    dawdle(index);
    return index;
  };
  const auto consume = [&](std::size_t index, std::size_t) {
    ++calls;
    if (index == 5) throw std::runtime_error("full");
  };
  EXPECT_EQ(runtime_error([&] { parallel_ordered(100, GetParam(), produce, consume); }), "full");
  EXPECT_EQ(calls, 6);
}

INSTANTIATE_TEST_SUITE_P(Threads, Parallel, testing::Values(1, 2, 8));

TEST(ParallelFor, OneThreadRunsInlineInOrder) {
  const auto caller = std::this_thread::get_id();
  std::vector<std::size_t> order;
  parallel_for(50, 1, [&](std::size_t index) {
    EXPECT_EQ(std::this_thread::get_id(), caller);
    order.push_back(index);
  });
  for (std::size_t i = 0; i < order.size(); ++i) EXPECT_EQ(order[i], i);
}

TEST(ParallelFor, UsesSeveralThreads) {
  // Each of two calls waits for the other: with one thread they would time out.
  std::atomic<int> arrived = 0;
  parallel_for(2, 2, [&](std::size_t) {
    ++arrived;
    for (int i = 0; i < 10000 && arrived < 2; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(arrived, 2);
  });
}

TEST(ParallelFor, RefusesFewerThanOneThread) {
  EXPECT_NE(error_message([] { parallel_for(3, 0, [](std::size_t) {}); }), "");
  EXPECT_NE(error_message([] { parallel_for(3, -1, [](std::size_t) {}); }).find("-1"),
            std::string::npos);
}

}  // namespace
}  // namespace palpate
