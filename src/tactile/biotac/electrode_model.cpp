// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "numerics/gaussian_process.hpp"
#include "palpate/core/array_file.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/tactile/biotac/electrodes.hpp"
#include "tactile/biotac/chosen_samples.hpp"

namespace palpate::tactile {
namespace {

constexpr const char* kElectrodeKind = "biotac-electrodes";
constexpr int kElectrodeVersion = 1;
constexpr int kElectrodeFeatures = 4;
constexpr double kElectrodeFlatPressure = 20;  // counts, that keep ratios small at light touch
constexpr double kSameSample = 1e-6;           // squared distance of standardised features
constexpr int kReweightings = 8;               // of reweighting
constexpr double kMinScale = 1e-3;             // of a residual of changes over the pressure
constexpr double kLightPressure = 60;  // counts, at which a change over the pressure is half noise

Eigen::Matrix<double, kElectrodeFeatures, 1> features(const Eigen::Vector3d& n, double pressure) {
  Eigen::Matrix<double, kElectrodeFeatures, 1> result;
  result << n, std::sqrt(pressure);
  return result;
}

/// Indices of at most `count` columns, each the farthest from those before it (Gonzalez 1985): the
/// rare touches are among them as well as the frequent ones. Ends where the others are the same.
std::vector<Eigen::Index> spread_out(const Eigen::MatrixXd& columns, int count) {
  Eigen::VectorXd distances =
      Eigen::VectorXd::Constant(columns.cols(), std::numeric_limits<double>::infinity());
  std::vector<Eigen::Index> chosen;
  for (Eigen::Index next = 0; std::ssize(chosen) < count && distances[next] > kSameSample;) {
    chosen.push_back(next);
    const Eigen::VectorXd from = (columns.colwise() - columns.col(next)).colwise().squaredNorm();
    distances = distances.cwiseMin(from);
    distances.maxCoeff(&next);
  }
  return chosen;
}

/// Centres and scales the features. @return of each row the mean, then the standard deviation
std::pair<Eigen::VectorXd, Eigen::VectorXd> standardise(Eigen::MatrixXd& features) {
  const Eigen::VectorXd mean = features.rowwise().mean();
  features.colwise() -= mean;
  const Eigen::VectorXd scale =
      (features.rowwise().squaredNorm() / static_cast<double>(features.cols()))
          .cwiseSqrt()
          .cwiseMax(1e-6);
  features = (features.array().colwise() / scale.array()).matrix();
  return {mean, scale};
}

Eigen::MatrixXd features_of(const std::vector<BiotacSample>& samples) {
  Eigen::MatrixXd result(kElectrodeFeatures, static_cast<Eigen::Index>(samples.size()));
  for (Eigen::Index i = 0; i < result.cols(); ++i) {
    const BiotacSample& sample = samples[static_cast<std::size_t>(i)];
    result.col(i) = features(sample.n, std::max(sample.change[0], 1.0));
  }
  return result;
}

/// Samples that cover all normals and pressures evenly.
std::vector<BiotacSample> covering_samples(const std::vector<BiotacSample>& samples, int count) {
  Eigen::MatrixXd all = features_of(samples);
  standardise(all);
  std::vector<BiotacSample> result;
  for (const Eigen::Index i : spread_out(all, count)) {
    result.push_back(samples[static_cast<std::size_t>(i)]);
  }
  return result;
}

/// Weights a of the kernel's columns with K a near the values, by least absolute residuals beyond
/// `outlier` times the median size of the values.
Eigen::VectorXd robust_weights(const Eigen::MatrixXd& K, const Eigen::VectorXd& noise,
                               const Eigen::VectorXd& values, double outlier) {
  const auto median_size = [](const Eigen::VectorXd& x) {
    const Eigen::VectorXd sizes = x.cwiseAbs();
    return median({sizes.begin(), sizes.end()});
  };
  const double scale = median_size(values) + kMinScale;
  Eigen::VectorXd inflation = Eigen::VectorXd::Ones(values.size()), weights;
  for (int iteration = 0; iteration < kReweightings; ++iteration) {
    Eigen::MatrixXd noisy = K;
    noisy.diagonal() += noise.cwiseProduct(inflation);
    weights = noisy.llt().solve(values);
    inflation = ((values - K * weights).cwiseAbs() / (outlier * scale)).cwiseMax(1.0);
  }
  return weights;
}

}  // namespace

std::vector<BiotacSample> chosen_samples(std::vector<BiotacSample> samples, int count,
                                         std::uint64_t seed) {
  RandomStream random(seed, "biotac-samples");
  const std::size_t kept = std::min(samples.size(), static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < kept; ++i) {
    std::swap(samples[i], samples[i + random.index(samples.size() - i)]);
  }
  samples.resize(kept);
  return samples;
}

ElectrodeModel ElectrodeModel::train(const std::vector<BiotacSample>& samples,
                                     const ElectrodeModelOptions& options) {
  if (samples.size() < 10) {
    throw BadInput(
        fmt::format("{} samples of contact are too few to learn electrodes from; at "
                    "least 10 are needed",
                    samples.size()));
  }
  const auto learned = covering_samples(samples, options.centres);
  const auto count = static_cast<Eigen::Index>(learned.size());
  ElectrodeModel model;
  model.length_ = options.length;
  model.linear_ = options.linear;
  model.centres_ = features_of(learned);
  std::tie(model.mean_, model.scale_) = standardise(model.centres_);
  Eigen::MatrixXd changes(kElectrodes, count);
  Eigen::VectorXd noise(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const BiotacSample& sample = learned[static_cast<std::size_t>(i)];
    const double pressure = std::max(sample.change[0], 1.0);
    changes.col(i) = sample.change.tail<kElectrodes>() / (pressure + kElectrodeFlatPressure);
    const double light = kLightPressure / std::max(pressure, kElectrodeFlatPressure);
    noise[i] = options.noise * (1 + light * light);
  }
  const Eigen::MatrixXd K =
      numerics::kernel(model.centres_, model.centres_, options.length, options.linear);
  model.weights_.resize(kElectrodes, count);
  for (int e = 0; e < kElectrodes; ++e) {
    const Eigen::VectorXd values = changes.row(e);
    model.mean_change_[e] = median({values.begin(), values.end()});
    model.weights_.row(e) = robust_weights(
        K, noise, (values.array() - model.mean_change_[e]).matrix(), options.outlier);
  }
  return model;
}

ElectrodeChanges ElectrodeModel::operator()(const Eigen::Vector3d& n, double pressure) const {
  if (!n.allFinite() || !(pressure > 0) || !std::isfinite(pressure)) {
    throw BadInput(fmt::format("a contact with the normal {}, {}, {} and a pressure of {} counts",
                               n.x(), n.y(), n.z(), pressure));
  }
  const Eigen::MatrixXd x = ((features(n, pressure) - mean_).array() / scale_.array()).matrix();
  const Eigen::MatrixXd k = numerics::kernel(centres_, x, length_, linear_);
  return (mean_change_ + weights_ * k.col(0)) * (pressure + kElectrodeFlatPressure);
}

std::string ElectrodeModel::bytes() const {
  ArrayFile file(kElectrodeKind, kElectrodeVersion);
  file.add("settings", Eigen::Vector2d(length_, linear_).cast<float>());
  file.add("mean", mean_.cast<float>());
  file.add("scale", scale_.cast<float>());
  file.add("mean_change", mean_change_.cast<float>());
  file.add("centres", centres_.cast<float>());
  file.add("weights", weights_.cast<float>());
  return file.bytes();
}

ElectrodeModel ElectrodeModel::parse(std::string_view bytes, const std::string& source) {
  const auto file = ArrayFile::parse(bytes, source, kElectrodeKind, kElectrodeVersion);
  ElectrodeModel model;
  const Eigen::VectorXd settings = file.get("settings", 2, 1).cast<double>();
  model.length_ = settings[0];
  model.linear_ = settings[1];
  model.mean_ = file.get("mean", kElectrodeFeatures, 1).cast<double>();
  model.scale_ = file.get("scale", kElectrodeFeatures, 1).cast<double>();
  model.mean_change_ = file.get("mean_change", kElectrodes, 1).cast<double>();
  model.centres_ = file.get("centres", kElectrodeFeatures).cast<double>();
  model.weights_ = file.get("weights", kElectrodes, model.centres_.cols()).cast<double>();
  if (model.length_ <= 0 || model.linear_ < 0 || model.scale_.minCoeff() <= 0) {
    throw BadInput(fmt::format("{}: a scale of the model is not positive", source));
  }
  return model;
}

}  // namespace palpate::tactile
