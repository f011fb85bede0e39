// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <H5Cpp.h>
#include <fmt/format.h>

#include <cstdint>
#include <string>
#include <type_traits>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/recording/hdf5_guard.hpp"

namespace palpate::recording {

template <class T>
const H5::PredType& hdf5_type() {
  if constexpr (std::is_same_v<T, double>) return H5::PredType::IEEE_F64LE;
  if constexpr (std::is_same_v<T, int>) return H5::PredType::STD_I32LE;
  if constexpr (std::is_same_v<T, std::int16_t>) return H5::PredType::STD_I16LE;
  if constexpr (std::is_same_v<T, char>) return H5::PredType::STD_U8LE;
}

template <class T>
const H5::PredType& native_type() {
  if constexpr (std::is_same_v<T, double>) return H5::PredType::NATIVE_DOUBLE;
  if constexpr (std::is_same_v<T, int>) return H5::PredType::NATIVE_INT;
  if constexpr (std::is_same_v<T, std::int16_t>) return H5::PredType::NATIVE_INT16;
  if constexpr (std::is_same_v<T, char>) return H5::PredType::NATIVE_UINT8;
}

/// An HDF5 identifier, closed at the end. Unlike the C++ classes of HDF5 it prints nothing where
/// closing fails: Hdf5Errors notes that.
class Handle {
 public:
  /// @throws H5::Exception if `id` is that of a call that failed
  Handle(hid_t id, herr_t (*close)(hid_t));
  ~Handle() { close_(id_); }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

/// @throws H5::Exception if a call of HDF5 failed
void expect_done(herr_t status, const char* call);

/// Access to a file that one process may read while another appends; every block carries a
/// checksum.
H5::FileAccPropList file_access();

/// A group. Like all that is made here it notes no time, so that equal contents are equal files.
void create_group(hid_t parent, const std::string& name);

/// A dataset of N rows and `width` columns that grows by rows, in chunks with checksums.
void create_growing(hid_t parent, const std::string& name, const H5::DataType& type, hsize_t width,
                    hsize_t rows_per_chunk);

/// Appends whole rows of `width` values.
void append_rows(hid_t file, const std::string& name, const void* values, hsize_t rows,
                 hsize_t width, const H5::DataType& memory_type);

/// @throws BadInput unless the dataset is stored as create_growing() does, in this file: others may
///         lie in other files, or unpack to any size
void check_stored(const H5::H5File& file, const H5::DataSet& dataset, const std::string& name);

/// Number of rows of a dataset.
/// @throws BadInput unless it is N x width, of the type's class, and no larger than `file_size`
hsize_t checked_rows(const H5::DataSet& dataset, const std::string& name, hsize_t width,
                     const H5::DataType& type, std::uintmax_t file_size);

/// All rows of the dataset, row after row.
template <class T>
std::vector<T> read_rows(const H5::H5File& file, const std::string& name, hsize_t width) {
  const H5::DataSet dataset = file.openDataSet(name);
  check_stored(file, dataset, name);
  const auto rows = checked_rows(dataset, name, width, hdf5_type<T>(), file.getFileSize());
  std::vector<T> values(rows * width);
  if (rows > 0) dataset.read(values.data(), native_type<T>());
  return values;
}

}  // namespace palpate::recording
