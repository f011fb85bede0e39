// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "palpate/core/angle.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "tactile/biotac/folds.hpp"

namespace palpate::tactile {
namespace {

constexpr int kErrorFitSteps = 300;
constexpr double kStart = 1e-3;          // rad^2, of the error model's parts before the fit
constexpr double kChiSquared95 = 5.991;  // of two degrees of freedom

/// Of frames that were not learned from.
struct Residuals {
  std::vector<double> error_deg;
  std::vector<double> variance, pressure;  // of the Gaussian process, rad^2; counts
};

void add_residuals(const BiotacNormalModel& model, const std::vector<BiotacSample>& test,
                   Residuals& residuals) {
  std::vector<BiotacChannels> changes, rests;
  for (const BiotacSample& sample : test) {
    changes.push_back(sample.change);
    rests.push_back(sample.rest);
  }
  const auto predictions = model.predict(changes, rests);
  for (std::size_t i = 0; i < test.size(); ++i) {
    if (!predictions[i]) continue;
    residuals.error_deg.push_back(angle_between_deg(predictions[i]->n, test[i].n));
    residuals.variance.push_back(predictions[i]->variance);
    residuals.pressure.push_back(changes[i][0]);
  }
}

/// The most likely variances of Gaussian errors: each part is multiplied by the root of how much
/// larger the errors are where it matters than they should be (Fevotte, Bertin & Durrieu 2009, the
/// Itakura-Saito divergence), which never makes them less likely.
BiotacErrorModel fitted_errors(const Residuals& residuals) {
  const std::size_t count = residuals.error_deg.size();
  Eigen::MatrixXd parts(3, count);
  Eigen::VectorXd squares(count);
  const BiotacErrorModel floor{1, 0, 0}, unlearned{0, 1, 0}, light{0, 0, 1};
  for (std::size_t i = 0; i < count; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const auto part = [&](const BiotacErrorModel& one) {
      return one.variance(residuals.variance[i], residuals.pressure[i]);
    };
    parts.col(k) << part(floor), part(unlearned), part(light);
    squares[k] = std::pow(residuals.error_deg[i] * kDegree, 2) / 2;
  }
  Eigen::Vector3d weights(kStart, 1, kStart);
  for (int step = 0; step < kErrorFitSteps; ++step) {
    const Eigen::VectorXd variances = parts.transpose() * weights;
    const Eigen::VectorXd over = parts * squares.cwiseQuotient(variances.cwiseAbs2());
    weights =
        weights.cwiseProduct(over.cwiseQuotient(parts * variances.cwiseInverse()).cwiseSqrt());
  }
  // Few touches may all be alike, so that the process' own variance seems too large.
  return {weights[0], std::max(1.0, weights[1]), weights[2]};
}

}  // namespace

void BiotacNormalErrors::add(const BiotacNormalErrors& more) {
  error_deg.insert(error_deg.end(), more.error_deg.begin(), more.error_deg.end());
  normalised.insert(normalised.end(), more.normalised.begin(), more.normalised.end());
}

double BiotacNormalErrors::coverage_95() const {
  const auto within = std::count_if(normalised.begin(), normalised.end(),
                                    [](double square) { return square < kChiSquared95; });
  return static_cast<double>(within) / static_cast<double>(normalised.size());
}

BiotacNormalModel train_biotac_normal(const std::vector<BiotacLog>& logs,
                                      const BiotacNormalOptions& options, int folds) {
  std::vector<BiotacSample> samples;
  for (const BiotacLog& log : logs) {
    const auto more = biotac_samples(log);
    samples.insert(samples.end(), more.begin(), more.end());
  }
  auto model = BiotacNormalModel::train(samples, options);
  Residuals whole, causal;
  for (const BiotacFold& fold : folds_of_touches(logs, folds)) {
    if (fold.test.empty()) continue;
    const auto of_fold = BiotacNormalModel::train(fold.training, options);
    add_residuals(of_fold, fold.test, whole);
    add_residuals(of_fold, fold.test_causal, causal);
  }
  if (!whole.error_deg.empty()) model.set_errors(BiotacRest::whole_log, fitted_errors(whole));
  if (!causal.error_deg.empty()) model.set_errors(BiotacRest::causal, fitted_errors(causal));
  return model;
}

BiotacNormalErrors evaluate_biotac_normal(const BiotacNormalModel& model, const BiotacLog& log,
                                          BiotacRest tracking) {
  const auto normals = model.track(log, biotac_signals(log, tracking), tracking);
  BiotacNormalErrors errors;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    if (!normals[i] || !log.normals[i]) continue;
    errors.error_deg.push_back(angle_between_deg(normals[i]->n, *log.normals[i]));
    const double ratio = errors.error_deg.back() * kDegree / normals[i]->sigma;
    errors.normalised.push_back(ratio * ratio);
  }
  return errors;
}

std::vector<double> cross_validate_biotac_normal(const std::vector<BiotacLog>& logs,
                                                 const BiotacNormalOptions& options, int folds) {
  Residuals residuals;
  for (const BiotacFold& fold : folds_of_touches(logs, folds)) {
    add_residuals(BiotacNormalModel::train(fold.training, options), fold.test, residuals);
  }
  return residuals.error_deg;
}

}  // namespace palpate::tactile
