// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "inputs.hpp"

namespace palpate::fuzz {

/// Feeds a target under libFuzzer, which keeps what reaches code that no other input has reached,
/// in work/corpus, and goes on from there the next time. Does not return: the process ends.
[[noreturn]] void run_guided(const Target& target, const Budget& budget,
                             const std::filesystem::path& source,
                             const std::filesystem::path& work);

}  // namespace palpate::fuzz
