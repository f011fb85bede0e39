// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace palpate::app {

/// Of no trials, null.
nlohmann::json rate(std::size_t count, std::size_t trials);

/// "0.90 [0.70, 0.97]", with the 95 % Wilson interval; of no trials, "-".
std::string rate_text(std::size_t count, std::size_t trials);

/// One digit; of no values, "-".
std::string median_text(const std::vector<double>& values);

/// "lift 2, track 1"; of no counts, "-".
std::string counts_text(const std::map<std::string, std::size_t>& counts);

/// Median and 95 % quantile; of no values, null.
nlohmann::json quantiles_json(const std::vector<double>& values);

}  // namespace palpate::app
