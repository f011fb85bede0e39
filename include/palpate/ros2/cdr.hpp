// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "palpate/core/error.hpp"

namespace palpate::ros2 {

/// A struct of messages/: it has a type name and visits its fields.
template <class T>
concept Message = requires {
  std::string_view(T::kType);
};

template <class T>
concept CdrScalar = std::is_arithmetic_v<T> || std::same_as<T, std::byte>;

/// Appends values as XCDR1, little endian: scalars aligned to their size from the end of the
/// encapsulation header, strings with a trailing zero, sequences with their length before them.
class CdrWriter {
 public:
  CdrWriter() : bytes_("\0\1\0\0", kHeader) {}
  std::string take() { return std::move(bytes_); }

  template <CdrScalar T>
  void put(const T& value) {
    align(sizeof(T));
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void put(const std::string& text) {
    put(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.append(text.c_str(), text.size() + 1);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(static_cast<std::uint32_t>(values.size()));
    if constexpr (CdrScalar<T>) {
      if (values.empty()) return;
      align(sizeof(T));
      bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
    } else {
      for (const T& value : values) put(value);
    }
  }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& values) {
    for (const T& value : values) put(value);
  }
  template <Message M>
  void put(const M& message) {
    M::fields(message, [this](std::string_view, const auto& value) { this->put(value); });
  }

  static constexpr std::size_t kHeader = 4;  ///< bytes of encapsulation

 private:
  static_assert(std::endian::native == std::endian::little);
  void align(std::size_t size) {
    bytes_.resize((bytes_.size() - kHeader + size - 1) / size * size + kHeader);
  }

  std::string bytes_;
};

/// Bytes that a value has at least in CDR, without padding.
template <class T>
std::size_t min_cdr_size() {
  if constexpr (CdrScalar<T>) {
    return sizeof(T);
  } else if constexpr (Message<T>) {
    std::size_t sum = 0;
    const T empty;
    T::fields(empty, [&](std::string_view, const auto& value) {
      sum += min_cdr_size<std::remove_cvref_t<decltype(value)>>();
    });
    return sum;
  } else if constexpr (requires { std::tuple_size<T>::value; }) {
    return std::tuple_size_v<T> * min_cdr_size<typename T::value_type>();
  } else {
    return sizeof(std::uint32_t);
  }
}

/// Reads what CdrWriter wrote, or anyone else. No length is believed that the bytes left cannot
/// hold, so that memory stays within a small multiple of the message's size.
class CdrReader {
 public:
  /// @throws BadInput unless the bytes begin with the header of plain CDR, little endian
  explicit CdrReader(std::string_view bytes);

  template <CdrScalar T>
  void get(T& value) {
    align(sizeof(T));
    const std::string_view taken = take(sizeof(T));
    if constexpr (std::same_as<T, bool>) {
      value = taken.front() != 0;
    } else {
      std::memcpy(&value, taken.data(), sizeof(T));
    }
  }
  void get(std::string& text);
  template <class T>
  void get(std::vector<T>& values) {
    static const std::size_t least = min_cdr_size<T>();
    values.resize(length(least));
    if constexpr (CdrScalar<T>) {
      if (values.empty()) return;
      align(sizeof(T));
      std::memcpy(values.data(), take(values.size() * sizeof(T)).data(), values.size() * sizeof(T));
    } else {
      for (T& value : values) get(value);
    }
  }
  template <class T, std::size_t N>
  void get(std::array<T, N>& values) {
    for (T& value : values) get(value);
  }
  template <Message M>
  void get(M& message) {
    M::fields(message, [this](std::string_view, auto& value) { this->get(value); });
  }

  /// @throws BadInput if more than padding is left
  void expect_end() const;

 private:
  void align(std::size_t size);
  std::string_view take(std::size_t size);
  std::size_t length(std::size_t least);

  std::string_view bytes_;  ///< behind the encapsulation header
  std::size_t at_ = 0;
};

/// A message in CDR, with the encapsulation header before it.
template <Message M>
std::string serialize(const M& message) {
  CdrWriter writer;
  writer.put(message);
  return writer.take();
}

/// @throws BadInput, naming the type and the byte, for what is no such message
template <Message M>
M deserialize(std::string_view bytes) {
  try {
    M message;
    CdrReader reader(bytes);
    reader.get(message);
    reader.expect_end();
    return message;
  } catch (const BadInput& error) {
    throw BadInput(fmt::format("no {}: {}", M::kType, error.what()));
  }
}

}  // namespace palpate::ros2
