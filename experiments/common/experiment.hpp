// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace palpate::experiment {

/// What every experiment is given on its command line.
struct Options {
  std::filesystem::path out;  ///< folder of the figures and tables
  std::uint64_t seed = 9000;  ///< first seed
  int threads = 1;            ///< at least 1
  bool quick = false;         ///< a few runs of everything, for the tests
};

/// Runs an experiment as a program: options, --help, errors in one line, exit code.
///
/// @param name  the program's, also the folder of its output below out/experiments
/// @param what  what it reproduces, one sentence, for --help
int run(int argc, char** argv, const std::string& name, const std::string& what,
        const std::function<void(const Options&)>& experiment);

/// A table for people (Markdown) and for programs (CSV).
class Table {
 public:
  explicit Table(std::vector<std::string> columns);

  /// @throws BadInput unless there is one cell a column
  void add_row(std::vector<std::string> cells);

  [[nodiscard]] std::string markdown() const;
  /// Cells that hold commas, quotes or line ends are quoted (RFC 4180).
  [[nodiscard]] std::string csv() const;

  /// Prints the Markdown under the title and writes OUT/name.md and OUT/name.csv.
  void publish(const Options& options, const std::string& name, const std::string& title) const;

 private:
  std::vector<std::vector<std::string>> rows_;  // the first holds the columns' names
};

/// Writes a figure as OUT/name.svg and says where it is.
void publish_figure(const Options& options, const std::string& name, const std::string& svg);

}  // namespace palpate::experiment
