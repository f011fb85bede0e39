// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/normal.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "numerics/gaussian_process.hpp"
#include "palpate/core/array_file.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/statistics.hpp"
#include "tactile/biotac/folds.hpp"

namespace palpate::tactile {
namespace {

constexpr const char* kNormalKind = "biotac-normal";
constexpr int kNormalVersion = 1;
constexpr int kNormalFeatures = 1 + kElectrodes + kBiotacChannels;
constexpr double kMinPressure = 5;  // counts, below which the logarithm is cut
constexpr double kFlatShare = 20;   // counts, that keep shares small where nothing changes
constexpr double kMinSigma = 0.02;  // rad

/// Index of the electrode opposite to each at the finger's middle plane (y = 0).
constexpr std::array<int, kElectrodes> kMirrored = {10, 11, 12, 13, 14, 15, 6,  8,  7, 9,
                                                    0,  1,  2,  3,  4,  5,  16, 17, 18};

Eigen::VectorXd features(const BiotacChannels& change) {
  const auto electrodes = change.tail<kElectrodes>();
  Eigen::VectorXd result(kNormalFeatures);
  result[0] = std::log(std::max(change[0], kMinPressure));
  result.segment<kElectrodes>(1) =
      kElectrodes * electrodes / (electrodes.cwiseAbs().sum() + kFlatShare);
  result.tail<kBiotacChannels>() = change / 100;
  return result;
}

BiotacSample mirrored(const BiotacSample& sample) {
  BiotacSample result = sample;
  result.n.y() = -sample.n.y();
  for (int e = 0; e < kElectrodes; ++e) {
    result.change[1 + e] = sample.change[1 + kMirrored[static_cast<std::size_t>(e)]];
  }
  return result;
}

/// Of the samples (and their mirror images) at most `count`, chosen at random.
std::vector<BiotacSample> chosen(const std::vector<BiotacSample>& samples,
                                 const BiotacNormalOptions& options) {
  auto all = samples;
  if (options.mirror) {
    for (const auto& sample : samples) all.push_back(mirrored(sample));
  }
  RandomStream random(options.seed, "biotac-normal");
  const std::size_t count = std::min(all.size(), static_cast<std::size_t>(options.centres));
  for (std::size_t i = 0; i < count; ++i) {
    std::swap(all[i], all[i + random.index(all.size() - i)]);
  }
  all.resize(count);
  return all;
}

/// Standard deviation per tangent axis (rad) of leave-one-out errors would be optimistic for
/// frames of one touch; the floor below is that of the training's own residuals, robustly.
double residual_of(const Eigen::MatrixXd& predicted, const Eigen::MatrixXd& normals) {
  std::vector<double> angles;
  for (Eigen::Index i = 0; i < normals.rows(); ++i) {
    angles.push_back(angle_between_deg(predicted.row(i), normals.row(i)));
  }
  return median(angles) / std::sqrt(2 * std::log(2.0)) * std::numbers::pi / 180;
}

}  // namespace

double angle_between_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / std::numbers::pi;
}

std::vector<BiotacSample> biotac_samples(const BiotacLog& log) {
  const BiotacSignals signals = biotac_signals(log);
  std::vector<BiotacSample> samples;
  for (std::size_t i = 0; i < log.time.size(); ++i) {
    if (!log.normals[i] || !biotac_usable(signals.flags[i])) continue;
    samples.push_back({signals.changes[i], *log.normals[i]});
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
  Eigen::MatrixXd normals(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    model.centres_.col(i) = features(learned[static_cast<std::size_t>(i)].change);
    normals.row(i) = learned[static_cast<std::size_t>(i)].n;
  }
  model.mean_ = model.centres_.rowwise().mean();
  model.centres_.colwise() -= model.mean_;
  model.scale_ = (model.centres_.rowwise().squaredNorm() / static_cast<double>(count)).cwiseSqrt();
  model.scale_ = model.scale_.cwiseMax(1e-6);
  model.centres_ = (model.centres_.array().colwise() / model.scale_.array()).matrix();
  model.mean_normal_ = normals.colwise().mean();
  model.length_ = options.length;
  model.linear_ = options.linear;
  model.noise_ = options.noise;
  const Eigen::MatrixXd deviations = normals.rowwise() - model.mean_normal_.transpose();
  model.spread_ = std::sqrt(deviations.squaredNorm() / static_cast<double>(3 * count));
  const Eigen::MatrixXd K =
      numerics::kernel(model.centres_, model.centres_, options.length, options.linear);
  const Eigen::MatrixXd noisy = K + options.noise * Eigen::MatrixXd::Identity(count, count);
  model.weights_ = noisy.llt().solve(deviations);
  const Eigen::MatrixXd predicted = (K * model.weights_).rowwise() + model.mean_normal_.transpose();
  model.residual_ = residual_of(predicted, normals);
  model.prepare();
  return model;
}

void BiotacNormalModel::prepare() {
  const Eigen::Index count = centres_.cols();
  Eigen::MatrixXd K = numerics::kernel(centres_, centres_, length_, linear_);
  K.diagonal().array() += noise_;
  const Eigen::LLT<Eigen::MatrixXd> factor(K);
  root_ = factor.matrixL().solve(Eigen::MatrixXd::Identity(count, count));
}

std::optional<BiotacNormal> BiotacNormalModel::estimate(const BiotacChannels& change) const {
  if (!change.allFinite() || change[0] <= 0) return std::nullopt;
  const Eigen::MatrixXd x = ((features(change) - mean_).array() / scale_.array()).matrix();
  const Eigen::MatrixXd k = numerics::kernel(centres_, x, length_, linear_);
  const Eigen::Vector3d n = mean_normal_ + weights_.transpose() * k.col(0);
  if (n.norm() < 1e-9) return std::nullopt;
  const double prior = numerics::kernel(x, x, length_, linear_)(0, 0);
  const Eigen::VectorXd explained = root_.triangularView<Eigen::Lower>() * k.col(0);
  const double left = std::max(0.0, prior - explained.squaredNorm());
  return BiotacNormal{
      .n = n.normalized(),
      .sigma = std::max(kMinSigma, std::hypot(residual_, spread_ * std::sqrt(left))),
      .novelty = std::min(1.0, left)};
}

std::string BiotacNormalModel::bytes() const {
  ArrayFile file(kNormalKind, kNormalVersion);
  Eigen::VectorXd settings(8);
  settings << mean_normal_, length_, linear_, noise_, spread_, residual_;
  file.add("settings", settings.cast<float>());
  file.add("mean", mean_.cast<float>());
  file.add("scale", scale_.cast<float>());
  file.add("centres", centres_.cast<float>());
  file.add("weights", weights_.cast<float>());
  return file.bytes();
}

BiotacNormalModel BiotacNormalModel::parse(std::string_view bytes, const std::string& source) {
  const auto file = ArrayFile::parse(bytes, source, kNormalKind, kNormalVersion);
  BiotacNormalModel model;
  const Eigen::VectorXd settings = file.get("settings", 8, 1).cast<double>();
  model.mean_normal_ = settings.head<3>();
  model.length_ = settings[3];
  model.linear_ = settings[4];
  model.noise_ = settings[5];
  model.spread_ = settings[6];
  model.residual_ = settings[7];
  model.mean_ = file.get("mean", kNormalFeatures, 1).cast<double>();
  model.scale_ = file.get("scale", kNormalFeatures, 1).cast<double>();
  model.centres_ = file.get("centres", kNormalFeatures).cast<double>();
  model.weights_ = file.get("weights", model.centres_.cols(), 3).cast<double>();
  if (settings.segment<3>(3).minCoeff() < 0 || model.length_ <= 0 || model.noise_ <= 0 ||
      model.scale_.minCoeff() <= 0 || settings.tail<2>().minCoeff() < 0) {
    throw BadInput(fmt::format("{}: a scale of the model is not positive", source));
  }
  model.prepare();
  return model;
}

std::vector<double> cross_validate_biotac_normal(const std::vector<BiotacLog>& logs,
                                                 const BiotacNormalOptions& options, int folds) {
  std::vector<double> errors;
  for (const auto& [learn, judge] : folds_of_touches(logs, folds)) {
    const auto model = BiotacNormalModel::train(learn, options);
    for (const auto& sample : judge) {
      if (const auto found = model.estimate(sample.change)) {
        errors.push_back(angle_between_deg(found->n, sample.n));
      }
    }
  }
  return errors;
}

}  // namespace palpate::tactile
