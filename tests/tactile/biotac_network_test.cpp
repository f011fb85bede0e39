// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <limits>

#include "core/error_message.hpp"
#include "palpate/core/array_file.hpp"
#include "palpate/tactile/biotac/network.hpp"
#include "tactile/biotac/backpropagation.hpp"

namespace palpate::tactile {
namespace {

BiotacDatasetOptions few(std::uint64_t seed) {
  BiotacDatasetOptions options;
  options.trajectories = 12;
  options.seconds = 1.5;
  options.seed = seed;
  return options;
}

TEST(BiotacDataset, HasTheLayoutOfTheThesis) {
  const auto frames = simulate_biotac(few(1));
  const auto rows = biotac_dataset(frames);
  ASSERT_EQ(rows.cols(), 35);
  const auto& frame = frames[7];
  EXPECT_EQ(rows(7, 0), frame.reading.pdc);
  EXPECT_EQ(rows(7, 22), frame.reading.electrodes[18]);
  EXPECT_EQ(rows(7, 23), frame.f1.x());
  EXPECT_EQ(rows(7, 31), frame.f3.z());
  EXPECT_EQ(rows(7, 34), frame.p.z());
  EXPECT_EQ(dataset_csv(frames).substr(0, 15), "trajectory,pdc,");
  // Frames are 50 ms apart, so that the force 100 ms ago is that of the last but one.
  EXPECT_LT((frames[7].f2 - frames[5].f1).norm(), 1e-9);
}

TEST(BiotacNetwork, HasTheShapesOfArchitectureB) {
  const BiotacNetwork network;
  Eigen::Index parameters = 0;
  for (const auto& block : network.blocks()) parameters += block.parameters().size();
  // 3-512-512-512-64, 9-256-256-256-64, 1-256-23, 64-256-256-23
  EXPECT_EQ(parameters, 560192 + 150592 + 6423 + 88343);
  EXPECT_EQ(network.blocks()[2].activation(), numerics::Activation::sigmoid);
}

TEST(BiotacNetwork, BackpropagatesTheGradient) {
  auto blocks = BiotacNetwork(3).blocks();
  const Eigen::MatrixXf x = Eigen::MatrixXf::Random(13, 4), g = Eigen::MatrixXf::Random(23, 4);
  const auto gradient = backward(blocks, forward(blocks, x), g);
  const auto loss = [&] { return forward(blocks, x).output.cwiseProduct(g).cast<double>().sum(); };
  for (std::size_t b = 0; b < 4; ++b) {
    Eigen::VectorXf parameters = blocks[b].parameters();
    Eigen::VectorXf slopes = gradient[b];
    auto layers = numerics::mlp_layers(blocks[b].sizes(), parameters);
    const auto expected = numerics::mlp_layers(blocks[b].sizes(), slopes);
    for (std::size_t k = 0; k < layers.size(); ++k) {
      float& weight = layers[k].weights(1, 0);
      const float kept = weight, step = 0.01f;
      const auto with = [&](float value) {
        weight = value;
        blocks[b].set_parameters(parameters);
        return loss();
      };
      const double up = with(kept + step), down = with(kept - step);
      with(kept);
      const double slope = expected[k].weights(1, 0);
      EXPECT_NEAR((up - down) / (2 * step), slope, 0.02 * std::abs(slope) + 2e-3)
          << "mlp " << b + 1 << " layer " << k + 1;
    }
  }
}

TEST(BiotacNetwork, LearnsToFollowItsInputs) {
  const auto rows = biotac_dataset(simulate_biotac(few(2)));
  const auto inputs = network_inputs(rows), outputs = network_outputs(rows);
  BiotacNetwork network(1);
  NetworkTrainingOptions options;
  options.epochs = 12;
  options.batch = 16;
  const double error = network.train(inputs, outputs, options);
  EXPECT_LT(error, 0.35);  // 1 where the output does not depend on the input
  EXPECT_GT(shuffled_input_losses(network, inputs, outputs, 1)[0], 0.02);
}

TEST(BiotacNetwork, RefusesWeightsThatAreNotItsOwn) {
  const std::string good = BiotacNetwork(1).bytes();
  const auto says = [](const std::string& bytes) {
    return error_message([&] { (void)BiotacNetwork::parse(bytes, "b.model"); });
  };
  EXPECT_EQ(says(good), "");
  EXPECT_EQ(BiotacNetwork::parse(good, "b.model").bytes(), good);
  EXPECT_NE(says(good.substr(0, good.size() - 9)).find("cut short"), std::string::npos);
  auto version = good;
  version.replace(version.find(" 1\n"), 3, " 7\n");
  EXPECT_NE(says(version).find("version 7"), std::string::npos);
  ArrayFile thin("biotac-network", 1);
  thin.add("input_mean", Eigen::MatrixXf::Zero(12, 1));
  EXPECT_NE(says(thin.bytes()).find("12 x 1, not 13 x 1"), std::string::npos);
}

TEST(BiotacNetwork, RefusesInputsItCannotUse) {
  const BiotacNetwork network;
  EXPECT_NE(error_message([&] { (void)network(Eigen::MatrixXf::Zero(12, 1)); }).find("12 inputs"),
            std::string::npos);
  const Eigen::MatrixXf infinite =
      Eigen::MatrixXf::Constant(13, 1, std::numeric_limits<float>::infinity());
  EXPECT_NE(error_message([&] { (void)network(infinite); }).find("not finite"), std::string::npos);
}

}  // namespace
}  // namespace palpate::tactile
