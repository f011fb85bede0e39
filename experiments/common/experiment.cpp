// SPDX-License-Identifier: Apache-2.0
#include "experiment.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <utility>

#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::experiment {

int run(int argc, char** argv, const std::string& name, const std::string& what,
        const std::function<void(const Options&)>& experiment) {
  Options options;
  options.out = std::filesystem::path("out/experiments") / name;
  CLI::App program{what, name};
  program.add_option("--out", options.out, "folder of the figures and tables")
      ->capture_default_str();
  program.add_option("--seed", options.seed, "first seed")->capture_default_str();
  program.add_option("--threads", options.threads, "threads; the results do not depend on them")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  program.add_flag("--quick", options.quick, "a few runs of everything, to see that it works");
  CLI11_PARSE(program, argc, argv);
  try {
    make_writable_folder(options.out);
    experiment(options);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}: {}\n", name, error.what());
    return 3;
  }
}

namespace {

/// In quotes where it holds what separates cells or rows (RFC 4180).
std::string csv_cell(std::string cell) {
  if (cell.find_first_of(",\"\r\n") == std::string::npos) return cell;
  for (std::size_t at = 0; (at = cell.find('"', at)) != std::string::npos; at += 2) {
    cell.insert(at, 1, '"');
  }
  return '"' + cell + '"';
}

}  // namespace

Table::Table(std::vector<std::string> columns) : rows_{std::move(columns)} {}

void Table::add_row(std::vector<std::string> cells) {
  if (cells.size() != rows_.front().size()) {
    throw BadInput(fmt::format("a row of {} cells in a table of {} columns", cells.size(),
                               rows_.front().size()));
  }
  rows_.push_back(std::move(cells));
}

std::string Table::markdown() const {
  auto rows = rows_;
  rows.insert(rows.begin() + 1, std::vector<std::string>(rows_.front().size(), "---"));
  std::string text;
  for (const auto& row : rows) text += fmt::format("| {} |\n", fmt::join(row, " | "));
  return text;
}

std::string Table::csv() const {
  std::string text;
  for (auto row : rows_) {
    for (auto& cell : row) cell = csv_cell(std::move(cell));
    text += fmt::format("{}\n", fmt::join(row, ","));
  }
  return text;
}

void Table::publish(const Options& options, const std::string& name,
                    const std::string& title) const {
  fmt::print("\n{}\n\n{}", title, markdown());
  write_file_atomically(options.out / (name + ".md"), fmt::format("{}\n\n{}", title, markdown()));
  write_file_atomically(options.out / (name + ".csv"), csv());
}

void publish_figure(const Options& options, const std::string& name, const std::string& svg) {
  const auto path = options.out / (name + ".svg");
  write_file_atomically(path, svg);
  fmt::print("figure: {}\n", path.string());
}

}  // namespace palpate::experiment
