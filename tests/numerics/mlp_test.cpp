// SPDX-License-Identifier: Apache-2.0
#include "palpate/numerics/mlp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "palpate/core/error.hpp"

namespace palpate::numerics {
namespace {

Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index cols, palpate::RandomStream& random) {
  return Eigen::MatrixXd::NullaryExpr(rows, cols, [&] { return random.normal(); });
}

class MlpTest : public testing::TestWithParam<Activation> {
 protected:
  palpate::RandomStream random{7};
  Mlp network{{3, 5, 4, 2}, GetParam(), random};
};

TEST_P(MlpTest, OutputsOfABatchAreThoseOfItsColumns) {
  const Eigen::MatrixXd inputs = random_matrix(3, 6, random);
  const Eigen::MatrixXd outputs = network(inputs);
  for (Eigen::Index i = 0; i < 6; ++i) {
    EXPECT_LT((network(inputs.col(i)) - outputs.col(i)).norm(), 1e-14);
  }
}

TEST_P(MlpTest, GradientIsThatOfDifferences) {
  const Eigen::MatrixXd inputs = random_matrix(3, 6, random), weights = random_matrix(2, 6, random);
  const Eigen::VectorXd gradient = network.gradient(network.trace(inputs), weights);
  const Eigen::VectorXd at = network.parameters();
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    const auto loss = [&](double step) {
      Eigen::VectorXd moved = at;
      moved[i] += step;
      network.set_parameters(moved);
      return network(inputs).cwiseProduct(weights).sum();
    };
    EXPECT_NEAR(gradient[i], (loss(1e-6) - loss(-1e-6)) / 2e-6, 1e-6);
  }
}

TEST_P(MlpTest, GradientByTheInputsIsThatOfDifferences) {
  const Eigen::MatrixXd inputs = random_matrix(3, 1, random), weights = random_matrix(2, 1, random);
  Eigen::MatrixXd gradient;
  network.gradient(network.trace(inputs), weights, &gradient);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::VectorXd step = 1e-6 * Eigen::VectorXd::Unit(3, i);
    const Eigen::MatrixXd change = network(inputs + step) - network(inputs - step);
    EXPECT_NEAR(gradient(i, 0), change.cwiseProduct(weights).sum() / 2e-6, 1e-6);
  }
}

TEST_P(MlpTest, FloatsGiveTheSameToTheirPrecision) {
  const FloatMlp rounded(network.sizes(), GetParam(), network.parameters().cast<float>());
  const Eigen::MatrixXd inputs = random_matrix(3, 6, random);
  EXPECT_LT((rounded(inputs.cast<float>()).cast<double>() - network(inputs)).norm(), 1e-5);
}

TEST_P(MlpTest, DirectionalIsTheTransposeOfTheGradient) {
  const Eigen::MatrixXd inputs = random_matrix(3, 6, random), weights = random_matrix(2, 6, random);
  const Eigen::VectorXd direction = random_matrix(network.parameters().size(), 1, random);
  const auto trace = network.trace(inputs);
  EXPECT_NEAR(network.directional(trace, direction).cwiseProduct(weights).sum(),
              network.gradient(trace, weights).dot(direction), 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Activations, MlpTest,
                         testing::Values(Activation::tanh, Activation::relu, Activation::sigmoid));

TEST(Mlp, FitsASmoothFunction) {
  palpate::RandomStream random(3);
  Mlp network({1, 16, 1}, Activation::tanh, random);
  const Eigen::MatrixXd inputs = Eigen::RowVectorXd::LinSpaced(200, -2, 2);
  const Eigen::MatrixXd targets = inputs.array().sin();
  RegressionOptions options;
  options.epochs = 300;
  options.rate = 1e-2;
  // A straight line through sin leaves a mean squared error of 0.02.
  EXPECT_LT(fit_regression(network, inputs, targets, options, random), 1e-3);
}

TEST(Mlp, RejectsWhatDoesNotFit) {
  palpate::RandomStream random(1);
  EXPECT_THROW(Mlp({3}, Activation::tanh, random), palpate::BadInput);
  EXPECT_THROW(Mlp({3, 0, 1}, Activation::tanh, random), palpate::BadInput);
  EXPECT_THROW(Mlp({2, 1}, Activation::tanh, Eigen::VectorXd::Zero(2)), palpate::BadInput);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Mlp({2, 1}, Activation::tanh, Eigen::Vector3d(0, nan, 0)), palpate::BadInput);
  Mlp network({2, 1}, Activation::tanh, random);
  EXPECT_THROW(network(Eigen::MatrixXd::Zero(3, 1)), palpate::BadInput);
  EXPECT_THROW(
      fit_regression(network, Eigen::MatrixXd::Zero(2, 3), Eigen::MatrixXd::Zero(1, 2), {}, random),
      palpate::BadInput);
  EXPECT_THROW(fit_regression(network, Eigen::MatrixXd::Constant(2, 1, nan),
                              Eigen::MatrixXd::Zero(1, 1), {}, random),
               palpate::BadInput);
}

TEST(Adam, FirstStepIsTheRateWhateverTheGradientsSize) {
  Adam adam(2, 0.1);
  const Eigen::VectorXd after = adam.step(Eigen::Vector2d(1, 1), Eigen::Vector2d(1e-3, -50));
  EXPECT_NEAR(after[0], 0.9, 1e-5);
  EXPECT_NEAR(after[1], 1.1, 1e-5);
}

}  // namespace
}  // namespace palpate::numerics
