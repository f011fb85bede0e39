// SPDX-License-Identifier: Apache-2.0
#include "train_biotac.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <numbers>
#include <optional>

#include "given_command.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/tactile/biotac/electrodes.hpp"
#include "palpate/tactile/biotac/inverse.hpp"
#include "palpate/tactile/biotac/network.hpp"
#include "palpate/tactile/biotac/normal.hpp"
#include "progress_bar.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

struct BiotacNormalArguments {
  CommonOptions common;
  std::vector<std::string> logs;
};

/// --out is a file here, not the folder that it is elsewhere.
void add_model_options(CLI::App& command, CommonOptions& common) {
  command.add_option("--out", common.out, "file of the model")->option_text("FILE");
  command.add_flag("--force", common.force, "overwrite FILE");
}

/// @throws BadInput unless there is a place for the model and, if there is a file of them, the data
void require_out(const CommonOptions& common, const std::string& data = "") {
  if (common.out.empty()) throw BadInput("--out FILE is missing: where the model is to go");
  for (const std::string& file : {common.out, data}) {
    if (common.force || !std::filesystem::exists(file)) continue;
    throw BadInput(fmt::format("{} exists; --force overwrites it", file));
  }
}

std::vector<tactile::BiotacSample> samples_of(const std::vector<tactile::BiotacLog>& logs) {
  std::vector<tactile::BiotacSample> samples;
  for (const auto& log : logs) {
    const auto more = tactile::biotac_samples(log);
    samples.insert(samples.end(), more.begin(), more.end());
  }
  return samples;
}

std::vector<tactile::BiotacLog> read_logs(const std::vector<std::string>& paths) {
  std::vector<tactile::BiotacLog> logs;
  for (const auto& path : paths) logs.push_back(tactile::read_biotac_log(path));
  return logs;
}

nlohmann::json normal_errors_json(const tactile::BiotacNormalErrors& errors) {
  if (errors.error_deg.empty()) return nullptr;
  return {{"frames", errors.error_deg.size()},
          {"median_deg", median(errors.error_deg)},
          {"p90_deg", quantile(errors.error_deg, 0.9)},
          {"normalized_error_squared", mean(errors.normalised)},
          {"coverage_95", errors.coverage_95()}};
}

/// Errors at each log of models that learned from the others.
struct LogsLeftOut {
  nlohmann::json logs = nlohmann::json::object();
  tactile::BiotacNormalErrors errors;
};

LogsLeftOut leave_logs_out(const std::vector<tactile::BiotacLog>& logs,
                           const tactile::BiotacNormalOptions& options) {
  LogsLeftOut result;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    auto others = logs;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    if (samples_of(others).size() < 10) continue;
    const auto errors =
        tactile::evaluate_biotac_normal(tactile::train_biotac_normal(others, options), logs[i]);
    result.logs[logs[i].name] = normal_errors_json(errors);
    result.errors.add(errors);
  }
  return result;
}

std::string said(const std::vector<double>& errors, const std::string& of) {
  if (errors.empty()) return fmt::format("no {} to validate on", of);
  return fmt::format("error at {} left out: median {:.2f} deg, p90 {:.2f} deg", of, median(errors),
                     quantile(errors, 0.9));
}

int train_biotac_normal(const BiotacNormalArguments& arguments) {
  require_out(arguments.common);
  const auto options = resolve<tactile::BiotacNormalOptions>(arguments.common);
  std::optional<Notice> notice(std::in_place, "training", arguments.common.quiet);
  const auto logs = read_logs(arguments.logs);
  const auto model = tactile::train_biotac_normal(logs, options);
  const auto errors = tactile::cross_validate_biotac_normal(logs, options);
  write_file_atomically(arguments.common.out, model.bytes());
  const std::size_t samples = samples_of(logs).size();
  nlohmann::json report = {{"samples", samples}, {"logs", logs.size()}};
  report["validation_error_deg"] = nullptr;
  if (!errors.empty()) {
    report["validation_error_deg"] = {{"median", median(errors)}, {"p90", quantile(errors, 0.9)}};
  }
  std::string text = said(errors, "touches");
  if (logs.size() > 1) {
    const auto left_out = leave_logs_out(logs, options);
    report["logs_left_out"] = left_out.logs;
    report["all_logs_left_out"] = normal_errors_json(left_out.errors);
    text += "; " + said(left_out.errors.error_deg, "logs");
  }
  notice.reset();
  if (arguments.common.json) {
    print_json(report);
  } else {
    fmt::print("{} samples of {} logs; {}\nwrote {}\n", samples, logs.size(), text,
               arguments.common.out);
    print_next(arguments.common, "palpate sense LOG --model " + quoted(arguments.common.out));
  }
  return kDone;
}

void add_biotac_normal(CLI::App& train, Command& chosen) {
  auto arguments = std::make_shared<BiotacNormalArguments>();
  auto& command = *train.add_subcommand(
      "biotac-normal", "Train a model of contact normals on BioTac logs with known normals");
  command.add_option("logs", arguments->logs, "CSV with t_s,pdc,e1..e19,nx,ny,nz; raw counts")
      ->option_text("LOG...")
      ->required();
  add_model_options(command, arguments->common);
  add_common_options(command, arguments->common, kConfig);
  command.footer(
      "--out names the file of the model. The validation leaves whole touches out and, if there\n"
      "are several, whole logs.\n\n"
      "Examples:\n"
      "  palpate train biotac-normal day1.csv day2.csv --out biotac.model\n"
      "  palpate sense day3.csv --model biotac.model --json");
  command.callback(
      [arguments, &chosen] { chosen = [arguments] { return train_biotac_normal(*arguments); }; });
}

void report(const CommonOptions& common, const nlohmann::json& result) {
  if (common.json) {
    print_json(result);
    return;
  }
  for (const auto& [key, value] : result.items()) fmt::print("{}: {}", key, json_text(value, -1));
  fmt::print("wrote {}\n", common.out);
}

struct ElectrodeOptions {
  tactile::ElectrodeFitOptions fit;
  tactile::ElectrodeModelOptions model;

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("fit", fit);
    v.section("model", model);
  }
};

struct ElectrodeArguments {
  CommonOptions common;
  std::vector<std::string> logs, test;
};

nlohmann::json errors_json(const std::optional<tactile::ElectrodeErrors>& errors) {
  if (!errors) return nullptr;
  const auto summary = [](const tactile::ElectrodeChanges& ratios) {
    return nlohmann::json{{"mean", ratios.mean()},
                          {"electrodes", std::vector<double>(ratios.begin(), ratios.end())}};
  };
  return {{"fit", summary(errors->fit)}, {"model", summary(errors->model)}};
}

nlohmann::json fit_json(const tactile::ElectrodeFit& fit) {
  const Eigen::Vector3d turn = log_so3(fit.R_sensor_log) * 180 / std::numbers::pi;
  return {
      {"skin.stiffness", fit.skin.stiffness},       {"skin.crown", fit.skin.crown},
      {"sensor.spread", fit.sensor.spread},         {"sensor.bulge_area", fit.sensor.bulge_area},
      {"turn_deg", {turn.x(), turn.y(), turn.z()}}, {"mirrored", fit.mirrored}};
}

int train_biotac_electrodes(const ElectrodeArguments& arguments) {
  require_out(arguments.common);
  auto options = resolve<ElectrodeOptions>(arguments.common);
  options.fit.seed = arguments.common.seed;
  std::optional<Notice> notice(std::in_place, "fitting and training", arguments.common.quiet);
  const auto logs = read_logs(arguments.logs);
  const auto samples = samples_of(logs);
  const auto fit = tactile::fit_electrodes(samples, options.fit);
  const auto model = tactile::ElectrodeModel::train(samples, options.model);
  nlohmann::json result = {{"samples", samples.size()}, {"fit", fit_json(fit)}};
  result["validation_mae_over_sd"] =
      errors_json(tactile::cross_validate_electrodes(logs, options.fit, options.model));
  if (!arguments.test.empty()) {
    const auto test = samples_of(read_logs(arguments.test));
    result["test_samples"] = test.size();
    result["test_mae_over_sd"] =
        errors_json(tactile::evaluate_electrodes(samples, test, options.fit, options.model));
  }
  notice.reset();
  write_file_atomically(arguments.common.out, model.bytes());
  report(arguments.common, result);
  return kDone;
}

void add_biotac_electrodes(CLI::App& train, Command& chosen) {
  auto arguments = std::make_shared<ElectrodeArguments>();
  auto& command = *train.add_subcommand(
      "biotac-electrodes", "Train a model of the electrodes on BioTac logs with known normals");
  command.add_option("logs", arguments->logs, "CSV with t_s,pdc,e1..e19,nx,ny,nz; raw counts")
      ->option_text("LOG...")
      ->required();
  command.add_option("--test", arguments->test, "logs for the evaluation, not used for training")
      ->option_text("LOG...");
  add_model_options(command, arguments->common);
  add_common_options(command, arguments->common, kConfig | kSeed);
  command.footer(
      "Reports the simulated sensor's parameters as fitted to the logs, and the errors of that "
      "fit\n"
      "and of the learned model (in standard deviations) at whole touches that were left out.\n"
      "--out names the file of the model.\n\n"
      "Examples:\n"
      "  palpate train biotac-electrodes day1.csv day2.csv --out electrodes.model\n"
      "  palpate train biotac-electrodes day1.csv --test day2.csv --out electrodes.model --json");
  command.callback([arguments, &chosen] {
    chosen = [arguments] { return train_biotac_electrodes(*arguments); };
  });
}

/// Options of the models that learn from simulated touches.
struct SimulatedOptions {
  tactile::BiotacDatasetOptions data;
  tactile::SkinOptions skin;
  tactile::BiotacSensorOptions sensor;
  tactile::NetworkTrainingOptions network;
  tactile::BiotacInverseOptions inverse;

  template <class Visitor>
  void visit(Visitor&& v) {
    v.section("data", data);
    v.section("skin", skin);
    v.section("sensor", sensor);
    v.section("network", network);
    v.section("inverse", inverse);
  }
};

struct SimulatedArguments {
  CommonOptions common;
  std::string write_data;
};

constexpr std::uint64_t kTestSeed = 9000;  // beyond that of what is learned

struct SimulatedTouches {
  std::vector<tactile::BiotacFrame> learn, evaluator;
};

/// Touches to learn from and, of another seed and a fifth as many, to test with.
SimulatedTouches simulate(const SimulatedArguments& arguments, const SimulatedOptions& options) {
  SimulatedTouches touches;
  const Notice notice("simulating touches", arguments.common.quiet);
  auto data = options.data;
  data.seed = arguments.common.seed;
  touches.learn = tactile::simulate_biotac(data, options.skin, options.sensor);
  if (!arguments.write_data.empty()) {
    write_file_atomically(arguments.write_data, tactile::dataset_csv(touches.learn));
  }
  data.seed = arguments.common.seed + kTestSeed;
  data.trajectories = std::max(1, data.trajectories / 5);
  touches.evaluator = tactile::simulate_biotac(data, options.skin, options.sensor);
  return touches;
}

int train_biotac_network(const SimulatedArguments& arguments) {
  require_out(arguments.common, arguments.write_data);
  auto options = resolve<SimulatedOptions>(arguments.common);
  options.network.seed = arguments.common.seed;
  const auto touches = simulate(arguments, options);
  const Eigen::MatrixXd learn = tactile::biotac_dataset(touches.learn),
                        evaluator = tactile::biotac_dataset(touches.evaluator);
  tactile::BiotacNetwork network(arguments.common.seed);
  const ProgressBar bar("epochs", static_cast<std::size_t>(options.network.epochs),
                        arguments.common.quiet);
  network.train(tactile::network_inputs(learn), tactile::network_outputs(learn), options.network,
                [&bar](std::size_t done, std::size_t) { bar.show(done); });
  const auto inputs = tactile::network_inputs(evaluator),
             outputs = tactile::network_outputs(evaluator);
  const Eigen::VectorXd ratios = tactile::error_ratios(network(inputs), outputs);
  const auto as_vector = [](const Eigen::VectorXd& v) {
    return std::vector<double>(v.begin(), v.end());
  };
  write_file_atomically(arguments.common.out, network.bytes());
  report(arguments.common,
         {{"samples", learn.rows()},
          {"test_samples", evaluator.rows()},
          {"test_mae_over_sd", ratios.mean()},
          {"test_mae_over_sd_of_channels", as_vector(ratios)},
          {"sensitivity_of_inputs", as_vector(tactile::sensitivities(network, inputs, outputs))},
          {"loss_by_shuffled_inputs",
           as_vector(tactile::shuffled_input_losses(network, inputs, outputs, 0))}});
  return kDone;
}

/// Errors of contacts that were not learned from.
nlohmann::json inverse_errors(const tactile::BiotacInverse& model,
                              const std::vector<tactile::BiotacFrame>& frames) {
  constexpr std::size_t kStride = 5;  // neighbouring frames measure the same
  std::vector<double> points, forces, normals, directions;
  double within_one = 0, within_two = 0, components = 0;
  for (std::size_t i = 0; i < frames.size(); i += kStride) {
    const auto found = model.estimate(frames[i].decoded);
    if (!found) continue;
    points.push_back(1e3 * (found->p - frames[i].p).norm());
    forces.push_back((found->f - frames[i].f1).norm());
    normals.push_back(tactile::angle_between_deg(found->n, frames[i].n));
    directions.push_back(tactile::angle_between_deg(found->f, frames[i].f1));
    const Eigen::ArrayXd sigmas =
        tactile::contact_error(*found, frames[i].p, frames[i].f1).array().abs() /
        found->covariance.diagonal().array().sqrt();
    within_one += static_cast<double>((sigmas < 1).count());
    within_two += static_cast<double>((sigmas < 2).count());
    components += static_cast<double>(sigmas.size());
  }
  if (points.empty()) return {{"test_samples", 0}};
  const auto summary = [](const std::vector<double>& errors) {
    return nlohmann::json{{"median", median(errors)}, {"p90", quantile(errors, 0.9)}};
  };
  return {{"test_samples", points.size()},
          {"test_point_error_mm", summary(points)},
          {"test_force_error_n", summary(forces)},
          {"test_normal_error_deg", summary(normals)},
          {"test_force_direction_error_deg", summary(directions)},
          {"test_within_1_and_2_sigma", {within_one / components, within_two / components}}};
}

int train_biotac_inverse(const SimulatedArguments& arguments) {
  require_out(arguments.common, arguments.write_data);
  auto options = resolve<SimulatedOptions>(arguments.common);
  options.inverse.seed = arguments.common.seed;
  const auto touches = simulate(arguments, options);
  std::optional<Notice> notice(std::in_place, "training", arguments.common.quiet);
  const auto model =
      tactile::BiotacInverse::train(touches.learn, options.inverse, options.skin, options.sensor);
  write_file_atomically(arguments.common.out, model.bytes());
  nlohmann::json result = inverse_errors(model, touches.evaluator);
  result["samples"] = touches.learn.size();
  notice.reset();
  report(arguments.common, result);
  print_next(arguments.common, "palpate sense RECORDING --model " + quoted(arguments.common.out));
  return kDone;
}

void add_simulated(CLI::App& train, Command& chosen, const std::string& name,
                   const std::string& what, int (*action)(const SimulatedArguments&)) {
  auto arguments = std::make_shared<SimulatedArguments>();
  auto& command = *train.add_subcommand(name, what);
  add_model_options(command, arguments->common);
  add_common_options(command, arguments->common, kConfig | kSeed);
  command
      .add_option("--write-data", arguments->write_data,
                  "also write the data set as CSV, in the layout of thesis eq. 5.11")
      ->option_text("FILE");
  command.footer(
      fmt::format("--out names the file of the model. The touches are simulated; those of the "
                  "evaluation have\n"
                  "the seed plus 9000.\n\n"
                  "Examples:\n"
                  "  palpate train {0} --out {0}.model\n"
                  "  palpate train {0} --out {0}.model --set data.trajectories=50",
                  name));
  command.callback([arguments, action, &chosen] {
    chosen = [arguments, action] { return action(*arguments); };
  });
}

}  // namespace

std::vector<OptionInfo> biotac_electrodes_option_list() { return list_options(ElectrodeOptions{}); }
std::vector<OptionInfo> simulated_biotac_option_list() { return list_options(SimulatedOptions{}); }

void add_train_biotac(CLI::App& train, Command& chosen) {
  add_biotac_normal(train, chosen);
  add_biotac_electrodes(train, chosen);
  add_simulated(train, chosen, "biotac-network",
                "Train the network that imitates a BioTac (architecture B) on simulated touches",
                train_biotac_network);
  add_simulated(train, chosen, "biotac-inverse",
                "Train the inference of contacts from a simulated BioTac's channels",
                train_biotac_inverse);
}

}  // namespace palpate::app
