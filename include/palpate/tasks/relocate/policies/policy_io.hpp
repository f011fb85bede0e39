// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "palpate/tasks/relocate/policies/policy.hpp"

namespace palpate::relocate {

/// Writes a policy as JSON (format "palpate-policy", version 1), atomically. Numbers are written so
/// that they are read back exactly.
void save_policy(const std::filesystem::path& path, const PolicyRecord& record);

/// Reads what save_policy wrote, or the weights of a DexMV policy as JSON (W0, b0, ... , log_std),
/// distinguished by their keys.
/// @throws BadInput, naming the file and what is wrong: missing, not JSON, of another format,
///         version or task, an unknown or missing key, a value that is no finite number
PolicyRecord read_policy(const std::filesystem::path& path);

std::unique_ptr<Policy> load_policy(const std::filesystem::path& path);

}  // namespace palpate::relocate
