// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/pose_prior.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "localization/likelihood/prior_term.hpp"
#include "localization/scenes.hpp"
#include "localization/search/proposal.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"

namespace palpate::localization {
namespace {

Matrix6d covariance_of(double rotation, double translation) {
  Vector6d variances;
  variances << Eigen::Vector3d::Constant(rotation * rotation),
      Eigen::Vector3d::Constant(translation * translation);
  return variances.asDiagonal();
}

/// Correlated, with standard deviations of some degrees and millimetres.
Matrix6d random_covariance(RandomStream& random) {
  Matrix6d A;
  for (Eigen::Index i = 0; i < 36; ++i) A(i) = random.normal();
  Vector6d scale;
  scale << 0.05, 0.05, 0.05, 0.004, 0.004, 0.004;
  return scale.asDiagonal() * (A * A.transpose() / 6 + 0.1 * Matrix6d::Identity()) *
         scale.asDiagonal();
}

Eigen::Isometry3d moved(const Eigen::Isometry3d& T, const Vector6d& x) {
  Eigen::Isometry3d result;
  result.linear() = exp_so3(x.head<3>()) * T.linear();
  result.translation() = T.translation() + x.tail<3>();
  return result;
}

Vector6d deviation(const Eigen::Isometry3d& T, const Eigen::Isometry3d& from) {
  Vector6d x;
  x << log_so3(T.linear() * from.linear().transpose()), T.translation() - from.translation();
  return x;
}

SearchPose search_pose(const Eigen::Isometry3d& T) {
  return {T.linear().cast<float>(), T.translation().cast<float>()};
}

Eigen::Isometry3d isometry(const SearchPose& pose) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = Eigen::Quaterniond(pose.R.cast<double>()).normalized().toRotationMatrix();
  T.translation() = pose.t.cast<double>();
  return T;
}

PosePrior prior_at(const Eigen::Isometry3d& T, double rotation, double translation) {
  PosePrior prior;
  prior.components.push_back({T, 1, covariance_of(rotation, translation)});
  return prior;
}

double peak(const PosePrior::Component& component) {
  return component.weight / std::sqrt(std::pow(2 * M_PI, 6) * component.covariance.determinant());
}

double direct_density(const PosePrior& prior, const Eigen::Isometry3d& T) {
  double sum = 0;
  for (const auto& component : prior.components) {
    const Vector6d x = deviation(T, component.T_frame_object);
    sum += peak(component) * std::exp(-0.5 * x.dot(component.covariance.inverse() * x));
  }
  return sum;
}

TEST(PriorTerm, IsTheFormula) {
  RandomStream random(1);
  PosePrior prior;
  const Eigen::Isometry3d T = random_pose(random);
  double highest = 0;
  for (const double weight : {0.5, 0.3, 0.1}) {
    Vector6d x;
    x << 0.1 * random.normal3(), 0.005 * random.normal3();
    prior.components.push_back({moved(T, x), weight, random_covariance(random)});
    highest = std::max(highest, peak(prior.components.back()));
  }
  const PriorTerm term(std::make_shared<const PoseMixture>(prior), prior.floor);
  const auto formula = [&](const Eigen::Isometry3d& at) {
    return -std::log(direct_density(prior, at) / highest + prior.floor);
  };
  const auto constant = static_cast<double>(term.energy(search_pose(T), kNoBound)) - formula(T);
  for (int i = 0; i < 300; ++i) {
    Vector6d x;
    const double size = random.uniform(0, i % 2 ? 1 : 20);
    x << size * 0.1 * random.normal3(), size * 0.005 * random.normal3();
    const Eigen::Isometry3d at = moved(T, x);
    const auto energy = static_cast<double>(term.energy(search_pose(at), kNoBound));
    EXPECT_NEAR(energy - constant, formula(at), 0.002);
    EXPECT_GE(energy, 0);
  }
}

TEST(PriorTerm, FarPosesKeepTheFloor) {
  RandomStream random(2);
  const Eigen::Isometry3d T = random_pose(random);
  PosePrior prior = prior_at(T, 0.05, 0.002);
  prior.floor = 1e-5;
  const PriorTerm term(std::make_shared<const PoseMixture>(prior), prior.floor);
  EXPECT_NEAR(term.energy(search_pose(T), kNoBound), 0, 1e-5);
  Vector6d x;
  for (const Vector6d& way : {Vector6d(Vector6d::Unit(1)), Vector6d(Vector6d::Unit(4))}) {
    x = 3 * way;
    EXPECT_NEAR(term.energy(search_pose(moved(T, x)), kNoBound), -std::log(1e-5), 0.001);
  }
}

TEST(PoseMixture, DrawsHaveTheMomentsOfTheMixture) {
  RandomStream random(3);
  PosePrior prior;
  prior.components.push_back({random_pose(random), 0.6, random_covariance(random)});
  prior.components.push_back({random_pose(random), 0.2, random_covariance(random)});
  const PoseMixture mixture(prior);
  constexpr int kDraws = 20000;
  int first = 0;
  Vector6d mean = Vector6d::Zero();
  Matrix6d square = Matrix6d::Zero();
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Isometry3d T = isometry(mixture.draw(random));
    const Vector6d x = deviation(T, prior.components[0].T_frame_object);
    if (x.tail<3>().norm() > 0.05) continue;
    ++first;
    mean += x;
    square += x * x.transpose();
  }
  EXPECT_NEAR(first / static_cast<double>(kDraws), 0.75, 0.015);
  const Vector6d sigma = prior.components[0].covariance.diagonal().cwiseSqrt();
  const Matrix6d scaled = sigma.cwiseInverse().asDiagonal() *
                          (square / first - prior.components[0].covariance) *
                          sigma.cwiseInverse().asDiagonal();
  EXPECT_LT((mean / first).cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.04);
  EXPECT_LT(scaled.cwiseAbs().maxCoeff(), 0.06);
}

TEST(PriorProposal, WithoutOtherEvidenceIsTheMixture) {
  RandomStream random(4);
  Evidence evidence;
  evidence.prior.emplace();
  for (const double weight : {0.5, 0.25}) {
    evidence.prior->components.push_back({random_pose(random), weight, random_covariance(random)});
  }
  PosePrior sure = *evidence.prior;
  for (auto& component : sure.components) component.weight /= 0.75;
  const auto proposal = make_proposal(model_of("box"), evidence, {});
  for (int i = 0; i < 100; ++i) {
    const SearchPose pose = proposal->draw(random);
    EXPECT_NEAR(proposal->energy(pose), -std::log(direct_density(sure, isometry(pose))), 0.01);
  }
}

/// Share of a distribution's draws within 2 sigma of a pose, counted and by its density.
struct Share {
  double counted = 0, integrated = 0;
};

/// The densities of proposals are normalised, else they could not be mixed: E_u[q / u] over the
/// draws of a normal distribution u, which covers the place, is the share of q's draws there.
Share share_near(const Proposal& proposal, const Eigen::Isometry3d& T, const Matrix6d& covariance) {
  PosePrior prior;
  prior.components.push_back({T, 1, covariance});
  const Matrix6d information = covariance.inverse();
  const auto near = [&](const SearchPose& pose) {
    const Vector6d x = deviation(isometry(pose), T);
    return x.dot(information * x) < 4;
  };
  const PoseMixture mixture(prior);
  RandomStream random(5);
  constexpr int kDraws = 200000;
  Share share;
  for (int i = 0; i < kDraws; ++i) {
    const SearchPose pose = mixture.draw(random);
    const double log_u = mixture.log_peak() + std::log(mixture.relative_density(pose));
    if (near(pose)) {
      share.integrated += std::exp(-static_cast<double>(proposal.energy(pose)) - log_u) / kDraws;
    }
    share.counted += near(proposal.draw(random)) / static_cast<double>(kDraws);
  }
  return share;
}

TEST(PriorProposal, MixesDensitiesThatAreNormalised) {
  SceneOptions options;
  options.contacts = 1;
  options.point_noise = 0.004;
  options.normal_noise = 0.3;
  options.table = true;
  const geometry::ObjectModel& model = model_of("box");
  Scene scene = make_scene(model, options, RandomStream(6));
  const Share table =
      share_near(*make_proposal(model, scene.evidence, {}), scene.truth, covariance_of(0.3, 0.02));
  EXPECT_GT(table.counted, 0.005);
  EXPECT_NEAR(table.integrated / table.counted, 1, 0.15);
  scene.evidence.table.reset();
  const Share anchor =
      share_near(*make_proposal(model, scene.evidence, {}), scene.truth, covariance_of(0.8, 0.04));
  EXPECT_GT(anchor.counted, 0.005);
  EXPECT_NEAR(anchor.integrated / anchor.counted, 1, 0.3);
}

TEST(Localize, APriorAloneGivesItsMean) {
  RandomStream random(7);
  const geometry::ObjectModel& model = model_of("bracket");
  Evidence evidence;
  const Eigen::Isometry3d T = random_pose(random);
  evidence.prior = prior_at(T, 1.5 * kDegree, 0.002);
  const Posterior posterior = localize(model, evidence, RandomStream(1));
  ASSERT_FALSE(posterior.modes.empty());
  const Vector6d x = deviation(posterior.modes[0].T_frame_object, T);
  EXPECT_LT(x.head<3>().norm(), 0.4 * kDegree);
  EXPECT_LT(x.tail<3>().norm(), 0.0005);
  EXPECT_GT(posterior.modes[0].weight, 0.8);
  EXPECT_NEAR(std::sqrt(posterior.modes[0].covariance(4, 4)), 0.002, 0.0005);
}

bool right(const Posterior& posterior, const geometry::ObjectModel& model, const Scene& scene) {
  return !posterior.modes.empty() &&
         within_tolerance(mode_error(posterior.modes[0], scene.truth, model.object().symmetries));
}

TEST(Localize, ClearContactsOverruleAWrongPrior) {
  SceneOptions options;
  options.contacts = 20;
  options.table = true;
  const geometry::ObjectModel& model = model_of("bottle");
  int overruled = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U}) {
    Scene scene = make_scene(model, options, RandomStream(seed));
    Eigen::Isometry3d wrong = scene.truth;  // stands on its head, or lies the other way round
    wrong.linear() = scene.truth.linear() * exp_so3({M_PI, 0, 0});
    ASSERT_FALSE(within_tolerance(pose_error(wrong, scene.truth, model.object().symmetries)));
    scene.evidence.prior = prior_at(wrong, 3 * kDegree, 0.003);
    scene.evidence.table.reset();
    overruled += right(localize(model, scene.evidence, RandomStream(seed)), model, scene);
  }
  EXPECT_GE(overruled, 4);
}

TEST(Localize, APriorHelpsFewContacts) {
  SceneOptions options;
  options.contacts = 4;
  const geometry::ObjectModel& model = model_of("bracket");
  int with = 0, without = 0;
  constexpr int kScenes = 12;
  LocalizerOptions quick;
  quick.proposals = 30000;
  quick.particles = 600;
  for (std::uint64_t seed = 0; seed < kScenes; ++seed) {
    Scene scene = make_scene(model, options, RandomStream(seed));
    without += right(localize(model, scene.evidence, RandomStream(1), quick), model, scene);
    RandomStream random(seed, "prior");
    Vector6d x;
    x << 6 * kDegree * random.normal3(), 0.006 * random.normal3();
    scene.evidence.prior = prior_at(moved(scene.truth, x), 6 * kDegree, 0.006);
    with += right(localize(model, scene.evidence, RandomStream(1), quick), model, scene);
  }
  EXPECT_GE(with, without + 3);
  EXPECT_GE(with, 7);
}

Posterior posterior_of(const Eigen::Isometry3d& T, double weight, const Matrix6d& covariance) {
  Posterior posterior;
  Mode mode;
  mode.T_frame_object = T;
  mode.weight = weight;
  mode.covariance = covariance;
  posterior.modes.push_back(mode);
  return posterior;
}

TEST(PriorFrom, AddsTheMotionsCovariance) {
  RandomStream random(8);
  const Matrix6d spread = random_covariance(random), motion = random_covariance(random);
  Posterior posterior = posterior_of(random_pose(random), 0.3, spread);
  posterior.modes.push_back(posterior.modes[0]);
  posterior.modes[1].weight = 0.5;
  const PosePrior prior = prior_from(posterior, motion);
  ASSERT_EQ(prior.components.size(), 2U);
  EXPECT_EQ(prior.components[0].weight, 0.5);
  EXPECT_EQ(prior.components[1].weight, 0.3);
  EXPECT_EQ(prior.components[1].T_frame_object.matrix(),
            posterior.modes[0].T_frame_object.matrix());
  const Matrix6d expected = spread + motion + covariance_of(0.5 * kDegree, 0.0005);
  EXPECT_LT((prior.components[1].covariance - expected).norm(), 1e-12);
}

TEST(PriorFrom, SpreadsComponentsAlongAFreeAxis) {
  RandomStream random(9);
  const Eigen::Isometry3d T = random_pose(random);
  Posterior posterior = posterior_of(T, 0.72, covariance_of(1 * kDegree, 0.001));
  for (const double extent : {M_PI, 50 * kDegree}) {
    const FreeAxis axis{0.1 * random.normal3(), random.unit_vector(), extent};
    posterior.modes[0].free_axis = axis;
    const PosePrior prior = prior_from(posterior, Matrix6d::Zero());
    ASSERT_EQ(prior.components.size(), extent > 3 ? 72U : 20U);
    const PoseMixture mixture(prior);
    double total = 0;
    for (const auto& component : prior.components) {
      total += component.weight;
      EXPECT_LT(mode_error(posterior.modes[0], component.T_frame_object, {}).rotation, 1e-6);
      EXPECT_LT(mode_error(posterior.modes[0], component.T_frame_object, {}).translation, 1e-9);
    }
    EXPECT_NEAR(total, 0.72, 1e-12);
    // Even along the arc, and not wide across it.
    for (double angle = -extent + 6 * kDegree; angle <= extent - 6 * kDegree; angle += kDegree) {
      Eigen::Isometry3d at = Eigen::Isometry3d::Identity();
      const Eigen::Matrix3d turn = exp_so3(angle * axis.direction);
      at.linear() = turn * T.linear();
      at.translation() = axis.point + turn * (T.translation() - axis.point);
      EXPECT_GT(mixture.relative_density(search_pose(at)), 0.7);
      at.translation() += 0.012 * axis.direction;
      EXPECT_LT(mixture.relative_density(search_pose(at)), 0.001);
    }
  }
}

TEST(PriorFrom, RefusesWhatIsNoCovarianceOrPosterior) {
  RandomStream random(10);
  const Posterior posterior = posterior_of(random_pose(random), 1, covariance_of(0.1, 0.01));
  Matrix6d motion = Matrix6d::Zero();
  EXPECT_THROW(prior_from({}, motion), BadInput);
  motion(0, 0) = -1;
  EXPECT_THROW(prior_from(posterior, motion), BadInput);
  motion(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(prior_from(posterior, motion), BadInput);
  motion = covariance_of(0.1, 0.1);
  motion(0, 3) = 0.01;
  EXPECT_THROW(prior_from(posterior, motion), BadInput);
}

TEST(Append, SharesTheWeightsHeaviestFirst) {
  PosePrior prior = prior_at(Eigen::Isometry3d::Identity(), 0.1, 0.01);
  prior.components[0].weight = 0.3;
  const auto other = prior_at(Eigen::Isometry3d(Eigen::Translation3d(0.1, 0, 0)), 0.1, 0.01);
  append(other, 0.5, prior);
  ASSERT_EQ(prior.components.size(), 2U);
  EXPECT_DOUBLE_EQ(prior.components[0].weight, 0.5);
  EXPECT_DOUBLE_EQ(prior.components[0].T_frame_object.translation().x(), 0.1);
  EXPECT_DOUBLE_EQ(prior.components[1].weight, 0.3);
}

TEST(SpreadElsewhere, KeepsTheProbabilityHoweverNarrowThePrior) {
  constexpr double kElsewhere = 0.004, kPoses = 8 * M_PI * M_PI * 1e-3;  // rad^3 m^3
  for (const double narrow : {0.02, 0.2, 1.0}) {
    PosePrior prior = prior_at(Eigen::Isometry3d::Identity(), narrow * 0.2, narrow * 0.01);
    spread_elsewhere(kElsewhere, prior);
    EXPECT_NEAR(prior.floor * peak(prior.components[0]) * kPoses, kElsewhere, 1e-9) << narrow;
  }
  PosePrior wide = prior_at(Eigen::Isometry3d::Identity(), 3, 1);
  spread_elsewhere(kElsewhere, wide);
  EXPECT_LE(wide.floor, 0.5);
}

template <class Spoil>
void expect_bad(const std::string& words, Spoil&& spoil) {
  Evidence evidence;
  evidence.prior = prior_at(Eigen::Isometry3d::Identity(), 0.1, 0.01);
  evidence.prior->components[0].weight = 0.6;
  evidence.prior->components.push_back(evidence.prior->components[0]);
  evidence.prior->components[1].weight = 0.4;
  spoil(*evidence.prior);
  try {
    localize(model_of("box"), evidence, RandomStream(1));
    FAIL() << "accepted; expected a complaint about " << words;
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(Localize, RefusesAPriorThatIsNone) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  expect_bad("0 weights", [](PosePrior& p) { p.components.clear(); });
  expect_bad("component 1: weight is -0.4", [](PosePrior& p) { p.components[1].weight = -0.4; });
  expect_bad("is 1.1, not", [](PosePrior& p) { p.components[1].weight = 0.5; });
  expect_bad("floor is 0", [](PosePrior& p) { p.floor = 0; });
  expect_bad("floor is nan", [](PosePrior& p) { p.floor = kNan; });
  expect_bad("component 1: translation",
             [](PosePrior& p) { p.components[1].T_frame_object(0, 3) = kNan; });
  expect_bad("component 0: its rotation",
             [](PosePrior& p) { p.components[0].T_frame_object(0, 0) = 2; });
  expect_bad("component 1: covariance holds",
             [](PosePrior& p) { p.components[1].covariance(2, 2) = kNan; });
  expect_bad("not symmetric, by 0.001",
             [](PosePrior& p) { p.components[1].covariance(2, 3) += 0.001; });
  expect_bad("least eigenvalue -0.5",
             [](PosePrior& p) { p.components[0].covariance(5, 5) = -0.5; });
}

}  // namespace
}  // namespace palpate::localization
