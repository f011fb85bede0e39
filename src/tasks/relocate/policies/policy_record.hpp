// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "palpate/tasks/relocate/policies/policy.hpp"

namespace palpate::relocate {

std::vector<double> to_array(const Eigen::VectorXd& values);

/// Units of a network's layers, that a file holds as plain numbers.
/// @throws BadInput unless all are whole numbers from 1 to a million
std::vector<int> layer_sizes(const Eigen::VectorXd& numbers);

/// The array of that name. @throws BadInput if the record lacks it
Eigen::VectorXd array(const PolicyRecord& record, const std::string& name);

/// @throws BadInput unless the record holds exactly the arrays of these names
void check_arrays(const PolicyRecord& record, const std::vector<std::string>& names);

}  // namespace palpate::relocate
