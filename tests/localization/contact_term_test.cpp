// SPDX-License-Identifier: Apache-2.0
#include "localization/likelihood/contact_term.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "localization/likelihood/surface_error.hpp"
#include "localization/scenes.hpp"
#include "palpate/core/se3.hpp"

namespace palpate::localization {
namespace {

constexpr double kOffset = 0.003;      // m, at which contacts are compared
constexpr double kPointSigma = 0.001;  // m

/// Contacts on the box's face at +x, well inside it, where the distance is exactly linear.
Evidence on_a_face(int count) {
  const auto bounds = model_of("box").bounds();
  Evidence evidence;
  evidence.false_contact_share = 1e-9;
  evidence.noise_scale_prior = evidence.size_prior = 0;
  for (int k = 0; k < count; ++k) {
    tactile::Contact contact;
    contact.p = {static_cast<double>(bounds.max().x()), 0.004 * k - 0.008, 0.006 * (k % 3)};
    contact.n = Eigen::Vector3d::UnitX();
    contact.point_sigma = kPointSigma;
    evidence.contacts.push_back(contact);
  }
  return evidence;
}

CommonModeBias offset_of_all(const Evidence& evidence, double sigma) {
  CommonModeBias offset;
  offset.sigma = sigma;
  for (std::size_t k = 0; k < evidence.contacts.size(); ++k) offset.members.push_back({k});
  return offset;
}

double energy_at(const Evidence& evidence, double x) {
  const ContactTerm term(model_of("box"), evidence, kOffset, 1.0);
  SearchPose pose;
  pose.t.x() = static_cast<float>(x);
  return static_cast<double>(term.energy(pose, kNoBound));
}

TEST(ContactTerm, IntegratesASharedOffsetOutAsACovariance) {
  for (const int count : {1, 3, 5}) {
    for (const double sigma : {0.0005, 0.002}) {
      Evidence evidence = on_a_face(count);
      evidence.offsets = {offset_of_all(evidence, sigma)};
      const double start = energy_at(evidence, 0);
      for (const double x : {-0.001, 0.0015}) {
        // x^2 1'(sp^2 I + so^2 1 1')^-1 1 / 2
        const double expected =
            0.5 * x * x * count / (kPointSigma * kPointSigma + count * sigma * sigma);
        EXPECT_NEAR(energy_at(evidence, x) - start, expected, 0.02 * expected + 1e-3);
      }
      // ln det(I + so^2 1 1' / sp^2) / 2 is what it costs
      const double ratio = sigma * sigma / (kPointSigma * kPointSigma);
      Evidence without = evidence;
      without.offsets.clear();
      EXPECT_NEAR(start - energy_at(without, 0), 0.5 * std::log(1 + count * ratio), 0.01);
    }
  }
}

TEST(ContactTerm, OppositeOffsetsOfATurnedHandDoNotHideThePlace) {
  Evidence evidence = on_a_face(4);
  CommonModeBias offset = offset_of_all(evidence, 0.003);
  evidence.offsets = {offset};
  const double alike = energy_at(evidence, 0.001) - energy_at(evidence, 0);
  const Eigen::Matrix3d turn = exp_so3({0, 0, M_PI});
  for (std::size_t k = 0; k < 4; k += 2) offset.members[k].R_frame_offset = turn;
  evidence.offsets = {offset};
  const double turned = energy_at(evidence, 0.001) - energy_at(evidence, 0);
  EXPECT_LT(alike, 0.1);
  EXPECT_NEAR(turned, 4 * 0.5, 0.1);  // four contacts one sigma off
}

TEST(ContactTerm, LinearizesWhatItIntegrates) {
  Evidence evidence = on_a_face(5);
  evidence.offsets = {offset_of_all(evidence, 0.002)};
  const ContactTerm term(model_of("box"), evidence, kOffset, 1.0);
  SearchPose pose;
  pose.t.x() = 0.001F;
  NormalEquations equations;
  term.linearize(pose, equations);
  const double expected = 5 / (kPointSigma * kPointSigma + 5 * 0.002 * 0.002);
  EXPECT_NEAR(equations.H(3, 3), expected, 0.02 * expected);
  EXPECT_NEAR(equations.g[3], 0.001 * expected, 0.02 * 0.001 * expected);
}

/// Contacts as a scaled face or other noise would have them, their energy up to a constant.
double likelihood_at(Evidence evidence, const Hypothesis& as, double x) {
  for (auto& contact : evidence.contacts) {
    contact.point_sigma *= as.point_noise;
    contact.normal_sigma *= as.normal_noise;
  }
  evidence.noise_scale_prior = evidence.size_prior = 0;
  const double half_width = static_cast<double>(model_of("box").bounds().max().x());
  const double e = energy_at(evidence, x + as.growth * half_width);
  // Its peak is lower for wider noise, by 2 for the point and about 4 for the normal if doubled.
  return std::exp(-e) *
         std::pow(evidence.contacts[0].point_sigma / kPointSigma * std::pow(as.normal_noise, 2),
                  -1.0 * static_cast<double>(evidence.contacts.size()));
}

TEST(ContactTerm, HypothesesAreMixtures) {
  Evidence evidence = on_a_face(4);
  evidence.noise_scale_prior = 0.3;
  evidence.size_prior = 0.2;
  const auto mixed = [&](double x) {
    double sum = 0;
    for (const Hypothesis& as : hypotheses(evidence)) {
      sum += as.share * likelihood_at(evidence, as, x);
    }
    return -std::log(sum);
  };
  for (const double x : {0.0005, 0.001, 0.002, 0.003}) {
    EXPECT_NEAR(energy_at(evidence, x) - energy_at(evidence, 0), mixed(x) - mixed(0), 0.1) << x;
  }
}

/// Energy of one normal, of eight, that is 60 deg off.
double cost_of_an_outlier(double noise_scale_prior) {
  Evidence evidence = on_a_face(8);
  evidence.noise_scale_prior = noise_scale_prior;
  const double fitting = energy_at(evidence, 0);
  auto& outlier = evidence.contacts[3];
  outlier.n = exp_so3({0, 0, M_PI / 3}) * outlier.n;
  outlier.p += kOffset * (Eigen::Vector3d::UnitX() - outlier.n);  // where it is compared stays
  return energy_at(evidence, 0) - fitting;
}

TEST(ContactTerm, BearsASingleNormalThatIsAnOutlier) {
  const double q = 0.5 / std::pow(tactile::Contact{}.normal_sigma, 2);
  EXPECT_NEAR(cost_of_an_outlier(0), q, 0.05 * q);
  const double share = 0.4 / 8;  // the others fit as with half of the noise
  EXPECT_NEAR(cost_of_an_outlier(0.4), 4 * q / 9 - std::log(share / 9), 0.5);
}

TEST(Hypotheses, BeginWithWhatIsStatedAndSumToOne) {
  for (const bool offsets : {false, true}) {
    Evidence evidence = on_a_face(3);
    evidence.noise_scale_prior = 0.3;
    evidence.size_prior = 0.2;
    if (offsets) evidence.offsets = {offset_of_all(evidence, 0.001)};
    double sum = 0;
    for (const Hypothesis& as : hypotheses(evidence)) sum += as.share;
    EXPECT_NEAR(sum, 1, 1e-12);
    const Hypothesis stated = hypotheses(evidence).front();
    EXPECT_EQ(stated.point_noise, 1);
    EXPECT_EQ(stated.growth, 0);
    evidence.noise_scale_prior = evidence.size_prior = 0;
    EXPECT_EQ(hypotheses(evidence).size(), 1u);
  }
}

TEST(ContactTerm, MisfitIsNoneWhereAllFitsAndOneWhereNothingDoes) {
  Evidence evidence = on_a_face(4);
  evidence.noise_scale_prior = 0.4;
  const ContactTerm term(model_of("box"), evidence, kOffset, 1.0);
  SearchPose pose;
  EXPECT_LT(term.misfit(pose), 0.05F);
  EXPECT_GT(term.misfit(pose), -0.2F);  // half the noise: ln 8 of some 10 a contact at most
  pose.t.x() = 1;
  EXPECT_NEAR(term.misfit(pose), 1, 1e-3);
}

TEST(ContactTerm, StopsEarlyOnlyAboveTheBound) {
  RandomStream random(4);
  const geometry::ObjectModel& model = model_of("bunny");
  for (int i = 0; i < 20; ++i) {
    SceneOptions options;
    const Scene scene = make_scene(model, options, random.fork(std::to_string(i)));
    Evidence evidence = scene.evidence;
    evidence.offsets = {offset_of_all(evidence, 0.001)};
    const ContactTerm term(model, evidence, kOffset, 1.0);
    SearchPose pose{scene.truth.linear().cast<float>(), scene.truth.translation().cast<float>()};
    pose.t += (0.003 * random.normal3()).cast<float>();
    const float all = term.energy(pose, kNoBound);
    EXPECT_EQ(term.energy(pose, all), all);
    EXPECT_GT(term.energy(pose, 0.5F * all), 0.5F * all);
  }
}

/// Next to an edge the point's error turns the normal of the surface: a tilt has less information
/// there.
TEST(ContactTerm, TakesNormalsForLessExactWhereTheSurfaceIsCurved) {
  const auto& model = model_of("box");
  const Eigen::Vector3d corner = model.bounds().max().cast<double>();
  Evidence evidence = on_a_face(2);
  const auto tilted_energy = [&](const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
    evidence.contacts[0].p = evidence.contacts[1].p = p;
    evidence.contacts[0].n = n;
    evidence.contacts[1].n = exp_so3({0, 0, 0.3}) * n;
    const ContactTerm term(model, evidence, kOffset, 1.0);
    return term.contact_energy(1, SearchPose{}) - term.contact_energy(0, SearchPose{});
  };
  const float on_face = tilted_energy({corner.x(), 0, 0}, Eigen::Vector3d::UnitX());
  const float on_edge =
      tilted_energy({corner.x(), 0, corner.z()}, Eigen::Vector3d(1, 0, 1).normalized());
  EXPECT_GT(on_face, 0.5F);
  EXPECT_LT(on_edge, 0.8F * on_face);
}

TEST(ContactTerm, ComparesAContactWithoutNormalByItsDistanceAlone) {
  Evidence evidence = on_a_face(3);
  for (auto& contact : evidence.contacts) contact.n.setZero();
  const double start = energy_at(evidence, 0);
  EXPECT_NEAR(start, 0, 1e-3);
  for (const double x : {-0.002, -0.001, 0.0015}) {
    const double expected = 3 * 0.5 * x * x / (kPointSigma * kPointSigma);
    EXPECT_NEAR(energy_at(evidence, x) - start, expected, 0.03 * expected) << x;
  }
  for (auto& contact : evidence.contacts) contact.normal_sigma = 1e-3;
  EXPECT_EQ(energy_at(evidence, 0), start);  // no normal, no error of it
}

TEST(ContactTerm, LinearizesContactsWithoutNormals) {
  Evidence evidence = on_a_face(1);
  evidence.contacts[0].n.setZero();
  const ContactTerm term(model_of("box"), evidence, kOffset, 1.0);
  SearchPose pose;
  pose.t.x() = 0.001F;
  NormalEquations equations;
  term.linearize(pose, equations);
  EXPECT_NEAR(equations.H(3, 3) * kPointSigma * kPointSigma, 1, 0.02);
  EXPECT_NEAR(equations.g(3) / equations.H(3, 3), 0.001, 1e-5);
  EXPECT_NEAR(equations.H.diagonal().tail<2>().norm(), 0, 1);  // along the face: nothing
}

/// Likelihood relative to that of a false contact, exp(cap - E): 1 + the mean of A e^-q.
TEST(ContactTerm, AveragesTheOddsOfCandidates) {
  Evidence alone = on_a_face(1);
  Evidence group = on_a_face(1);
  group.contacts[0].group = 7;
  EXPECT_EQ(energy_at(group, 0.001), energy_at(alone, 0.001));
  group.contacts.push_back(group.contacts[0]);
  group.contacts[1].p.x() += 0.05;  // in the air
  const double start = energy_at(group, 0);
  const double expected = 0.5 * 0.0015 * 0.0015 / (kPointSigma * kPointSigma);
  EXPECT_NEAR(energy_at(group, 0.0015) - start, expected, 0.03 * expected);
  const ContactTerm term(model_of("box"), group, kOffset, 1.0);
  EXPECT_EQ(term.size(), 1U);
  EXPECT_EQ(term.unexplained(SearchPose{}), 0);
  SearchPose away;
  away.t.y() = 1;
  EXPECT_EQ(term.unexplained(away), 1);
}

TEST(ContactTerm, EqualCandidatesCountAsOne) {
  Evidence evidence = on_a_face(2);
  evidence.contacts[0].group = 1;
  evidence.contacts[1].group = 2;
  Evidence copies = evidence;
  for (int i = 0; i < 7; ++i) {
    for (const auto& contact : evidence.contacts) copies.contacts.push_back(contact);
  }
  for (const double shift : {0.0, 0.001, 0.003}) {
    const double energy = energy_at(copies, shift);
    EXPECT_NEAR(energy, energy_at(evidence, shift), 1e-4) << shift;
    EXPECT_GE(energy, -1e-5) << shift;
  }
}

TEST(SurfaceError, IsAddedToThatOfEachContact) {
  Evidence evidence = on_a_face(3);
  evidence.surface_sigma = 0.0003;
  evidence.planes = {{Eigen::Vector3d::UnitZ(), 0, 0.0004}};
  const Evidence widened = with_surface_error(evidence);
  EXPECT_NEAR(widened.planes[0].sigma, 0.0005, 1e-12);
  for (const auto& contact : widened.contacts) {
    EXPECT_NEAR(contact.point_sigma, std::hypot(kPointSigma, 0.0003), 1e-12);
    EXPECT_GT(contact.normal_sigma, evidence.contacts[0].normal_sigma);
  }
  EXPECT_EQ(with_surface_error(widened).contacts[0].point_sigma, widened.contacts[0].point_sigma);
  evidence.surface_sigma = 0;
  EXPECT_EQ(with_surface_error(evidence).contacts[0].point_sigma, kPointSigma);
}

}  // namespace
}  // namespace palpate::localization
