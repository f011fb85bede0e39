// SPDX-License-Identifier: Apache-2.0
#include "palpate/simulation/rendering/image.hpp"

#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <string>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "simulation/rendering/animated_gif.hpp"
#include "simulation/rendering/animated_png.hpp"

namespace palpate::simulation {
namespace {

void check_size(const Image& image) {
  const auto bytes = 3 * static_cast<std::size_t>(std::max(0, image.width)) *
                     static_cast<std::size_t>(std::max(0, image.height));
  if (bytes > 0 && image.rgb.size() == bytes) return;
  throw BadInput(fmt::format("a picture of {} x {} pixels cannot have {} bytes", image.width,
                             image.height, image.rgb.size()));
}

}  // namespace

std::string encode_png(const Image& image) {
  png_image header{};
  header.version = PNG_IMAGE_VERSION;
  header.width = static_cast<png_uint_32>(image.width);
  header.height = static_cast<png_uint_32>(image.height);
  header.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(header);
  std::string png(size, '\0');
  if (!png_image_write_to_memory(&header, png.data(), &size, 0, image.rgb.data(), 0, nullptr)) {
    throw BadInput(fmt::format("cannot encode a picture of {} x {} pixels: {}", image.width,
                               image.height, header.message));
  }
  png.resize(size);
  return png;
}

void save_png(const std::filesystem::path& path, const Image& image) {
  check_size(image);
  write_file_atomically(path, encode_png(image));
}

void save_animation(const std::filesystem::path& path, const std::vector<Image>& images,
                    double seconds) {
  if (images.empty()) throw BadInput("an animation of 0 pictures");
  if (!(seconds >= 1e-3 && seconds <= 60)) {
    throw BadInput(fmt::format("pictures that stay for {} s; 0.001 to 60 s are possible", seconds));
  }
  for (const Image& image : images) {
    check_size(image);
    if (image.width == images[0].width && image.height == images[0].height) continue;
    throw BadInput(fmt::format("an animation of pictures of {} x {} and {} x {} pixels",
                               images[0].width, images[0].height, image.width, image.height));
  }
  const bool gif = path.extension() == ".gif";
  write_file_atomically(path,
                        gif ? encode_gif(images, seconds) : encode_animation(images, seconds));
}

}  // namespace palpate::simulation
