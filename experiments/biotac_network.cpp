// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "experiment.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/file.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/tactile/biotac/network.hpp"

namespace {

using namespace palpate;
using namespace palpate::experiment;

constexpr const char* kModel = "models/biotac_network.model";  // an asset

struct Network {
  tactile::BiotacNetwork network;
  Eigen::MatrixXf inputs, outputs;  // of unseen trajectories
};

/// The shipped weights; for a quick run ones trained for a moment.
/// @throws BadInput without the shipped weights
tactile::BiotacNetwork network_of(const Options& options) {
  if (!options.quick) {
    const auto path = asset(kModel);
    return tactile::BiotacNetwork::parse(read_file(path), path.string());
  }
  tactile::BiotacDatasetOptions data;
  data.trajectories = 20;
  data.seconds = 1;
  const auto rows = tactile::biotac_dataset(tactile::simulate_biotac(data));
  tactile::NetworkTrainingOptions training;
  training.epochs = 4;
  tactile::BiotacNetwork network;
  network.train(tactile::network_inputs(rows), tactile::network_outputs(rows), training);
  return network;
}

Network unseen(const Options& options) {
  tactile::BiotacDatasetOptions data;
  data.seed = options.seed;
  data.trajectories = options.quick ? 5 : 80;
  const auto rows = tactile::biotac_dataset(tactile::simulate_biotac(data));
  return {.network = network_of(options),
          .inputs = tactile::network_inputs(rows),
          .outputs = tactile::network_outputs(rows)};
}

/// What touches the sensor in figs 5.9 and B.1 to B.3.
struct Surface {
  std::string name;
  std::function<tactile::SurfaceDistance(const Eigen::Vector3d& p)> at;
};

std::vector<Surface> surfaces() {
  // Each meets the skin at p from below (outward normal +z).
  const auto flat = [](const Eigen::Vector3d& p) {
    return [p](const Eigen::Vector3d& x) { return x.z() - p.z(); };
  };
  const auto edge = [](const Eigen::Vector3d& p) {
    return [p](const Eigen::Vector3d& x) {
      return std::hypot(x.y() - p.y(), x.z() - p.z() + 0.001) - 0.001;
    };
  };
  const auto ball = [](double radius) {
    return [radius](const Eigen::Vector3d& p) {
      const Eigen::Vector3d center = p - radius * Eigen::Vector3d::UnitZ();
      return [center, radius](const Eigen::Vector3d& x) { return (x - center).norm() - radius; };
    };
  };
  return {{"flat", flat}, {"edge", edge}, {"smooth", ball(0.05)}, {"corner", ball(0.001)}};
}

/// 30 s of a finger that presses and rubs.
std::vector<tactile::BiotacFrame> press(const Surface& surface, double seconds,
                                        std::uint64_t seed) {
  const tactile::BiotacSkin skin;
  tactile::BiotacSensor sensor(skin, {}, RandomStream(seed, surface.name));
  const auto contact_at = [&](double t) {
    const double normal = std::max(0.05, 2 * std::sin(0.2 * t) * std::sin(0.2 * t) + 0.3);
    const Eigen::Vector3d p(-0.004 + 0.003 * std::sin(0.5 * t), 0, -skin.options().radius);
    return hand::TipContact{
        .p = p,
        .n = Eigen::Vector3d::UnitZ(),
        .f = {0.4 * normal * std::sin(1.1 * t), 0.4 * normal * std::sin(0.7 * t + 1), -normal}};
  };
  std::vector<tactile::BiotacFrame> frames;
  for (int k = 0; k * tactile::kBiotacPeriod < seconds; ++k) {
    const double t = k * tactile::kBiotacPeriod;
    const auto contact = contact_at(t);
    tactile::BiotacFrame frame;
    frame.time = t;
    frame.p = contact.p;
    frame.n = contact.n;
    frame.f1 = contact.f;
    frame.f2 = contact_at(t - 0.1).f;
    frame.f3 = contact_at(t - 0.2).f;
    frame.reading = sensor.step(skin.press({&contact, 1}, surface.at(contact.p)));
    frames.push_back(frame);
  }
  return frames;
}

plotting::LineSeries line(std::string name, const std::vector<double>& x,
                          const Eigen::VectorXf& y) {
  return {.name = std::move(name), .x = x, .y = {y.begin(), y.end()}};
}

/// Inputs and outputs over time, as in the thesis' figures.
void draw(const Options& options, const std::string& name, const std::vector<double>& time,
          const Eigen::MatrixXf& inputs, const Eigen::MatrixXf& outputs) {
  plotting::Plot forces;
  forces.title = name + ": force on the object";
  forces.x.label = "time (s)";
  forces.y.label = "force (N)";
  for (int k = 0; k < 3; ++k) {
    forces.series.emplace_back(line(std::string(1, "xyz"[k]), time, inputs.row(3 + k)));
  }
  plotting::Plot electrodes;
  electrodes.title = name + ": electrodes of the network";
  electrodes.x.label = "time (s)";
  electrodes.y.label = "counts";
  for (const int e : {1, 4, 7, 8, 10, 14, 17, 18}) {
    electrodes.series.emplace_back(line(fmt::format("e{}", e), time, outputs.row(3 + e)));
  }
  publish_figure(options, name + "-forces", plotting::to_svg(forces));
  publish_figure(options, name + "-electrodes", plotting::to_svg(electrodes));
}

std::vector<double> times_of(const std::vector<tactile::BiotacFrame>& frames) {
  std::vector<double> time;
  for (const auto& frame : frames) time.push_back(frame.time);
  return time;
}

/// Fig. 5.8(a): the electrodes in the finger's plane, seen obliquely, with their changes as stems.
plotting::Plot activations_3d(const Eigen::VectorXd& change) {
  const auto p = tactile::electrode_positions();
  plotting::Plot plot;
  plot.title = "changes of the electrodes over the finger, seen obliquely";
  plot.x.label = "y + x / 3 (mm)";
  plot.y.label = "x / 2 (mm), stems: change / 10 (counts)";
  for (int e = 0; e < tactile::kElectrodes; ++e) {
    const double x = 1e3 * p(0, e), y = 1e3 * p(1, e);
    const double across = y + x / 3, up = x / 2;
    const std::string name = fmt::format("e{}", e + 1);
    plot.series.emplace_back(
        plotting::LineSeries{.name = name, .x = {across, across}, .y = {up, up + change[e] / 10}});
  }
  plot.width = 700;
  plot.height = 560;
  return plot;
}

/// Fig. 5.8: where the electrodes lie, with their change under a flat touch.
void draw_maps(const Options& options, const Eigen::VectorXd& change) {
  const auto p = tactile::electrode_positions();
  Table table({"electrode", "x mm", "y mm", "z mm", "change, counts"});
  plotting::Plot flat;
  flat.title = "electrodes seen from the sensing side";
  flat.x.label = "y (mm)";
  flat.y.label = "x (mm)";
  plotting::Plot solid;
  solid.title = "change of the electrodes along the finger";
  solid.x.label = "x (mm)";
  solid.y.label = "change (counts)";
  for (int e = 0; e < tactile::kElectrodes; ++e) {
    const Eigen::Vector3d mm = 1e3 * p.col(e);
    const std::string name = fmt::format("e{}", e + 1);
    table.add_row({name, fmt::format("{:.2f}", mm.x()), fmt::format("{:.2f}", mm.y()),
                   fmt::format("{:.2f}", mm.z()), fmt::format("{:.0f}", change[e])});
    flat.series.emplace_back(plotting::ScatterSeries{.name = name, .x = {mm.y()}, .y = {mm.x()}});
    solid.series.emplace_back(
        plotting::ScatterSeries{.name = name, .x = {mm.x()}, .y = {change[e]}});
  }
  flat.width = 420;
  flat.height = 700;
  publish_figure(options, "electrode-activations", plotting::to_svg(activations_3d(change)));
  publish_figure(options, "electrode-map", plotting::to_svg(flat));
  publish_figure(options, "electrode-profile", plotting::to_svg(solid));
  table.publish(options, "electrodes", "Electrodes under a flat touch (fig. 5.8)");
}

constexpr std::string_view kDigits =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string encode_base64(std::string_view bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (int k = 3; k >= 0; --k) text += kDigits[group >> (6 * k) & 63];
  }
  return text;
}

/// A row of weights as the port loads it: the stored base64 text is encoded once more, and the
/// characters are read as float32. The row comes out longer than it was.
std::vector<float> misread(const Eigen::VectorXf& row) {
  const std::string_view bytes(reinterpret_cast<const char*>(row.data()),
                               static_cast<std::size_t>(row.size()) * sizeof(float));
  const std::string twice = encode_base64(encode_base64(bytes));
  std::vector<float> values(twice.size() / sizeof(float));
  std::memcpy(values.data(), twice.data(), values.size() * sizeof(float));
  return values;
}

/// The network's layers as the port loads them; of each row as many values as there is room for.
tactile::NetworkBlocks misread(tactile::NetworkBlocks blocks) {
  for (auto& block : blocks) {
    Eigen::VectorXf parameters = block.parameters();
    for (auto& layer : numerics::mlp_layers(block.sizes(), parameters)) {
      const auto read = [](Eigen::Ref<Eigen::VectorXf> row) {
        const auto values = misread(Eigen::VectorXf(row));
        for (Eigen::Index i = 0; i < row.size(); ++i) row[i] = values[static_cast<std::size_t>(i)];
      };
      for (Eigen::Index in = 0; in < layer.weights.cols(); ++in) read(layer.weights.col(in));
      read(layer.biases);
    }
    block.set_parameters(parameters);
  }
  return blocks;
}

/// A pass that, where asked to, normalises every layer's output to mean 0 and deviation 1.
Eigen::MatrixXd pass(const numerics::FloatMlp& block, Eigen::MatrixXd values, bool normalise) {
  Eigen::VectorXf parameters = block.parameters();
  const auto layers = numerics::mlp_layers(block.sizes(), parameters);
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const auto& layer = layers[i];
    Eigen::MatrixXd next = layer.weights.cast<double>() * values;
    next.colwise() += layer.biases.cast<double>();
    if (!normalise) next = next.cast<float>().cast<double>();  // as the port, in float32
    for (Eigen::Index k = 0; normalise && k < next.cols(); ++k) {
      const double mean = next.col(k).mean();
      const double sd = std::sqrt((next.col(k).array() - mean).square().mean()) + 1e-30;
      next.col(k) = (next.col(k).array() - mean) / sd;
    }
    values = std::move(next);
    if (i + 1 == layers.size()) continue;
    if (block.activation() == numerics::Activation::relu) values = values.cwiseMax(0.0);
    if (block.activation() == numerics::Activation::sigmoid) {
      values = (1 / (1 + (-values.array()).exp())).matrix();
    }
  }
  return values;
}

Eigen::MatrixXd run_port(const tactile::NetworkBlocks& blocks, const Eigen::MatrixXd& inputs,
                         bool normalise) {
  const Eigen::MatrixXd position = pass(blocks[0], inputs.topRows<3>(), normalise);
  const Eigen::MatrixXd forces = pass(blocks[1], inputs.middleRows<9>(3), normalise);
  const Eigen::MatrixXd temperature = pass(blocks[2], inputs.bottomRows<1>(), normalise);
  return pass(blocks[3], position.cwiseProduct(forces), normalise) + temperature;
}

/// The failure of the thesis: finite share of the outputs, and how much they follow the inputs.
void explain_failure(const Options& options, const Network& network) {
  const Eigen::Index count = std::min<Eigen::Index>(200, network.inputs.cols());
  Eigen::MatrixXd x = network.inputs.leftCols(count).cast<double>();
  x.colwise() -= x.rowwise().mean().eval();
  const Eigen::VectorXd sd =
      (x.rowwise().squaredNorm() / static_cast<double>(count)).cwiseSqrt().cwiseMax(1e-9);
  x = (x.array().colwise() / sd.array()).matrix();
  Table table({"weights", "layer-wise normalisation", "finite outputs",
               "spread over inputs / spread over channels"});
  const auto add = [&](const std::string& name, const tactile::NetworkBlocks& blocks,
                       bool normalise) {
    const Eigen::MatrixXd y = run_port(blocks, x, normalise);
    double finite = 0;
    for (const double value : y.reshaped()) finite += std::isfinite(value) ? 1 : 0;
    std::string spread = "-";
    if (finite == static_cast<double>(y.size())) {
      const Eigen::VectorXd mean = y.rowwise().mean();
      const double over_inputs =
          std::sqrt((y.colwise() - mean).squaredNorm() / static_cast<double>(y.size()));
      const double over_channels = std::sqrt((mean.array() - mean.mean()).square().mean());
      spread = fmt::format("{:.4f}", over_inputs / over_channels);
    }
    table.add_row({name, normalise ? "yes" : "no",
                   fmt::format("{:.3f}", finite / static_cast<double>(y.size())), spread});
  };
  add("decoded (right)", network.network.blocks(), false);
  add("encoded again (the port)", misread(network.network.blocks()), false);
  add("encoded again (the port)", misread(network.network.blocks()), true);
  table.publish(options, "failure", "What became of the network in the thesis");
}

void judge(const Options& options, const Network& network) {
  const Eigen::VectorXd ratios =
      tactile::error_ratios(network.network(network.inputs), network.outputs);
  Table table({"channels", "MAE / sd on unseen trajectories"});
  const std::vector<std::string> names = {"pdc", "pac", "tdc", "tac"};
  for (int k = 0; k < 4; ++k) {
    table.add_row({names[static_cast<std::size_t>(k)], fmt::format("{:.3f}", ratios[k])});
  }
  table.add_row({"e1..e19, mean", fmt::format("{:.3f}", ratios.tail<19>().mean())});
  table.add_row({"e1..e19, worst", fmt::format("{:.3f}", ratios.tail<19>().maxCoeff())});
  table.add_row({"all, mean", fmt::format("{:.3f}", ratios.mean())});
  table.publish(options, "errors", "Errors of network B (target: .2)");
  const auto sensitivity = tactile::sensitivities(network.network, network.inputs, network.outputs);
  const auto lost = tactile::shuffled_input_losses(network.network, network.inputs, network.outputs,
                                                   options.seed);
  Table inputs({"input", "sensitivity, sd a sd", "MAE / sd lost when shuffled"});
  const std::vector<std::string> inputs_names = {"cx",  "cy",  "cz",  "f1x", "f1y", "f1z", "f2x",
                                                 "f2y", "f2z", "f3x", "f3y", "f3z", "T"};
  for (int k = 0; k < tactile::kNetworkInputs; ++k) {
    inputs.add_row({inputs_names[static_cast<std::size_t>(k)],
                    fmt::format("{:.3f}", sensitivity[k]), fmt::format("{:.3f}", lost[k])});
  }
  inputs.publish(options, "inputs", "Every input matters");
}

void network_b(const Options& options) {
  const Network network = unseen(options);
  judge(options, network);
  explain_failure(options, network);
  for (const auto& surface : surfaces()) {
    const auto frames = press(surface, options.quick ? 2 : 30, options.seed);
    const auto rows = tactile::biotac_dataset(frames);
    const auto inputs = tactile::network_inputs(rows);
    draw(options, surface.name, times_of(frames), inputs, network.network(inputs));
    if (surface.name != "flat") continue;
    const std::size_t middle = frames.size() / 4;
    draw_maps(options, frames[middle].reading.electrodes - tactile::electrode_rest());
  }
  tactile::BiotacDatasetOptions learned;  // the network's own training data (fig. 5.10)
  learned.trajectories = 1;
  learned.stride = 1;
  learned.seconds = options.quick ? 1 : 10;
  const auto frames = tactile::simulate_biotac(learned);
  const auto inputs = tactile::network_inputs(tactile::biotac_dataset(frames));
  draw(options, "training", times_of(frames), inputs, network.network(inputs));
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "biotac_network",
             "Network B on four surfaces and its own data, its errors, and the thesis' failure "
             "(figs 5.8 to 5.10, B.1 to B.3).",
             network_b);
}
