// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "chosen_samples.hpp"
#include "gaussian_process.hpp"
#include "palpate/core/array_file.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/touch/biotac_electrodes.hpp"

namespace palpate::touch {
namespace {

constexpr const char* kKind = "biotac-electrodes";
constexpr int kVersion = 1;
constexpr int kFeatures = 4;
constexpr double kFlatPressure = 20;   // counts, that keep ratios small at light touch
constexpr double kLightPressure = 60;  // counts, at which a change over the pressure is half noise

Eigen::Matrix<double, kFeatures, 1> features(const Eigen::Vector3d& n, double pressure) {
  Eigen::Matrix<double, kFeatures, 1> result;
  result << n, std::sqrt(pressure);
  return result;
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
  const auto learned = chosen_samples(samples, options.centres, options.seed);
  const auto count = static_cast<Eigen::Index>(learned.size());
  ElectrodeModel model;
  model.length_ = options.length;
  model.linear_ = options.linear;
  model.centres_.resize(kFeatures, count);
  Eigen::MatrixXd changes(kElectrodes, count);
  Eigen::VectorXd noise(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const BiotacSample& sample = learned[static_cast<std::size_t>(i)];
    const double pressure = std::max(sample.change[0], 1.0);
    model.centres_.col(i) = features(sample.n, pressure);
    changes.col(i) = sample.change.tail<kElectrodes>() / (pressure + kFlatPressure);
    const double light = kLightPressure / std::max(pressure, kFlatPressure);
    noise[i] = options.noise * (1 + light * light);
  }
  model.mean_ = model.centres_.rowwise().mean();
  model.centres_.colwise() -= model.mean_;
  model.scale_ = (model.centres_.rowwise().squaredNorm() / static_cast<double>(count))
                     .cwiseSqrt()
                     .cwiseMax(1e-6);
  model.centres_ = (model.centres_.array().colwise() / model.scale_.array()).matrix();
  model.mean_change_ = changes.rowwise().mean();
  changes.colwise() -= Eigen::VectorXd(model.mean_change_);
  Eigen::MatrixXd K = kernel(model.centres_, model.centres_, options.length, options.linear);
  K.diagonal() += noise;
  model.weights_ = K.llt().solve(changes.transpose()).transpose();
  return model;
}

ElectrodeChanges ElectrodeModel::operator()(const Eigen::Vector3d& n, double pressure) const {
  if (!n.allFinite() || !(pressure > 0) || !std::isfinite(pressure)) {
    throw BadInput(fmt::format("a contact with the normal {}, {}, {} and a pressure of {} counts",
                               n.x(), n.y(), n.z(), pressure));
  }
  const Eigen::MatrixXd x = ((features(n, pressure) - mean_).array() / scale_.array()).matrix();
  const Eigen::MatrixXd k = kernel(centres_, x, length_, linear_);
  return (mean_change_ + weights_ * k.col(0)) * (pressure + kFlatPressure);
}

std::string ElectrodeModel::bytes() const {
  ArrayFile file(kKind, kVersion);
  file.add("settings", Eigen::Vector2d(length_, linear_).cast<float>());
  file.add("mean", mean_.cast<float>());
  file.add("scale", scale_.cast<float>());
  file.add("mean_change", mean_change_.cast<float>());
  file.add("centres", centres_.cast<float>());
  file.add("weights", weights_.cast<float>());
  return file.bytes();
}

ElectrodeModel ElectrodeModel::parse(std::string_view bytes, const std::string& source) {
  const auto file = ArrayFile::parse(bytes, source, kKind, kVersion);
  ElectrodeModel model;
  const Eigen::VectorXd settings = file.get("settings", 2, 1).cast<double>();
  model.length_ = settings[0];
  model.linear_ = settings[1];
  model.mean_ = file.get("mean", kFeatures, 1).cast<double>();
  model.scale_ = file.get("scale", kFeatures, 1).cast<double>();
  model.mean_change_ = file.get("mean_change", kElectrodes, 1).cast<double>();
  model.centres_ = file.get("centres", kFeatures).cast<double>();
  model.weights_ = file.get("weights", kElectrodes, model.centres_.cols()).cast<double>();
  if (model.length_ <= 0 || model.linear_ < 0 || model.scale_.minCoeff() <= 0) {
    throw BadInput(fmt::format("{}: a scale of the model is not positive", source));
  }
  return model;
}

}  // namespace palpate::touch
