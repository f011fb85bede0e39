// SPDX-License-Identifier: Apache-2.0
#include "sense.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "csv_header.hpp"
#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/tactile/normals/normal_estimator.hpp"
#include "sense_biotac.hpp"
#include "sense_contacts.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

enum class Format { recording, contacts, biotac };

/// The first 4 KiB of a file.
std::string head_of(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) {
    const bool exists = std::filesystem::exists(path, error);
    throw BadInput(fmt::format("{} {}", path, exists ? "is not a file" : "does not exist"));
  }
  std::ifstream in(path, std::ios::binary);
  std::string head(4096, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head;
}

Format format_of(const std::string& path) {
  const std::string head = head_of(path);
  if (head.starts_with("PALPATE RECORDING")) return Format::recording;
  const auto columns = csv_cells(csv_header(head));
  const auto has = [&](std::string_view name) {
    return std::ranges::find(columns, name) != columns.end();
  };
  if (has("pdc")) return Format::biotac;
  if (has("finger") && has("t")) return Format::contacts;
  throw BadInput(fmt::format(
      "{} is neither a recording nor a CSV with columns finger,t,... or t_s,pdc,e1...", path));
}

/// What was asked for must matter: a model or a setting without effect is a mistake.
void refuse_what_has_no_effect(const SenseArguments& arguments, const CLI::App& command,
                               Format format) {
  const auto refuse = [&](const char* option, const char* of) {
    if (command.count(option) == 0) return;
    throw BadInput(
        fmt::format("{} is an option of {}, which {} is not", option, of, arguments.recording));
  };
  if (format != Format::contacts) refuse("--tick", "a CSV of contacts");
  if (format != Format::biotac) refuse("--causal", "a log of a BioTac");
  if (format == Format::biotac) {
    refuse("--estimator", "contacts with forces");
    refuse("--min-force", "contacts with forces");
  }
  if (format == Format::contacts && !arguments.model.empty()) {
    throw BadInput(fmt::format("{} has no channels of a BioTac for --model {} to read",
                               arguments.recording, arguments.model));
  }
}

std::vector<SensedStream> streams_of(const SenseArguments& arguments, Format format) {
  const Notice notice("estimating", arguments.common.quiet);
  if (format == Format::recording) return sense_recording(arguments);
  return format == Format::contacts ? sense_contact_log(arguments) : sense_biotac(arguments);
}

int sense(const SenseArguments& arguments, const CLI::App& command) {
  const Format format = format_of(arguments.recording);
  refuse_what_has_no_effect(arguments, command, format);
  report_streams(arguments, command, streams_of(arguments, format));
  return kDone;
}

}  // namespace

void add_sense(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<SenseArguments>();
  auto& command =
      *program.add_subcommand("sense", "Estimate contact normals and forces from tactile readings");
  accept_folder_of_pick(
      *command
           .add_option("recording", arguments->recording,
                       "recording.h5 or the folder of a pick, a CSV of contacts, or a CSV of a "
                       "BioTac")
           ->option_text("RECORDING")
           ->required());
  command
      .add_option("--estimator", arguments->estimator,
                  "estimator of normals from contact forces and motion")
      ->check(CLI::IsMember(tactile::normal_estimators()))
      ->capture_default_str();
  command
      .add_option("--tick", arguments->tick,
                  "seconds per tick, if t in the CSV counts ticks (integers)")
      ->check(in_range(1e-5, 10.0))
      ->default_str("0.1");
  command
      .add_option("--min-force", arguments->min_force,
                  "N, of a contact; less, such as the noise of a sensor in the air, is no contact")
      ->check(in_range(0.0, 10.0))
      ->capture_default_str();
  command
      .add_option("--model", arguments->model,
                  "trained model for a BioTac log, or for the BioTacs of a recording")
      ->option_text("FILE");
  command.add_flag("--causal", arguments->causal,
                   "for a BioTac log: use only the frames up to each sample, as in a stream");
  add_common_options(command, arguments->common, kOut);
  command.footer(
      "A CSV of contacts has the columns finger,t,px,py,pz (or x,y,z),fx,fy,fz and, optionally,\n"
      "nx,ny,nz (the true normal, for comparison) and tnx,tny,tnz (the object's outward normal as\n"
      "inferred from the fingertip's shape); one of a BioTac has t_s,pdc,e1..e19 and, optionally,\n"
      "nx,ny,nz.\n"
      "For a recording with BioTac channels the contacts inferred from these are reported, too.\n"
      "Errors in a recording are relative to the surface nearest to the assumed tip, which is\n"
      "uncertain itself at edges.\n"
      "Unusable samples are flagged and counted, and get no normal; the column flags says why, as\n"
      "in \"no_force 3\": three samples without force (docs/touch.md lists them). --out writes "
      "each\n"
      "stream's series as CSV and its normals and forces as SVG figures and, except of a\n"
      "recording, the contacts of all streams as contacts.csv, which palpate localize reads.\n\n"
      "Examples:\n"
      "  palpate sense out/pick-mug-2/recording.h5 --out out/sense-mug-2\n"
      "  palpate sense contacts.csv --estimator rls --json");
  command.callback([arguments, &command, &chosen] {
    chosen = [arguments, &command] { return sense(*arguments, command); };
  });
}

}  // namespace palpate::app
