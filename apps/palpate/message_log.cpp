// SPDX-License-Identifier: Apache-2.0
#include "message_log.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>

namespace palpate::app {

MessageLog::MessageLog()
    : page_(std::make_shared<std::string>()), event_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

MessageLog::~MessageLog() { ::close(event_); }

void MessageLog::add(std::string message) {
  {
    const std::lock_guard lock(mutex_);
    bytes_ += message.size();
    messages_.push_back(std::make_shared<const std::string>(std::move(message)));
    for (; bytes_ > kMaxBytes && messages_.size() > 1; ++first_) {
      bytes_ -= messages_.front()->size();
      messages_.pop_front();
    }
  }
  signal();
}

void MessageLog::begin(std::string page) {
  {
    const std::lock_guard lock(mutex_);
    first_ += messages_.size();
    page_first_ = first_;
    messages_.clear();
    bytes_ = 0;
    page_ = std::make_shared<const std::string>(std::move(page));
  }
  signal();
}

MessageLog::Item MessageLog::from(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  number = std::max(number, first_);
  if (number >= first_ + messages_.size()) return {nullptr, number};
  return {messages_[number - first_], number};
}

std::pair<std::uint64_t, std::uint64_t> MessageLog::range() const {
  const std::lock_guard lock(mutex_);
  return {page_first_, first_ + messages_.size()};
}

std::shared_ptr<const std::string> MessageLog::page() const {
  const std::lock_guard lock(mutex_);
  return page_;
}

void MessageLog::signal() const {
  const std::uint64_t one = 1;
  static_cast<void>(!write(event_, &one, sizeof one));
}

void MessageLog::acknowledge() const {
  std::uint64_t count = 0;
  static_cast<void>(!read(event_, &count, sizeof count));
}

}  // namespace palpate::app
