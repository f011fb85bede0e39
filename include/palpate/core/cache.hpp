// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

/// Fingerprint of some bytes as 32 hexadecimal digits: FNV-1a of 128 bits (Fowler, Noll & Vo, IETF
/// draft-eastlake-fnv). The same on every platform; not meant to withstand forgery.
std::string content_hash(std::string_view bytes);

/// The folder of what can be computed or fetched again, which may be deleted at any time:
/// $PALPATE_CACHE, else $XDG_CACHE_HOME/palpate, else ~/.cache/palpate; empty if the environment
/// names none.
std::filesystem::path cache_folder();

/// What write_cache() kept under the key in the cache_folder(), or nothing if that is missing or
/// damaged.
/// @param key  any bytes; should name what was computed, how, and a version of its format
std::optional<std::string> read_cache(std::string_view key);

/// Keeps bytes under a key, in place of what is there. Readers see all of them or nothing. Where no
/// file can be written, nothing happens: there is no cache then.
void write_cache(std::string_view key, std::string_view bytes);

}  // namespace palpate
