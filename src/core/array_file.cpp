// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/array_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>

#include "palpate/core/error.hpp"
#include "palpate/core/fnv1a.hpp"

namespace palpate {
namespace {

constexpr Eigen::Index kMaxValues = 1 << 26;

static_assert(std::endian::native == std::endian::little, "values are written as they lie");

/// Takes text and values off the front of a file.
class Cursor {
 public:
  Cursor(std::string_view bytes, const std::string& source) : rest_(bytes), source_(source) {}

  std::string_view line() {
    const auto end = rest_.find('\n');
    if (end == std::string_view::npos || end > 200) fail("the header is cut short");
    return take(end + 1).substr(0, end);
  }

  std::string_view take(std::size_t count) {
    if (count > rest_.size()) {
      fail(fmt::format("cut short, {} bytes are missing", count - rest_.size()));
    }
    const auto front = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return front;
  }

  [[nodiscard]] std::size_t left() const { return rest_.size(); }

  [[noreturn]] void fail(const std::string& why) const {
    throw BadInput(fmt::format("{}: {}", source_, why));
  }

 private:
  std::string_view rest_;
  const std::string& source_;
};

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> result;
  while (true) {
    const auto blank = line.find(' ');
    result.push_back(line.substr(0, blank));
    if (blank == std::string_view::npos) return result;
    line.remove_prefix(blank + 1);
  }
}

Eigen::Index size_of(std::string_view word, std::string_view line, const Cursor& cursor) {
  Eigen::Index value = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || value < 1 || value > kMaxValues) {
    cursor.fail(fmt::format("'{}' names no matrix and its size", line));
  }
  return value;
}

void check_first_line(Cursor& cursor, const std::string& kind, int version) {
  const auto first = words(cursor.line());
  if (first.size() != 3 || first[0] != "palpate") cursor.fail("no file of weights");
  if (first[1] != kind) cursor.fail(fmt::format("weights of a {}, not of a {}", first[1], kind));
  if (first[2] != std::to_string(version)) {
    cursor.fail(fmt::format("version {}, not {}", first[2], version));
  }
}

}  // namespace

void ArrayFile::add(const std::string& name, Eigen::MatrixXf values) {
  const bool known = std::any_of(arrays_.begin(), arrays_.end(),
                                 [&](const auto& array) { return array.first == name; });
  if (name.empty() || known || name.find_first_of(" \n") != std::string::npos) {
    throw BadInput(fmt::format("'{}' is no new name of a matrix", name));
  }
  if (!values.allFinite()) {
    throw BadInput(fmt::format("{}: matrix {} holds a value that is not finite",
                               source_.empty() ? kind_ : source_, name));
  }
  arrays_.emplace_back(name, std::move(values));
}

std::string ArrayFile::bytes() const {
  std::string header = fmt::format("palpate {} {}\n", kind_, version_), payload;
  for (const auto& [name, values] : arrays_) {
    header += fmt::format("{} {} {}\n", name, values.rows(), values.cols());
    payload.append(reinterpret_cast<const char*>(values.data()),
                   static_cast<std::size_t>(values.size()) * sizeof(float));
  }
  const std::uint64_t sum = fnv1a(payload);
  payload.append(reinterpret_cast<const char*>(&sum), sizeof sum);
  return header + "end\n" + payload;
}

ArrayFile ArrayFile::parse(std::string_view bytes, const std::string& source,
                           const std::string& kind, int version) {
  Cursor cursor(bytes, source);
  check_first_line(cursor, kind, version);
  struct Entry {
    std::string name;
    Eigen::Index rows, columns;
  };
  std::vector<Entry> entries;
  std::size_t size = 0;
  for (auto line = cursor.line(); line != "end"; line = cursor.line()) {
    const auto parts = words(line);
    if (parts.size() != 3) cursor.fail(fmt::format("'{}' names no matrix and its size", line));
    entries.push_back(
        {std::string(parts[0]), size_of(parts[1], line, cursor), size_of(parts[2], line, cursor)});
    if (entries.back().rows > kMaxValues / entries.back().columns) {
      cursor.fail(fmt::format("matrix {} is too large", entries.back().name));
    }
    size += static_cast<std::size_t>(entries.back().rows * entries.back().columns) * sizeof(float);
  }
  const std::string_view payload = cursor.take(size);
  std::uint64_t sum = 0;
  std::memcpy(&sum, cursor.take(sizeof sum).data(), sizeof sum);
  if (cursor.left() > 0) cursor.fail(fmt::format("{} bytes too many", cursor.left()));
  if (sum != fnv1a(payload)) cursor.fail("the values do not match their sum");
  ArrayFile file(kind, version);
  file.source_ = source;
  std::size_t at = 0;
  for (const Entry& entry : entries) {
    Eigen::MatrixXf values(entry.rows, entry.columns);
    const std::size_t length = static_cast<std::size_t>(values.size()) * sizeof(float);
    std::memcpy(values.data(), payload.data() + at, length);
    at += length;
    file.add(entry.name, std::move(values));
  }
  return file;
}

const Eigen::MatrixXf& ArrayFile::get(const std::string& name, Eigen::Index rows,
                                      Eigen::Index columns) const {
  for (const auto& [known, values] : arrays_) {
    if (known != name) continue;
    if ((rows >= 0 && values.rows() != rows) || (columns >= 0 && values.cols() != columns)) {
      throw BadInput(fmt::format("{}: matrix {} is {} x {}, not {} x {}", source_, name,
                                 values.rows(), values.cols(), rows < 0 ? values.rows() : rows,
                                 columns < 0 ? values.cols() : columns));
    }
    return values;
  }
  throw BadInput(fmt::format("{}: there is no matrix {}", source_, name));
}

}  // namespace palpate
