// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/biotac/inverse.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cmath>

#include "numerics/levenberg_marquardt.hpp"
#include "palpate/core/array_file.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/options.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/core/statistics.hpp"

namespace palpate::tactile {
namespace {

constexpr const char* kInverseKind = "biotac-inverse";
constexpr int kInverseVersion = 2;
constexpr int kInverseFeatures = 1 + 2 * kElectrodes;
constexpr int kGuessed = 6;
constexpr double kInverseFlatPressure = 10;  // counts, that keep shares small at light touch
constexpr int kInverseUnknowns = 8;          // u, v, fu, fv, fn, and the curvatures uu, uv, vv
constexpr double kCurvature = 30;            // 1/m, of objects, before anything is sensed ...
constexpr double kCurvatureSpread = 250;     // ... and its standard deviation
constexpr double kMaxCurvature = 500;        // 1/m
constexpr double kModelError = 0.0002;       // of relative resistances, standard deviation
constexpr double kDoubtfulMisfit = 0.75;     // standard deviations, from which on a fit is doubted
constexpr double kElsewhere = 0.0025;        // m, from the guess, to where else the contact may be

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

Eigen::VectorXd features(const DecodedReading& reading) {
  Eigen::VectorXd result(kInverseFeatures);
  result << std::log(std::max(reading.pressure, 1.0)), reading.resistances,
      100 * reading.resistances / (reading.pressure + kInverseFlatPressure);
  return result;
}

Eigen::VectorXd sd_of(const Eigen::MatrixXd& values, const Eigen::VectorXd& mean) {
  const Eigen::MatrixXd deviations = values.colwise() - mean;
  return (deviations.rowwise().squaredNorm() / static_cast<double>(values.cols()))
      .cwiseSqrt()
      .cwiseMax(1e-9);
}

/// What predicts how far a fit may be off: logarithms of its own variance, misfit and pressure.
Eigen::Vector4d signs_of_error(double variance, double misfit, double pressure) {
  return {1, std::log(variance), std::log(std::max(misfit, 0.05)),
          std::log(std::max(pressure, 1.0))};
}

/// The c with variance exp(c . signs) under which the errors are likeliest, if they are Gaussian
/// (Fisher scoring, McCullagh & Nelder 1989, section 2.5; a little ridge towards the fit's own
/// variance).
Eigen::Vector4d log_variance_fit(const Eigen::Matrix4Xd& signs, const Eigen::VectorXd& errors) {
  constexpr int kSteps = 60;
  constexpr double kRidge = 1e-3;
  const Eigen::Vector4d start(
      std::log((errors.array().square() / signs.row(1).transpose().array().exp()).mean()), 1, 0, 0);
  const auto count = static_cast<double>(errors.size());
  const Eigen::Matrix4d information =
      signs * signs.transpose() / count + kRidge * Eigen::Matrix4d::Identity();
  Eigen::Vector4d c = start;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::ArrayXd ratio =
        errors.array().square() * (-(signs.transpose() * c).array()).exp() - 1;
    const Eigen::Vector4d up = signs * ratio.min(3.0).matrix() / count + kRidge * (start - c);
    c += 0.5 * information.ldlt().solve(up);
  }
  return c;
}

std::vector<int> sizes_of(int hidden) { return {kInverseFeatures, hidden, hidden, kGuessed}; }

bool held_out(const BiotacFrame& frame) { return frame.trajectory % 5 == 4; }

bool touching(const BiotacFrame& frame) {
  return frame.decoded.pressure > BiotacInverse::kMinPressure;
}

/// All options of a struct as one column, in the order of its visit().
template <class Options>
Eigen::VectorXf numbers_of(Options options) {
  std::vector<float> numbers;
  for (const auto& field : option_fields(options)) {
    numbers.push_back(static_cast<float>(*std::get<RangedOption<double>>(field.value).value));
  }
  return Eigen::Map<Eigen::VectorXf>(numbers.data(), static_cast<Eigen::Index>(numbers.size()));
}

template <class Options>
Options options_from(const ArrayFile& file, const std::string& name, const std::string& source) {
  Options options;
  const auto fields = option_fields(options);
  const auto& numbers = file.get(name, static_cast<Eigen::Index>(fields.size()), 1);
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto& ranged = std::get<RangedOption<double>>(fields[i].value);
    *ranged.value = numbers(static_cast<Eigen::Index>(i), 0);
    if (*ranged.value < ranged.low || *ranged.value > ranged.high) {
      throw BadInput(fmt::format("{}: {}.{} is {}", source, name, fields[i].key, *ranged.value));
    }
  }
  return options;
}

}  // namespace

/// What is fitted, about a point of the skin.
struct BiotacInverse::Unknowns {
  Eigen::Vector3d p;                                     // on the skin
  Eigen::Matrix3d tangents;                              // u, v, outward
  Eigen::Vector3d force;                                 // along tangents' columns
  Eigen::Vector3d curvature{kCurvature, 0, kCurvature};  // uu, uv, vv; 1/m

  /// Moved by a step in the order of kInverseUnknowns.
  [[nodiscard]] Unknowns moved(const Eigen::Matrix<double, kInverseUnknowns, 1>& step,
                               const BiotacSkin& skin) const {
    Unknowns result = *this;
    result.p = skin.on_skin(p + tangents.leftCols<2>() * step.head<2>());
    const Eigen::Vector3d outward = skin.normal_at(result.p);
    // The frame rolls along with the skin, so that forces keep their meaning.
    result.tangents =
        Eigen::Quaterniond::FromTwoVectors(tangents.col(2), outward).toRotationMatrix() * tangents;
    result.force += step.segment<3>(2);
    result.force.z() = std::max(result.force.z(), 0.01);
    result.curvature =
        (curvature + step.tail<3>()).cwiseMax(-kMaxCurvature).cwiseMin(kMaxCurvature);
    return result;
  }
};

BiotacInverse::BiotacInverse(const SkinOptions& skin, const BiotacSensorOptions& sensor,
                             numerics::Mlp guess)
    : skin_options_(skin),
      sensor_options_(sensor),
      skin_(std::make_shared<const BiotacSkin>(skin)),
      electrodes_(*skin_, sensor),
      guess_(std::move(guess)) {}

Eigen::MatrixXd BiotacInverse::standardised(const Eigen::MatrixXd& inputs) const {
  return ((inputs.colwise() - input_mean_).array().colwise() / input_sd_.array()).matrix();
}

Eigen::VectorXd BiotacInverse::residuals(const Unknowns& unknowns, const DecodedReading& reading,
                                         const Eigen::VectorXd& sigma) const {
  const Eigen::Vector3d outward = unknowns.tangents.col(2);
  const hand::TipContact contact{
      .p = unknowns.p, .n = -outward, .f = unknowns.tangents * unknowns.force};
  const Eigen::Vector3d curvature = unknowns.curvature;
  const double middle = (curvature[0] + curvature[2]) / 2;
  const double most =
      std::max(0.0, middle + std::hypot((curvature[0] - curvature[2]) / 2, curvature[1]));
  const auto surface = [&](const Eigen::Vector3d& x) {
    // Exact for planes, balls and cylinders that meet the skin at p.
    const Eigen::Vector3d away = unknowns.tangents.transpose() * (x - unknowns.p);
    const double u = away.x(), v = away.y(), along = -away.z();
    const double rise = curvature[0] * u * u + 2 * curvature[1] * u * v + curvature[2] * v * v +
                        most * along * along + 2 * along;
    return rise / (1 + std::sqrt(std::max(0.0, 1 + most * rise)));
  };
  const SkinState state = skin_->press({&contact, 1}, surface);
  Eigen::VectorXd result(kElectrodes + 4);
  result.head<kElectrodes>() = electrodes_.resistances(state) - reading.resistances;
  result[kElectrodes] =
      sensor_options_.pressure_gain * state.pressure.dot(skin_->areas()) - reading.pressure;
  result.tail<3>() = curvature - Eigen::Vector3d(kCurvature, 0, kCurvature);
  return (result.array() / sigma.array()).matrix();
}

BiotacInverse::Unknowns BiotacInverse::guess(const DecodedReading& reading) const {
  const Eigen::VectorXd value =
      (guess_(standardised(features(reading))).col(0).array() * output_sd_.array()).matrix() +
      output_mean_;
  Unknowns unknowns;
  unknowns.p = skin_->on_skin(value.head<3>());
  unknowns.tangents = frame_with_z(skin_->normal_at(unknowns.p));
  unknowns.force = unknowns.tangents.transpose() * value.tail<3>() * reading.pressure;
  unknowns.force.z() = std::max(unknowns.force.z(), 0.01);
  return unknowns;
}

InferredContact BiotacInverse::fit(const DecodedReading& reading) const {
  using Step = Eigen::Matrix<double, kInverseUnknowns, 1>;
  const Eigen::VectorXd rest = electrode_rest();
  const double noise =  // and rounding, counts
      BiotacDecoder::noise_left() * std::hypot(sensor_options_.noise, 0.3);
  Eigen::VectorXd sigma(kElectrodes + 4);
  for (int j = 0; j < kElectrodes; ++j) {
    const double at_rest = hand::kBiotacFullScale / rest[j] - 1;
    const double counts =
        hand::kBiotacFullScale / (1 + at_rest * (1 + std::max(-0.9, reading.resistances[j])));
    const double from_counts = noise * hand::kBiotacFullScale / (counts * counts * at_rest);
    sigma[j] = std::hypot(from_counts / (1 - sensor_options_.creep_share),
                          kModelError + 0.001 * std::abs(reading.resistances[j]));
  }
  sigma[kElectrodes] = std::hypot(noise, 0.01 * reading.pressure);
  sigma.tail<3>().setConstant(kCurvatureSpread);
  const double scale = std::max(0.1, reading.pressure / sensor_options_.pressure_gain);
  Step width;
  width << 1e-4, 1e-4, 0.03 * scale, 0.03 * scale, 0.03 * scale, 5, 5, 5;
  const auto miss = [&](const Unknowns& u) { return residuals(u, reading, sigma); };
  const auto move = [&](const Unknowns& u, const Step& step) { return u.moved(step, *skin_); };
  const Unknowns start = guess(reading);
  auto found = numerics::levenberg_marquardt(start, width, miss, move);
  // A fit that ended beside the truth leaves more than noise: look from other places too.
  for (int k = 0; k < 4 && rms(found.residuals) > kDoubtfulMisfit; ++k) {
    Step step = Step::Zero();
    step[k / 2] = k % 2 ? kElsewhere : -kElsewhere;
    const auto other = numerics::levenberg_marquardt(start.moved(step, *skin_), width, miss, move);
    if (other.residuals.squaredNorm() < found.residuals.squaredNorm()) found = other;
  }
  const Unknowns& unknowns = found.state;
  Eigen::MatrixXd information = found.information;
  information.diagonal().array() += 1e-6;
  const Eigen::MatrixXd covariance =
      width.asDiagonal() * information.inverse() * width.asDiagonal();
  InferredContact contact;
  contact.p = unknowns.p;
  contact.n = -unknowns.tangents.col(2);
  contact.f = unknowns.tangents * unknowns.force;
  contact.tangents = unknowns.tangents;
  contact.misfit = rms(found.residuals);
  contact.covariance.setZero();
  for (int k = 0; k < 5; ++k) {
    const auto signs = signs_of_error(covariance(k, k), contact.misfit, reading.pressure);
    contact.covariance(k, k) = std::exp(signs.dot(calibration_.col(k)));
  }
  return contact;
}

std::optional<InferredContact> BiotacInverse::estimate(const DecodedReading& reading) const {
  if (!reading.resistances.allFinite() || !(reading.pressure > kMinPressure)) {
    return std::nullopt;
  }
  return fit(reading);
}

BiotacInverse BiotacInverse::train(const std::vector<BiotacFrame>& frames,
                                   const BiotacInverseOptions& options, const SkinOptions& skin,
                                   const BiotacSensorOptions& sensor) {
  std::vector<const BiotacFrame*> learn;
  std::vector<BiotacFrame> validation;
  for (const auto& frame : frames) {
    if (!touching(frame)) continue;
    if (held_out(frame)) {
      validation.push_back(frame);
    } else {
      learn.push_back(&frame);
    }
  }
  if (learn.size() < 80 || validation.size() < 20) {
    throw BadInput(fmt::format("{} frames of contact are too few to learn from",
                               learn.size() + validation.size()));
  }
  const auto count = static_cast<Eigen::Index>(learn.size());
  Eigen::MatrixXd inputs(kInverseFeatures, count), outputs(kGuessed, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const BiotacFrame& frame = *learn[static_cast<std::size_t>(i)];
    inputs.col(i) = features(frame.decoded);
    outputs.col(i) << frame.p, frame.f1 / frame.decoded.pressure;
  }
  RandomStream random(options.seed, "biotac-inverse");
  BiotacInverse model(skin, sensor,
                      numerics::Mlp(sizes_of(options.hidden), numerics::Activation::tanh, random));
  model.input_mean_ = inputs.rowwise().mean();
  model.input_sd_ = sd_of(inputs, model.input_mean_);
  model.output_mean_ = outputs.rowwise().mean();
  model.output_sd_ = sd_of(outputs, model.output_mean_);
  numerics::RegressionOptions regression{
      .epochs = options.epochs, .batch = 64, .rate = options.rate};
  regression.final_rate = 0.01;
  const Eigen::MatrixXd scaled =
      ((outputs.colwise() - model.output_mean_).array().colwise() / model.output_sd_.array())
          .matrix();
  numerics::fit_regression(model.guess_, model.standardised(inputs), scaled, regression, random);
  model.calibrate(validation);
  return model;
}

Eigen::Matrix<double, 5, 1> contact_error(const InferredContact& found, const Eigen::Vector3d& p,
                                          const Eigen::Vector3d& f) {
  Eigen::Matrix<double, 5, 1> error;
  error << found.tangents.leftCols<2>().transpose() * (p - found.p),
      found.tangents.transpose() * (f - found.f);
  return error;
}

void BiotacInverse::calibrate(const std::vector<BiotacFrame>& held_out) {
  constexpr std::size_t kMost = 1500;
  const std::size_t stride = std::max<std::size_t>(1, held_out.size() / kMost);
  const auto count = static_cast<Eigen::Index>((held_out.size() + stride - 1) / stride);
  // Until calibrated, the covariance is the fit's own.
  calibration_ = Eigen::Vector4d(0, 1, 0, 0).replicate<1, 5>();
  std::array<Eigen::Matrix4Xd, 5> signs;
  signs.fill(Eigen::Matrix4Xd(4, count));
  Eigen::MatrixXd errors(count, 5);
  for (Eigen::Index i = 0; i < count; ++i) {
    const BiotacFrame& frame = held_out[static_cast<std::size_t>(i) * stride];
    const auto found = fit(frame.decoded);
    errors.row(i) = contact_error(found, frame.p, frame.f1);
    for (int k = 0; k < 5; ++k) {
      signs[static_cast<std::size_t>(k)].col(i) =
          signs_of_error(found.covariance(k, k), found.misfit, frame.decoded.pressure);
    }
  }
  for (int k = 0; k < 5; ++k) {
    calibration_.col(k) = log_variance_fit(signs[static_cast<std::size_t>(k)], errors.col(k));
  }
}

std::string BiotacInverse::bytes() const {
  ArrayFile file(kInverseKind, kInverseVersion);
  file.add("skin", numbers_of(skin_options_));
  file.add("sensor", numbers_of(sensor_options_));
  file.add("hidden", Eigen::MatrixXf::Constant(1, 1, static_cast<float>(guess_.sizes()[1])));
  file.add("guess", guess_.parameters().cast<float>());
  file.add("input_mean", input_mean_.cast<float>());
  file.add("input_sd", input_sd_.cast<float>());
  file.add("output_mean", output_mean_.cast<float>());
  file.add("output_sd", output_sd_.cast<float>());
  file.add("calibration", calibration_.cast<float>());
  return file.bytes();
}

BiotacInverse BiotacInverse::parse(std::string_view bytes, const std::string& source) {
  const auto file = ArrayFile::parse(bytes, source, kInverseKind, kInverseVersion);
  const float hidden = file.get("hidden", 1, 1)(0, 0);
  if (!(hidden >= 1 && hidden <= 4096) || hidden != std::floor(hidden)) {
    throw BadInput(fmt::format("{}: {} hidden units", source, hidden));
  }
  auto sizes = sizes_of(static_cast<int>(hidden));
  Eigen::Index count = 0;
  for (std::size_t k = 0; k + 1 < sizes.size(); ++k) count += sizes[k + 1] * (sizes[k] + 1);
  BiotacInverse model(options_from<SkinOptions>(file, "skin", source),
                      options_from<BiotacSensorOptions>(file, "sensor", source),
                      numerics::Mlp(std::move(sizes), numerics::Activation::tanh,
                                    file.get("guess", count, 1).cast<double>()));
  model.input_mean_ = file.get("input_mean", kInverseFeatures, 1).cast<double>();
  model.input_sd_ = file.get("input_sd", kInverseFeatures, 1).cast<double>();
  model.output_mean_ = file.get("output_mean", kGuessed, 1).cast<double>();
  model.output_sd_ = file.get("output_sd", kGuessed, 1).cast<double>();
  model.calibration_ = file.get("calibration", 4, 5).cast<double>();
  if (model.input_sd_.minCoeff() <= 0 || model.output_sd_.minCoeff() <= 0) {
    throw BadInput(fmt::format("{}: a scale of the model is not positive", source));
  }
  return model;
}

}  // namespace palpate::tactile
