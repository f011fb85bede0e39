// SPDX-License-Identifier: Apache-2.0
#include "eval_arguments.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <filesystem>

#include "hand_option.hpp"
#include "palpate/core/error.hpp"
#include "palpate/geometry/objects/generated_shape.hpp"
#include "place_report.hpp"

namespace palpate::app {
namespace {

/// @throws BadInput unless it is I/N, 1 <= I <= N
Shard parse_shard(const std::string& text) {
  std::size_t number = 0, count = 0;
  char end = 0;
  const int read = std::sscanf(text.c_str(), "%zu/%zu%c", &number, &count, &end);
  if (read != 2 || number < 1 || number > count || count > 1'000'000) {
    throw BadInput(fmt::format("--shard {}: it is I/N with 1 <= I <= N, as in 3/16", text));
  }
  return {number, count};
}

/// @throws BadInput for options that do not go together
void check_options(const EvalArguments& arguments) {
  if (arguments.shard.count > 1 && arguments.common.out.empty()) {
    throw BadInput("--shard needs --out: `palpate merge` reads what it writes there");
  }
  if (arguments.resume && (arguments.common.out.empty() || arguments.common.force)) {
    throw BadInput("--resume needs the --out of an evaluation, and no --force");
  }
  const auto records = std::filesystem::path(arguments.common.out) / "trials.jsonl";
  if (arguments.resume && !std::filesystem::exists(records)) {
    throw BadInput(fmt::format("{}: there is no evaluation to go on with", records.string()));
  }
}

/// A target is that of an object which is known.
void check_candidates(const EvalArguments& arguments) {
  if (arguments.known.size_range > 0 && !arguments.place.empty()) {
    throw BadInput(fmt::format("--size-range {} cannot be combined with --place {}",
                               arguments.known.size_range, arguments.place));
  }
  if (arguments.known.size_range > 0 && arguments.candidates.empty()) {
    throw BadInput(
        fmt::format("--size-range {} with {} objects needs --candidates: which of them it may be",
                    arguments.known.size_range, arguments.objects.size()));
  }
  if (arguments.candidates.empty() || arguments.place.empty()) return;
  if (arguments.candidates.size() == 1 && arguments.objects.size() == 1 &&
      is_same_object(arguments.candidates.front(), arguments.objects.front())) {
    return;
  }
  throw BadInput(fmt::format("--candidates {} cannot be combined with --place {}",
                             fmt::join(arguments.candidates, ","), arguments.place));
}

}  // namespace

void add_eval_arguments(CLI::App& command, EvalArguments& arguments) {
  command
      .add_option("--object", arguments.objects,
                  "built-in objects, mesh files, generated:SEED or generated:A-B")
      ->delimiter(',')
      ->type_name("O[,O2..]")
      ->capture_default_str();
  command.add_option("--trials", arguments.trials, "picks per object")
      ->check(in_range(1, 1000000))
      ->capture_default_str();
  command.add_flag("--resume", arguments.resume,
                   "continue the evaluation in DIR, and refuse to start a new one");
  command
      .add_option("--shard", arguments.shard_text,
                  "run only shard I of N of the trials, for `palpate merge`")
      ->option_text("I/N");
  arguments.fault_option =
      command
          .add_option(
              "--faults", arguments.faults,
              "repeat the picks with each of these faults of the hand, injected at a random "
              "time, and with none; without a list, with all faults (docs/safety.md)")
          ->delimiter(',')
          ->type_name("KIND[,KIND2..]")
          ->expected(0, 100);
  add_place_option(command, arguments.place);
  command
      .add_option("--candidates", arguments.candidates,
                  "up to 10 objects among which the robot identifies the one present, or none "
                  "(default: the object is known)")
      ->delimiter(',')
      ->option_text("O,O2..");
  add_object_options(command, arguments.known);
  add_size_range_option(command, arguments.known.size_range);
  add_hand_option(command, arguments.hand);
  add_arm_option(command, arguments.arm);
  add_live_option(command, arguments.live);
  add_common_options(command, arguments.common);
}

void complete(EvalArguments& arguments) {
  if (!arguments.shard_text.empty()) arguments.shard = parse_shard(arguments.shard_text);
  check_options(arguments);
  arguments.objects = geometry::expand_object_names(arguments.objects);
  require_distinct(arguments.objects);  // its trials would count twice
  arguments.candidates = geometry::expand_object_names(arguments.candidates);
  const bool one = arguments.objects.size() == 1 && arguments.candidates.empty();
  if (arguments.known.size_range > 0 && one) arguments.candidates = arguments.objects;
  auto given = arguments.objects;
  given.insert(given.end(), arguments.candidates.begin(), arguments.candidates.end());
  require_mesh_file(given, arguments.known.units);
  check_candidates(arguments);
}

}  // namespace palpate::app
