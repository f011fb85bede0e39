// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace palpate::app {

/// Commit that the program was built from, "-dirty" if its files were changed; or "unknown".
std::string_view commit();

/// What made a result: program_version, commit, and machine {name, system, processor, cores}.
nlohmann::json manifest();

}  // namespace palpate::app
