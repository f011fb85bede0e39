// SPDX-License-Identifier: Apache-2.0
#include "program.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "palpate/core/error.hpp"
#include "palpate/core/unknown_option.hpp"
#include "palpate/core/version.hpp"
#include "usage.hpp"

namespace palpate::app {
namespace {

/// Names the command's own option for a key of that name, or the list of options.
int run_command(const CLI::App& program, const Command& chosen) {
  try {
    return chosen();
  } catch (const UnknownOption& error) {
    std::string own = "--" + error.key();
    std::ranges::replace(own, '_', '-');
    const CLI::App* const command = innermost(&program);
    if (command->get_option_no_throw(own)) {
      throw BadInput(
          fmt::format("{} is no option of a configuration; {} sets it", error.key(), own));
    }
    const std::string what = error.what();
    if (what.find("did you mean") != what.npos) throw;
    throw BadInput(
        fmt::format("{}; palpate options {} lists the options", what, words_of(command)));
  }
}

bool has_commands(const CLI::App& command) {
  return !command.get_subcommands([](const CLI::App*) { return true; }).empty();
}

/// `help COMMAND` as `COMMAND --help`; without the option for a command that does not exist, which
/// is then the error. @throws CLI::ParseError for more than a command
std::vector<std::string> help_arguments(const CLI::App& program,
                                        const std::vector<std::string>& given) {
  std::vector<std::string> arguments(given.begin() + 1, given.end());
  const CLI::App* command = &program;
  for (const std::string& name : arguments) {
    const auto found =
        command->get_subcommands([&](const CLI::App* one) { return one->get_name() == name; });
    if (found.empty() && command != &program && !has_commands(*command)) {
      throw CLI::ParseError(
          fmt::format("help takes one command, and '{} {}' is none", words_of(command), name),
          CLI::ExitCodes::ExtrasError);
    }
    if (found.empty()) return arguments;
    command = found.front();
  }
  arguments.emplace_back("--help");
  return arguments;
}

int run(std::span<const AddCommand> commands, int argc, char** argv) {
  CLI::App program{"Palpate: tactile-only in-hand pose estimation and manipulation.", "palpate"};
  program.set_version_flag("--version", std::string(version()));
  program.require_subcommand(1);
  program.failure_message(usage_error);
  program.formatter(std::make_shared<HelpFormatter>());
  program.footer(
      "palpate COMMAND --help or palpate help COMMAND shows a command's options and examples.\n"
      "Exit codes: 0 done, 2 usage, 3 bad input, 4 no solution, 5 the robot was stopped by a "
      "fault.");
  Command chosen;
  for (const AddCommand add : commands) add(program, chosen);
  check_values(program);
  try {
    std::vector<std::string> arguments(argv + 1, argv + argc);
    if (!arguments.empty() && arguments.front() == "help") {
      arguments = help_arguments(program, arguments);
    }
    std::ranges::reverse(arguments);  // as CLI11 takes them
    program.parse(std::move(arguments));
  } catch (const CLI::ParseError& error) {
    std::ostringstream help;
    const int code = program.exit(error, help, std::cerr);
    fmt::print("{}", help.str());
    return code == 0 ? kDone : kUsage;
  }
  return run_command(program, chosen);
}

/// Takes the places of standard streams that are closed: the next file that is opened would have
/// one of them, and would be given what is printed. To print there fails, as on a closed one.
void occupy_closed_streams() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0) continue;
    static_cast<void>(::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY));
  }
}

/// Not by fmt::print, which throws where stderr takes nothing.
void complain(const std::string& what) {
  std::fputs(fmt::format("palpate: {}\n", in_one_line(what)).c_str(), stderr);
}

/// A reader that has gone away, as `head` does, wants nothing more and is told nothing.
void complain_of_output(const std::error_code& reason) {
  if (reason == std::errc::broken_pipe) return;
  complain(fmt::format("cannot write the output{}", reason ? ": " + reason.message() : ""));
}

/// Sends what is printed on its way, for who reads it must not take a part for the whole.
/// @return the exit code after one of a command
int end_output(int code) {
  errno = 0;
  const bool lost = std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
  const std::error_code reason(errno, std::generic_category());
  if (!lost || reason == std::errc::broken_pipe) return code;
  complain_of_output(reason);
  return code == kDone ? kBadInput : code;
}

}  // namespace

int run_program(std::span<const AddCommand> commands, int argc, char** argv) {
  occupy_closed_streams();
  try {
    return end_output(run(commands, argc, argv));
  } catch (const BadInput& error) {
    complain(error.what());
    return kBadInput;
  } catch (const std::filesystem::filesystem_error& error) {
    complain(fmt::format("{}: {}", error.path1().string(), error.code().message()));
    return kBadInput;
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) == 0) {
      complain(fmt::format("unexpected failure: {}", error.what()));
      return 1;
    }
    complain_of_output(error.code());
    return kBadInput;
  } catch (const std::exception& error) {
    complain(fmt::format("unexpected failure: {}", error.what()));
    return 1;
  }
}

}  // namespace palpate::app
