// SPDX-License-Identifier: Apache-2.0
#include "recording/hdf5_file.hpp"

#include <algorithm>
#include <array>

namespace palpate::recording {

H5::FileAccPropList file_access() {
  H5::FileAccPropList access;
  access.setLibverBounds(H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
  // Some network file systems have no locks; a reader beside the writer is safe without them.
  H5Pset_file_locking(access.getId(), false, true);
  // By default a block with a wrong checksum is tried 100 times, with longer and longer waits.
  H5Pset_metadata_read_attempts(access.getId(), 3);
  return access;
}

Handle::Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {
  if (id < 0) throw H5::IdComponentException("Handle", "could not be opened or made");
}

void expect_done(herr_t status, const char* call) {
  if (status < 0) throw H5::LibraryIException(call, "failed");
}

void create_group(hid_t parent, const std::string& name) {
  const Handle properties(H5Pcreate(H5P_GROUP_CREATE), &H5Pclose);
  H5Pset_obj_track_times(properties, false);
  const Handle group(H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT),
                     &H5Gclose);
}

void create_growing(hid_t parent, const std::string& name, const H5::DataType& type, hsize_t width,
                    hsize_t rows_per_chunk) {
  const std::array<hsize_t, 2> size = {0, width}, most = {H5S_UNLIMITED, width};
  const std::array<hsize_t, 2> chunk = {rows_per_chunk, width};
  const Handle properties(H5Pcreate(H5P_DATASET_CREATE), &H5Pclose);
  H5Pset_chunk(properties, 2, chunk.data());
  H5Pset_fletcher32(properties);
  H5Pset_obj_track_times(properties, false);
  const Handle space(H5Screate_simple(2, size.data(), most.data()), &H5Sclose);
  const Handle dataset(
      H5Dcreate2(parent, name.c_str(), type.getId(), space, H5P_DEFAULT, properties, H5P_DEFAULT),
      &H5Dclose);
}

void append_rows(hid_t file, const std::string& name, const void* values, hsize_t rows,
                 hsize_t width, const H5::DataType& memory_type) {
  if (rows == 0) return;
  const Handle dataset(H5Dopen2(file, name.c_str(), H5P_DEFAULT), &H5Dclose);
  std::array<hsize_t, 2> size{};
  {
    const Handle space(H5Dget_space(dataset), &H5Sclose);
    H5Sget_simple_extent_dims(space, size.data(), nullptr);
  }
  const std::array<hsize_t, 2> offset = {size[0], 0}, block = {rows, width};
  size[0] += rows;
  expect_done(H5Dset_extent(dataset, size.data()), "H5Dset_extent");
  const Handle file_space(H5Dget_space(dataset), &H5Sclose);
  H5Sselect_hyperslab(file_space, H5S_SELECT_SET, offset.data(), nullptr, block.data(), nullptr);
  const Handle memory_space(H5Screate_simple(2, block.data(), nullptr), &H5Sclose);
  expect_done(H5Dwrite(dataset, memory_type.getId(), memory_space, file_space, H5P_DEFAULT, values),
              "H5Dwrite");
}

void check_stored(const H5::H5File& file, const H5::DataSet& dataset, const std::string& name) {
  const H5::DSetCreatPropList properties = dataset.getCreatePlist();
  bool usual = dataset.getFileName() == file.getFileName() &&
               properties.getLayout() == H5D_CHUNKED && properties.getNfilters() == 1;
  if (usual) {
    std::size_t count = 0;
    unsigned flags = 0;
    usual = H5Pget_filter2(properties.getId(), 0, &flags, &count, nullptr, 0, nullptr, nullptr) ==
            H5Z_FILTER_FLETCHER32;
  }
  if (!usual) throw BadInput(fmt::format("{} is not stored as in a recording", name));
  std::array<hsize_t, 2> chunk{};
  if (properties.getChunk(2, chunk.data()) != 2) return;  // no table, as checked_rows() will say
  const hsize_t row = chunk[1] * dataset.getDataType().getSize();
  if (dataset.getStorageSize() > 0 && chunk[0] > file.getFileSize() / std::max<hsize_t>(row, 1)) {
    throw BadInput(
        fmt::format("{} has blocks of {} rows, more than the file holds", name, chunk[0]));
  }
}

hsize_t checked_rows(const H5::DataSet& dataset, const std::string& name, hsize_t width,
                     const H5::DataType& type, std::uintmax_t file_size) {
  const H5::DataSpace space = dataset.getSpace();
  std::array<hsize_t, 2> size{};
  const bool matrix = space.getSimpleExtentNdims() == 2;
  if (matrix) space.getSimpleExtentDims(size.data());
  if (!matrix || size[1] != width) {
    throw BadInput(fmt::format("{} is not a table of {} columns", name, width));
  }
  if (dataset.getTypeClass() != type.getClass()) {
    throw BadInput(fmt::format("{} has values of another type", name));
  }
  if (size[0] > file_size / (width * type.getSize())) {
    throw BadInput(fmt::format("{} claims {} rows, more than the file holds", name, size[0]));
  }
  return size[0];
}

}  // namespace palpate::recording
