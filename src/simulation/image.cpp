// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/image.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <string>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::simulation {

void save_png(const std::filesystem::path& path, const Image& image) {
  const auto bytes = 3 * static_cast<std::size_t>(std::max(0, image.width)) *
                     static_cast<std::size_t>(std::max(0, image.height));
  if (bytes == 0 || image.rgb.size() != bytes) {
    throw BadInput(fmt::format("a picture of {} x {} pixels cannot have {} bytes", image.width,
                               image.height, image.rgb.size()));
  }
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string png(size, '\0');
  if (!png_image_write_to_memory(&header, png.data(), &size, 0, image.rgb.data(), 0, nullptr)) {
    throw BadInput(fmt::format("cannot encode {}: {}", path.string(), header.message));
  }
  png.resize(size);
  write_file_atomically(path, png);
}

}  // namespace palpate::simulation
