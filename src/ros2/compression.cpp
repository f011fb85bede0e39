// SPDX-License-Identifier: Apache-2.0
#include "ros2/compression.hpp"

#include <fmt/format.h>

#include <memory>

#ifdef PALPATE_ZSTD
#include <zstd.h>
#endif
#ifdef PALPATE_LZ4
#include <lz4frame.h>
#endif

#include "palpate/core/error.hpp"

namespace palpate::ros2 {
namespace {

#ifdef PALPATE_ZSTD
std::string from_zstd(std::string_view bytes, std::uint64_t size) {
  std::string plain(size, '\0');
  const std::size_t made = ZSTD_decompress(plain.data(), size, bytes.data(), bytes.size());
  if (ZSTD_isError(made) != 0) throw BadInput(fmt::format("zstd: {}", ZSTD_getErrorName(made)));
  plain.resize(made);
  return plain;
}
#endif

#ifdef PALPATE_LZ4
std::string from_lz4(std::string_view bytes, std::uint64_t size) {
  LZ4F_dctx* made = nullptr;
  LZ4F_createDecompressionContext(&made, LZ4F_VERSION);
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      made, &LZ4F_freeDecompressionContext);
  std::string plain(size, '\0');
  std::size_t out = 0;
  while (!bytes.empty()) {
    std::size_t room = size - out, taken = bytes.size();
    const std::size_t left =
        LZ4F_decompress(context.get(), plain.data() + out, &room, bytes.data(), &taken, nullptr);
    if (LZ4F_isError(left) != 0) throw BadInput(fmt::format("lz4: {}", LZ4F_getErrorName(left)));
    out += room;
    bytes.remove_prefix(taken);
    if (left == 0 || (room == 0 && taken == 0)) break;
  }
  plain.resize(out);
  return plain;
}
#endif

[[noreturn]] void refuse(std::string_view compression) {
  throw BadInput(fmt::format(
      "chunks compressed with {:?}: `mcap decompress IN -o OUT` makes a file that can be read",
      compression));
}

}  // namespace

std::string_view compression() {
#ifdef PALPATE_ZSTD
  return "zstd";
#else
  return "";
#endif
}

std::string compressed(std::string_view bytes) {
#ifdef PALPATE_ZSTD
  constexpr int kLevel = 3;
  std::string made(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t size =
      ZSTD_compress(made.data(), made.size(), bytes.data(), bytes.size(), kLevel);
  if (ZSTD_isError(size) != 0) throw BadInput(fmt::format("zstd: {}", ZSTD_getErrorName(size)));
  made.resize(size);
  return made;
#else
  return std::string(bytes);
#endif
}

std::string decompressed(std::string_view bytes, std::string_view compression, std::uint64_t size) {
  std::string plain;
  if (compression.empty()) {
    plain = bytes;
#ifdef PALPATE_ZSTD
  } else if (compression == "zstd") {
    plain = from_zstd(bytes, size);
#endif
#ifdef PALPATE_LZ4
  } else if (compression == "lz4") {
    plain = from_lz4(bytes, size);
#endif
  } else {
    refuse(compression);
  }
  if (plain.size() != size) {
    throw BadInput(fmt::format("a chunk of {} bytes, not of {}", plain.size(), size));
  }
  return plain;
}

}  // namespace palpate::ros2
