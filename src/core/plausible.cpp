// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/plausible.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

#include "palpate/core/error.hpp"

namespace palpate {

double plausible(double value, double low, double high, std::string_view what) {
  if (value >= low && value <= high) return value;
  throw BadInput(fmt::format("{} of {} is not in {}..{}", what, value, low, high));
}

void check_plausible(const Eigen::Ref<const Eigen::VectorXd>& v, double most, std::string_view what,
                     bool may_miss) {
  for (const double value : v) {
    if (may_miss && std::isnan(value)) continue;
    plausible(value, -most, most, what);
  }
}

const Eigen::Matrix3d& rigid(const Eigen::Matrix3d& R, std::string_view what) {
  constexpr double kRounding = 1e-6;
  const double off = (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (off <= kRounding && R.determinant() > 0) return R;
  throw BadInput(
      fmt::format("{} is no rotation R: R R' differs from the identity by {:.3g}, and the "
                  "determinant is {:.3g}",
                  what, off, R.determinant()));
}

}  // namespace palpate
