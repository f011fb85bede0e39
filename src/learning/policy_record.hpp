// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "palpate/learning/policy.hpp"

namespace palpate::learning {

std::vector<double> to_array(const Eigen::VectorXd& values);

/// The array of that name. @throws BadInput if the record lacks it
Eigen::VectorXd array(const PolicyRecord& record, const std::string& name);

/// @throws BadInput unless the record holds exactly the arrays of these names
void check_arrays(const PolicyRecord& record, const std::vector<std::string>& names);

}  // namespace palpate::learning
