// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/normal.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "numerics/gaussian_process.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/array_file.hpp"
#include "palpate/core/error.hpp"

namespace palpate::tactile {
namespace {

constexpr const char* kNormalKind = "biotac-normal";
constexpr int kNormalVersion = 2;
constexpr int kNormalFeatures = 1 + kElectrodes + kBiotacChannels + kElectrodes;
constexpr int kSettings = 8;
constexpr std::size_t kBatch = 256;  // frames that are predicted at once
constexpr double kMinPressure = 5;   // counts, below which the logarithm is cut
constexpr double kFlatShare = 20;    // that keeps shares small where nothing changes
constexpr double kLargeChange = 100, kSmallChange = 20;  // scales, plain and compressed
constexpr double kLightPressure = 50;  // counts, at which a frame's noise is twice as large
constexpr double kLowest = 5, kHighest = 4090;  // counts of an electrode, so that none divides by 0
constexpr double kMinSpread = 0.3;  // of normals that a finger meets, however few it learned from
constexpr double kMinVariance = 1e-6;  // rad^2, so that no frame settles all others
constexpr double kConductance = 100;   // scale that makes the changes as large as in counts

/// Index of the electrode opposite to each at the finger's middle plane (y = 0).
constexpr std::array<int, kElectrodes> kMirrored = {10, 11, 12, 13, 14, 15, 6,  8,  7, 9,
                                                    0,  1,  2,  3,  4,  5,  16, 17, 18};

using ElectrodeValues = Eigen::Array<double, kElectrodes, 1>;

/// Conductances from the electrodes through the fluid, in those of the reference resistor: the
/// voltage divider reads 4095 R_ref / (R_ref + R), less where the skin presses the fluid thinner.
ElectrodeValues conductances(const ElectrodeValues& counts) {
  const ElectrodeValues bounded = counts.max(kLowest).min(kHighest);
  return bounded / (hand::kBiotacFullScale - bounded);
}

Eigen::VectorXd features(const BiotacChannels& change, const BiotacChannels& rest) {
  const ElectrodeValues at_rest = rest.tail<kElectrodes>().array();
  const ElectrodeValues now = at_rest + change.tail<kElectrodes>().array();
  const ElectrodeValues x = kConductance * (conductances(now) - conductances(at_rest));
  Eigen::VectorXd result(kNormalFeatures);
  result[0] = std::log(std::max(change[0], kMinPressure));
  result.segment<kElectrodes>(1) = kElectrodes * x / (x.abs().sum() + kFlatShare);
  result[1 + kElectrodes] = change[0] / kLargeChange;
  result.segment<kElectrodes>(2 + kElectrodes) = x / kLargeChange;
  result.tail<kElectrodes>() = (x / kSmallChange).asinh();
  return result;
}

BiotacChannels mirrored(const BiotacChannels& channels) {
  BiotacChannels result = channels;
  for (int e = 0; e < kElectrodes; ++e) {
    result[1 + e] = channels[1 + kMirrored[static_cast<std::size_t>(e)]];
  }
  return result;
}

/// At most `count` samples, spread evenly through the samples' order, with mirror images.
std::vector<BiotacSample> chosen(const std::vector<BiotacSample>& samples,
                                 const BiotacNormalOptions& options) {
  const auto most =
      static_cast<std::size_t>(options.mirror ? options.centres / 2 : options.centres);
  const std::size_t count = std::min(samples.size(), most);
  std::vector<BiotacSample> result;
  for (std::size_t i = 0; i < count; ++i) {
    const BiotacSample& sample = samples[i * samples.size() / count];
    result.push_back(sample);
    if (!options.mirror) continue;
    result.push_back(mirrored(sample));
  }
  return result;
}

/// Of noise in counts, relative to that of a firm touch.
double noise_of(double pressure) {
  const double light = kLightPressure / std::max(pressure, kMinPressure);
  return 1 + light * light;
}

}  // namespace

BiotacSample mirrored(const BiotacSample& sample) {
  return {.change = mirrored(sample.change),
          .n = {sample.n.x(), -sample.n.y(), sample.n.z()},
          .rest = mirrored(sample.rest)};
}

double angle_between_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) / kDegree;
}

double BiotacErrorModel::variance(double unlearned_variance, double pressure) const {
  const double weight = kLightPressure / std::max(pressure, kMinPressure);
  return std::max(kMinVariance, floor + unlearned * unlearned_variance + light * weight * weight);
}

std::vector<BiotacSample> biotac_samples(const BiotacLog& log) {
  const BiotacSignals signals = biotac_signals(log);
  std::vector<BiotacSample> samples;
  for (std::size_t i = 0; i < log.time.size(); ++i) {
    if (!log.normals[i] || !biotac_usable(signals.flags[i])) continue;
    samples.push_back({signals.changes[i], *log.normals[i], signals.rests[i]});
  }
  return samples;
}

BiotacNormalModel BiotacNormalModel::train(const std::vector<BiotacSample>& samples,
                                           const BiotacNormalOptions& options) {
  if (samples.size() < 10) {
    throw BadInput(
        fmt::format("{} samples of contact with a known normal are too few to learn "
                    "from; at least 10 are needed",
                    samples.size()));
  }
  const auto learned = chosen(samples, options);
  const auto count = static_cast<Eigen::Index>(learned.size());
  BiotacNormalModel model;
  model.centres_.resize(kNormalFeatures, count);
  model.noise_.resize(count);
  Eigen::MatrixXd normals(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const BiotacSample& sample = learned[static_cast<std::size_t>(i)];
    model.centres_.col(i) = features(sample.change, sample.rest);
    model.noise_[i] = options.noise * noise_of(sample.change[0]);
    normals.row(i) = sample.n;
  }
  model.mean_ = model.centres_.rowwise().mean();
  model.centres_.colwise() -= model.mean_;
  model.scale_ = (model.centres_.rowwise().squaredNorm() / static_cast<double>(count)).cwiseSqrt();
  model.scale_ = model.scale_.cwiseMax(1e-6);
  model.centres_ = (model.centres_.array().colwise() / model.scale_.array()).matrix();
  model.mean_normal_ = normals.colwise().mean();
  model.length_ = options.length;
  model.linear_ = options.linear;
  model.session_ = options.session * kDegree;
  model.turning_ = options.turning * kDegree;
  const Eigen::MatrixXd deviations = normals.rowwise() - model.mean_normal_.transpose();
  model.spread_ =
      std::max(kMinSpread, std::sqrt(deviations.squaredNorm() / static_cast<double>(3 * count)));
  model.prepare();
  model.weights_ = model.factor_.solve(deviations);
  return model;
}

void BiotacNormalModel::prepare() {
  Eigen::MatrixXd K = numerics::kernel(centres_, centres_, length_, linear_);
  K.diagonal() += noise_;
  factor_.compute(K);
}

std::vector<BiotacNormalModel::Prediction> BiotacNormalModel::predict(
    const Eigen::MatrixXd& features) const {
  const Eigen::MatrixXd x =
      ((features.colwise() - mean_).array().colwise() / scale_.array()).matrix();
  const Eigen::MatrixXd k = numerics::kernel(centres_, x, length_, linear_);
  const Eigen::MatrixXd normals = (weights_.transpose() * k).colwise() + mean_normal_;
  const Eigen::MatrixXd explained = factor_.matrixL().solve(k);
  std::vector<Prediction> result;
  for (Eigen::Index i = 0; i < x.cols(); ++i) {
    const double prior = numerics::kernel(x.col(i), x.col(i), length_, linear_)(0, 0);
    const double left = std::max(0.0, prior - explained.col(i).squaredNorm());
    result.push_back({.n = normals.col(i).stableNormalized(),
                      .variance = spread_ * spread_ * left,
                      .novelty = std::min(1.0, left)});
  }
  return result;
}

std::vector<std::optional<BiotacNormalModel::Prediction>> BiotacNormalModel::predict(
    const std::vector<BiotacChannels>& changes, const std::vector<BiotacChannels>& rests) const {
  if (changes.size() != rests.size()) {
    throw BadInput(fmt::format("{} changes and {} rests", changes.size(), rests.size()));
  }
  std::vector<std::optional<Prediction>> result(changes.size());
  for (std::size_t next = 0; next < changes.size();) {
    std::vector<std::size_t> batch;
    for (; next < changes.size() && batch.size() < kBatch; ++next) {
      const bool usable =
          changes[next].allFinite() && rests[next].allFinite() && changes[next][0] > 0;
      if (usable) batch.push_back(next);
    }
    if (batch.empty()) continue;
    Eigen::MatrixXd inputs(kNormalFeatures, std::ssize(batch));
    for (std::size_t k = 0; k < batch.size(); ++k) {
      inputs.col(static_cast<Eigen::Index>(k)) = features(changes[batch[k]], rests[batch[k]]);
    }
    const auto predictions = predict(inputs);
    for (std::size_t k = 0; k < batch.size(); ++k) result[batch[k]] = predictions[k];
  }
  return result;
}

std::optional<BiotacNormal> BiotacNormalModel::estimate(const BiotacChannels& change,
                                                        const BiotacChannels& rest,
                                                        BiotacRest tracking) const {
  const auto found = predict(std::vector{change}, std::vector{rest}).front();
  if (!found) return std::nullopt;
  const double variance = errors(tracking).variance(found->variance, change[0]);
  return BiotacNormal{
      .n = found->n, .sigma = std::sqrt(variance + session_ * session_), .novelty = found->novelty};
}

std::string BiotacNormalModel::bytes() const {
  ArrayFile file(kNormalKind, kNormalVersion);
  Eigen::VectorXd settings(kSettings);
  settings << mean_normal_, length_, linear_, spread_, session_, turning_;
  file.add("settings", settings.cast<float>());
  Eigen::Matrix<double, 3, 2> errors;
  for (Eigen::Index i = 0; i < errors.cols(); ++i) {
    const auto& of = errors_[static_cast<std::size_t>(i)];
    errors.col(i) << of.floor, of.unlearned, of.light;
  }
  file.add("errors", errors.cast<float>());
  file.add("mean", mean_.cast<float>());
  file.add("scale", scale_.cast<float>());
  file.add("noise", noise_.cast<float>());
  file.add("centres", centres_.cast<float>());
  file.add("weights", weights_.cast<float>());
  return file.bytes();
}

BiotacNormalModel BiotacNormalModel::parse(std::string_view bytes, const std::string& source) {
  const auto file = ArrayFile::parse(bytes, source, kNormalKind, kNormalVersion);
  BiotacNormalModel model;
  const Eigen::VectorXd settings = file.get("settings", kSettings, 1).cast<double>();
  model.mean_normal_ = settings.head<3>();
  model.length_ = settings[3];
  model.linear_ = settings[4];
  model.spread_ = settings[5];
  model.session_ = settings[6];
  model.turning_ = settings[7];
  const Eigen::MatrixXd errors = file.get("errors", 3, 2).cast<double>();
  for (Eigen::Index i = 0; i < errors.cols(); ++i) {
    model.errors_[static_cast<std::size_t>(i)] = {errors(0, i), errors(1, i), errors(2, i)};
  }
  model.mean_ = file.get("mean", kNormalFeatures, 1).cast<double>();
  model.scale_ = file.get("scale", kNormalFeatures, 1).cast<double>();
  model.centres_ = file.get("centres", kNormalFeatures).cast<double>();
  model.noise_ = file.get("noise", model.centres_.cols(), 1).cast<double>();
  model.weights_ = file.get("weights", model.centres_.cols(), 3).cast<double>();
  if (settings.tail<5>().minCoeff() < 0 || model.length_ <= 0 || model.noise_.minCoeff() <= 0 ||
      model.scale_.minCoeff() <= 0 || errors.minCoeff() < 0) {
    throw BadInput(fmt::format("{}: a scale of the model is not positive", source));
  }
  model.prepare();
  return model;
}

}  // namespace palpate::tactile
