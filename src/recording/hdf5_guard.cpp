// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/hdf5_guard.hpp"

#include <charconv>
#include <string_view>
#include <system_error>

namespace palpate::recording {
namespace {

/// The "errno = N" in HDF5's description of a failed call; 0 if it names none.
int error_number(std::string_view description) {
  constexpr std::string_view kKey = "errno = ";
  const auto at = description.find(kKey);
  if (at == std::string_view::npos) return 0;
  description.remove_prefix(at + kKey.size());
  int number = 0;
  std::from_chars(description.data(), description.data() + description.size(), number);
  return number;
}

}  // namespace

Hdf5Errors::Hdf5Errors() {
  H5Eget_auto2(H5E_DEFAULT, &previous_, &previous_data_);
  H5Eset_auto2(H5E_DEFAULT, &Hdf5Errors::on_error, this);
}

Hdf5Errors::~Hdf5Errors() { H5Eset_auto2(H5E_DEFAULT, previous_, previous_data_); }

herr_t Hdf5Errors::on_error(hid_t stack, void* self) {
  return H5Ewalk2(stack, H5E_WALK_UPWARD, &Hdf5Errors::on_entry, self);
}

herr_t Hdf5Errors::on_entry(unsigned, const H5E_error2_t* entry, void* self) {
  auto& errors = *static_cast<Hdf5Errors*>(self);
  const std::string_view description = entry->desc ? entry->desc : "";
  if (errors.first_.empty()) errors.first_ = fmt::format("HDF5: {}", description);
  if (const int number = error_number(description); number != 0 && errors.system_error_.empty()) {
    errors.system_error_ = std::generic_category().message(number);
  }
  return 0;
}

}  // namespace palpate::recording
