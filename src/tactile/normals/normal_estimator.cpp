// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/normals/normal_estimator.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "palpate/core/error.hpp"
#include "tactile/normals/plane_fit.hpp"
#include "tactile/normals/rls.hpp"
#include "tactile/normals/s2_filter.hpp"
#include "tactile/normals/s2_smoother.hpp"

namespace palpate::tactile {

std::string_view to_string(NormalStatus status) {
  switch (status) {
    case NormalStatus::none:
      return "none";
    case NormalStatus::tracked:
      return "tracked";
    case NormalStatus::held:
      return "held";
  }
  return "unknown";
}

const std::vector<std::string>& normal_estimators() {
  static const std::vector<std::string> names = {"rls",   "rls-literal", "tls",
                                                 "eigen", "s2",          "s2-lag"};
  return names;
}

std::unique_ptr<NormalEstimator> make_normal_estimator(std::string_view name) {
  if (name == "rls") return std::make_unique<RlsEstimator>();
  if (name == "rls-literal") {
    return std::make_unique<RlsEstimator>(RlsOptions{.literal = true, .gain = 1, .low_pass = 100});
  }
  if (name == "tls") return std::make_unique<PlaneFitEstimator>();
  if (name == "eigen") return std::make_unique<EigenvectorEstimator>();
  if (name == "s2") return std::make_unique<S2Filter>();
  if (name == "s2-lag") return std::make_unique<S2Smoother>();
  throw BadInput(fmt::format("no estimator is called '{}'; there are {}", name,
                             fmt::join(normal_estimators(), ", ")));
}

}  // namespace palpate::tactile
