// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <H5Cpp.h>
#include <fmt/format.h>

#include <filesystem>
#include <mutex>
#include <string>
#include <type_traits>

#include "palpate/core/error.hpp"
#include "palpate/recording/hdf5_lock.hpp"

namespace palpate::recording {

/// Notes every error that HDF5 meets while it exists, also those that the destructors of its C++
/// classes keep to themselves: of a chunk that is written when its dataset is closed, for one.
/// HDF5 prints nothing meanwhile. For use under hdf5_mutex().
class Hdf5Errors {
 public:
  Hdf5Errors();
  ~Hdf5Errors();
  Hdf5Errors(const Hdf5Errors&) = delete;
  Hdf5Errors& operator=(const Hdf5Errors&) = delete;

  bool any() const { return !first_.empty(); }

  /// The first error in one line: what the operating system says of it, else HDF5's words.
  std::string reason() const { return system_error_.empty() ? first_ : system_error_; }

 private:
  static herr_t on_error(hid_t stack, void* self);
  static herr_t on_entry(unsigned depth, const H5E_error2_t* entry, void* self);

  std::string first_, system_error_;
  H5E_auto2_t previous_ = nullptr;
  void* previous_data_ = nullptr;
};

/// Runs body() alone in HDF5, whose errors become a BadInput: the path, in words what they mean,
/// and the reason. That HDF5 met an error is enough, whether it threw or not.
template <class Body>
auto with_hdf5(const std::filesystem::path& path, const char* meaning, Body&& body) {
  const std::lock_guard lock(hdf5_mutex());
  const Hdf5Errors errors;
  const auto fail = [&](const std::string& reason) {
    throw BadInput(fmt::format("{}: {}: {}", path.string(), meaning, reason));
  };
  const auto check = [&] {
    if (errors.any()) fail(errors.reason());
  };
  try {
    if constexpr (std::is_void_v<decltype(body())>) {
      body();
      check();
    } else {
      auto result = body();
      check();
      return result;
    }
  } catch (const H5::Exception& error) {
    fail(errors.any() ? errors.reason() : error.getDetailMsg());
    throw;  // not reached
  }
}

}  // namespace palpate::recording
