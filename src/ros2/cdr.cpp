// SPDX-License-Identifier: Apache-2.0
#include "palpate/ros2/cdr.hpp"

namespace palpate::ros2 {
namespace {

constexpr std::size_t kMaxPadding = 7;  // bytes behind a message that mean nothing

}  // namespace

CdrReader::CdrReader(std::string_view bytes) {
  if (bytes.size() < CdrWriter::kHeader || bytes[0] != 0 || bytes[1] != 1) {
    throw BadInput(fmt::format(
        "{} bytes that do not begin with the header of plain CDR, little endian", bytes.size()));
  }
  bytes_ = bytes.substr(CdrWriter::kHeader);
}

void CdrReader::align(std::size_t size) { at_ = (at_ + size - 1) / size * size; }

std::string_view CdrReader::take(std::size_t size) {
  if (at_ > bytes_.size() || size > bytes_.size() - at_) {
    throw BadInput(
        fmt::format("it ends at byte {}, {} more are needed at byte {}", bytes_.size(), size, at_));
  }
  const std::string_view taken = bytes_.substr(at_, size);
  at_ += size;
  return taken;
}

std::size_t CdrReader::length(std::size_t least) {
  std::uint32_t count = 0;
  get(count);
  const std::size_t left = bytes_.size() - at_;
  if (count > left / least) {
    throw BadInput(
        fmt::format("a sequence of {} at byte {}, where {} bytes are left", count, at_, left));
  }
  return count;
}

void CdrReader::get(std::string& text) {
  const std::size_t size = length(1);
  text = take(size);
  if (size == 0) return;  // so do some write an empty one
  if (text.back() != '\0') {
    throw BadInput(fmt::format("a text without its final zero before byte {}", at_));
  }
  text.pop_back();
}

void CdrReader::expect_end() const {
  if (bytes_.size() > at_ + kMaxPadding) {
    throw BadInput(fmt::format("{} bytes are left behind it", bytes_.size() - at_));
  }
}

}  // namespace palpate::ros2
