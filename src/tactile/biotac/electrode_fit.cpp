// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "numerics/levenberg_marquardt.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/tactile/biotac/electrodes.hpp"
#include "tactile/biotac/chosen_samples.hpp"

namespace palpate::tactile {
namespace {

constexpr int kSkinUnknowns = 7;  // stiffness, crown, spread, bulge (as logarithms), a turn
constexpr std::size_t kLeast = 20;
constexpr double kMaxExponent = 3;  // by which a parameter may leave its default

using Unknowns = Eigen::Matrix<double, kSkinUnknowns, 1>;

/// Where a plane with this inward normal of the skin touches: on the half ball, or back along the
/// cylinder as far as the tip's crown says.
Eigen::Vector3d place_of(const Eigen::Vector3d& outward, const SkinOptions& skin) {
  const double r = skin.radius;
  const double x = outward.x() > 0 ? r * std::min(outward.x(), 0.99)
                                   : std::max(-skin.length, skin.crown * outward.x());
  const double ring = x > 0 ? std::sqrt(r * r - x * x) : r;
  const Eigen::Vector2d across = outward.tail<2>().normalized();
  return {x, ring * across.x(), ring * across.y()};
}

/// A sensor's answer to flat contacts.
class FlatContact {
 public:
  explicit FlatContact(const ElectrodeFit& fit)
      : fit_(fit), skin_(fit.skin), electrodes_(skin_, fit.sensor) {}

  [[nodiscard]] ElectrodeChanges operator()(const Eigen::Vector3d& n, double pressure) const {
    const Eigen::Vector3d seen(n.x(), fit_.mirrored ? -n.y() : n.y(), n.z());
    const Eigen::Vector3d p = place_of(-(fit_.R_sensor_log * seen), fit_.skin);
    const Eigen::Vector3d outward = skin_.normal_at(p);
    const double wanted = pressure / fit_.sensor.pressure_gain;
    SkinState state = press(p, outward, wanted);
    // Pressure acts along the taxels' own normals: more of it than the force it sums up to.
    const double reached = state.pressure.dot(skin_.areas());
    if (reached > 0) state = press(p, outward, wanted * wanted / reached);
    const Eigen::ArrayXd at_rest = hand::kBiotacFullScale / electrode_rest().array() - 1;
    const Eigen::ArrayXd ratio = 1 + electrodes_.resistances(state).array();
    return hand::kBiotacFullScale / (1 + at_rest * ratio) - electrode_rest().array();
  }

 private:
  [[nodiscard]] SkinState press(const Eigen::Vector3d& p, const Eigen::Vector3d& outward,
                                double force) const {
    const hand::TipContact contact{.p = p, .n = -outward, .f = force * outward};
    return skin_.press({&contact, 1});
  }

  ElectrodeFit fit_;
  BiotacSkin skin_;
  BiotacElectrodes electrodes_;
};

ElectrodeFit fit_of(const Unknowns& unknowns, bool mirrored) {
  const auto factor = [&](int k) {
    return std::exp(std::clamp(unknowns[k], -kMaxExponent, kMaxExponent));
  };
  ElectrodeFit fit;
  fit.mirrored = mirrored;
  fit.skin.stiffness *= factor(0);
  fit.skin.shear_stiffness *= factor(0);
  fit.skin.crown *= factor(1);
  fit.sensor.spread *= factor(2);
  fit.sensor.bulge_area *= factor(3);
  fit.R_sensor_log = exp_so3(unknowns.tail<3>());
  return fit;
}

Eigen::VectorXd residuals_of(const ElectrodeFit& fit, const std::vector<BiotacSample>& samples,
                             const ElectrodeChanges& deviation) {
  Eigen::MatrixXd errors = fit.changes(samples);
  for (Eigen::Index i = 0; i < errors.cols(); ++i) {
    errors.col(i) -= samples[static_cast<std::size_t>(i)].change.tail<kElectrodes>();
  }
  return (errors.array().colwise() / deviation.array()).reshaped();
}

/// Residuals whose squares grow like the pseudo-Huber loss (Charbonnier et al. 1997).
Eigen::VectorXd robust(const Eigen::VectorXd& residuals, double outlier) {
  const Eigen::ArrayXd ratio = residuals.array() / outlier;
  const Eigen::ArrayXd loss = 2 * ((1 + ratio.square()).sqrt() - 1);
  return outlier * ratio.sign() * loss.sqrt();
}

}  // namespace

Eigen::MatrixXd ElectrodeFit::changes(const std::vector<BiotacSample>& contacts) const {
  const FlatContact contact_of(*this);
  Eigen::MatrixXd result(kElectrodes, static_cast<Eigen::Index>(contacts.size()));
  for (Eigen::Index i = 0; i < result.cols(); ++i) {
    const BiotacSample& contact = contacts[static_cast<std::size_t>(i)];
    result.col(i) = contact_of(contact.n, contact.change[0]);
  }
  return result;
}

ElectrodeChanges electrode_deviation(const std::vector<BiotacSample>& samples) {
  ElectrodeChanges mean = ElectrodeChanges::Zero(), square = ElectrodeChanges::Zero();
  const auto count = static_cast<double>(samples.size());
  for (const auto& s : samples) mean += s.change.tail<kElectrodes>() / count;
  for (const auto& s : samples) {
    square += (s.change.tail<kElectrodes>() - mean).cwiseAbs2() / count;
  }
  return square.cwiseSqrt().cwiseMax(1.0);
}

ElectrodeFit fit_electrodes(const std::vector<BiotacSample>& samples,
                            const ElectrodeFitOptions& options) {
  if (samples.size() < kLeast) {
    throw BadInput(
        fmt::format("{} samples of contact are too few to fit electrodes to; at least "
                    "{} are needed",
                    samples.size(), kLeast));
  }
  const ElectrodeChanges deviation = electrode_deviation(samples);
  const auto learned = chosen_samples(samples, options.samples, options.seed);
  Unknowns width = Unknowns::Constant(0.02);
  width.tail<3>().setConstant(0.01);
  const numerics::LeastSquaresOptions search{.iterations = 25, .max_step = 50};
  std::optional<ElectrodeFit> best;
  double least = 0;
  for (const bool mirrored : {false, true}) {
    const auto found = numerics::levenberg_marquardt(
        Unknowns(Unknowns::Zero()), width,
        [&](const Unknowns& unknowns) {
          return robust(residuals_of(fit_of(unknowns, mirrored), learned, deviation),
                        options.outlier);
        },
        [](const Unknowns& unknowns, const Unknowns& step) { return Unknowns(unknowns + step); },
        search);
    const double left = found.residuals.squaredNorm();
    if (best && left >= least) continue;
    least = left;
    best = fit_of(found.state, mirrored);
  }
  return *best;
}

}  // namespace palpate::tactile
