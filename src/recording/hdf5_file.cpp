// SPDX-License-Identifier: Apache-2.0
#include "recording/hdf5_file.hpp"

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

void create_growing(H5::Group& parent, const std::string& name, const H5::DataType& type,
                    hsize_t width, hsize_t rows_per_chunk) {
  const std::array<hsize_t, 2> size = {0, width}, most = {H5S_UNLIMITED, width};
  const std::array<hsize_t, 2> chunk = {rows_per_chunk, width};
  H5::DSetCreatPropList properties;
  properties.setChunk(2, chunk.data());
  properties.setFletcher32();
  parent.createDataSet(name, type, H5::DataSpace(2, size.data(), most.data()), properties);
}

void append_rows(H5::DataSet& dataset, const void* values, hsize_t rows, hsize_t width,
                 const H5::DataType& memory_type) {
  if (rows == 0) return;
  std::array<hsize_t, 2> size{};
  dataset.getSpace().getSimpleExtentDims(size.data());
  const std::array<hsize_t, 2> offset = {size[0], 0}, block = {rows, width};
  size[0] += rows;
  dataset.extend(size.data());
  H5::DataSpace file_space = dataset.getSpace();
  file_space.selectHyperslab(H5S_SELECT_SET, block.data(), offset.data());
  dataset.write(values, memory_type, H5::DataSpace(2, block.data()), file_space);
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
