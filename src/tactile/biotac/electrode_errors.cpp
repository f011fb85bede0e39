// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/error.hpp"
#include "palpate/tactile/biotac/electrodes.hpp"
#include "tactile/biotac/chosen_samples.hpp"
#include "tactile/biotac/folds.hpp"

namespace palpate::tactile {
namespace {

/// Sums of the absolute errors of each electrode.
struct ErrorSums {
  ElectrodeChanges fit = ElectrodeChanges::Zero(), model = ElectrodeChanges::Zero();
};

void add_errors(const BiotacFold& fold, const ElectrodeFitOptions& fit_options,
                const ElectrodeModelOptions& model_options, ErrorSums& sums) {
  const Eigen::MatrixXd fitted = fit_electrodes(fold.training, fit_options).changes(fold.test);
  const auto model = ElectrodeModel::train(fold.training, model_options);
  for (std::size_t i = 0; i < fold.test.size(); ++i) {
    const BiotacSample& sample = fold.test[i];
    const auto truth = sample.change.tail<kElectrodes>();
    sums.fit += (fitted.col(static_cast<Eigen::Index>(i)) - truth).cwiseAbs();
    sums.model += (model(sample.n, sample.change[0]) - truth).cwiseAbs();
  }
}

ElectrodeErrors errors_of(const ErrorSums& sums, const std::vector<BiotacSample>& test) {
  const ElectrodeChanges scale = electrode_deviation(test) * static_cast<double>(test.size());
  return {.fit = sums.fit.cwiseQuotient(scale), .model = sums.model.cwiseQuotient(scale)};
}

}  // namespace

ElectrodeErrors evaluate_electrodes(const std::vector<BiotacSample>& training,
                                    const std::vector<BiotacSample>& test,
                                    const ElectrodeFitOptions& fit,
                                    const ElectrodeModelOptions& model) {
  if (test.empty())
    throw BadInput("there are no samples in contact with which to evaluate electrodes");
  ErrorSums sums;
  add_errors({training, test}, fit, model, sums);
  return errors_of(sums, test);
}

std::optional<ElectrodeErrors> cross_validate_electrodes(const std::vector<BiotacLog>& logs,
                                                         const ElectrodeFitOptions& fit,
                                                         const ElectrodeModelOptions& model,
                                                         int folds) {
  ErrorSums sums;
  std::vector<BiotacSample> test;
  for (const auto& fold : folds_of_touches(logs, folds)) {
    if (fold.test.empty()) continue;
    add_errors(fold, fit, model, sums);
    test.insert(test.end(), fold.test.begin(), fold.test.end());
  }
  if (test.empty()) return std::nullopt;
  return errors_of(sums, test);
}

}  // namespace palpate::tactile
