// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace palpate::app {

/// Messages for those who watch: one thread adds, another reads, and neither waits for the other.
///
/// Who comes late begins with the oldest that is kept. All readers share the messages' bytes.
class MessageLog {
 public:
  static constexpr std::size_t kMaxBytes = std::size_t{256} << 20;  ///< that are kept

  MessageLog();
  ~MessageLog();
  MessageLog(const MessageLog&) = delete;
  MessageLog& operator=(const MessageLog&) = delete;

  void add(std::string message);
  /// Forgets all, for another page: its messages have the next epoch.
  void begin(std::string page);

  struct Item {
    std::shared_ptr<const std::string> message;  ///< none: nothing newer
    std::uint64_t number = 0;
  };
  /// The first that is kept from this number on. Numbers count from 0, over all epochs.
  Item from(std::uint64_t number) const;
  /// Number of the present page's first message, and of the next one to come.
  std::pair<std::uint64_t, std::uint64_t> range() const;
  std::shared_ptr<const std::string> page() const;

  int descriptor() const { return event_; }  ///< readable when there is something new
  void acknowledge() const;                  ///< until then

 private:
  void signal() const;

  mutable std::mutex mutex_;
  std::deque<std::shared_ptr<const std::string>> messages_;
  std::shared_ptr<const std::string> page_;
  std::uint64_t first_ = 0, page_first_ = 0;  // numbers: of the first kept; of the page's first
  std::size_t bytes_ = 0;
  int event_ = -1;
};

}  // namespace palpate::app
