// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "common.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/touch/biotac_normal.hpp"
#include "train_relocate.hpp"

namespace palpate::app {
namespace {

struct BiotacNormalArguments {
  CommonOptions common;
  std::vector<std::string> logs;
};

void require_out(const CommonOptions& common) {
  if (common.out.empty()) throw BadInput("--out FILE is missing: where the model is to go");
}

int train_biotac_normal(const BiotacNormalArguments& arguments) {
  require_out(arguments.common);
  auto options = resolve<touch::BiotacNormalOptions>(arguments.common);
  options.seed = arguments.common.seed;
  std::vector<touch::BiotacLog> logs;
  std::vector<touch::BiotacSample> samples;
  for (const auto& path : arguments.logs) {
    logs.push_back(touch::read_biotac_log(path));
    const auto more = touch::biotac_samples(logs.back());
    samples.insert(samples.end(), more.begin(), more.end());
  }
  const auto model = touch::BiotacNormalModel::train(samples, options);
  const auto errors = touch::cross_validate_biotac_normal(logs, options);
  write_file_atomically(arguments.common.out, model.bytes());
  nlohmann::json report = {{"samples", samples.size()}, {"logs", logs.size()}};
  report["validation_error_deg"] = nullptr;
  std::string validation = "too few touches to validate";
  if (!errors.empty()) {
    const double middle = median(errors), p90 = quantile(errors, 0.9);
    report["validation_error_deg"] = {{"median", middle}, {"p90", p90}};
    validation =
        fmt::format("error at touches left out: median {:.2f} deg, p90 {:.2f} deg", middle, p90);
  }
  if (arguments.common.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    fmt::print("{} samples of {} logs; {}\nwrote {}\n", samples.size(), logs.size(), validation,
               arguments.common.out);
  }
  return kDone;
}

void add_biotac_normal(CLI::App& train, Command& chosen) {
  auto arguments = std::make_shared<BiotacNormalArguments>();
  auto& command = *train.add_subcommand(
      "biotac-normal", "Learn contact normals from logs of a BioTac with known normals");
  command.add_option("logs", arguments->logs, "CSV with t_s,pdc,e1..e19,nx,ny,nz; raw counts")
      ->option_text("LOG...")
      ->required();
  add_common_options(command, arguments->common);
  command.footer(
      "--out names the file of the model. The validation leaves whole touches out.\n\n"
      "Examples:\n"
      "  palpate train biotac-normal day1.csv day2.csv --out biotac.model\n"
      "  palpate sense day3.csv --model biotac.model --json");
  command.callback(
      [arguments, &chosen] { chosen = [arguments] { return train_biotac_normal(*arguments); }; });
}

}  // namespace

void add_train(CLI::App& program, Command& chosen) {
  auto& command = *program.add_subcommand("train", "Train a model or a policy");
  command.require_subcommand(1);
  add_biotac_normal(command, chosen);
  add_train_relocate(command, chosen);
}

}  // namespace palpate::app
