// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include "given_command.hpp"
#include "localize_arguments.hpp"
#include "localize_demo.hpp"
#include "localize_evidence.hpp"
#include "localize_report.hpp"
#include "object_option.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/localization/contacts_io.hpp"
#include "palpate/localization/free_space.hpp"
#include "palpate/localization/identification.hpp"
#include "palpate/localization/sizes.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

namespace lo = localization;

struct LocalizeOptions {
  lo::LocalizerOptions search;
  lo::FastOptions fast;
  lo::IdentificationOptions identify;
  double false_contacts = 0.02;
  double noise_scale_prior = 0.4;
  double size_prior = 0.25;
  double surface_sigma = 0.0003;
  double centroid_sigma = 0;
  double hand_offset = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("false_contacts", false_contacts, 0.001, 0.9, "prior probability that a contact is spurious");
    v("noise_scale_prior", noise_scale_prior, 0.0, 0.99,
      "prior probability that the noise is half to twice the stated noise");
    v("size_prior", size_prior, 0.0, 0.99,
      "prior probability that the object is up to 3 % larger or smaller than its mesh");
    v("surface_sigma", surface_sigma, 0.0, 0.01, "m, error of the mesh's surface");
    v("centroid_sigma", centroid_sigma, 0.0, 0.1,
      "m per axis, error of the centre of mass, by which an object on a table leans");
    v("hand_offset", hand_offset, 0.0, 0.02, "m rms, common-mode bias of the contacts of one time");
    v.section("search", search);
    v.section("fast", fast);
    v.section("identify", identify);
  }
};

std::vector<tactile::Contact> flipped(std::vector<tactile::Contact> contacts) {
  for (auto& contact : contacts) contact.n = -contact.n;
  return contacts;
}

/// Why no pose may explain the contacts.
std::string hint_for(const geometry::ObjectModel& model, lo::Evidence evidence, RandomStream random,
                     const LocalizeOptions& options) {
  if (evidence.contacts.empty()) return "there are no contacts";
  const auto one_explains = [&](const lo::Evidence& changed) {
    return lo::localize(model, changed, random, options.search).status != lo::PoseStatus::no_pose;
  };
  lo::Evidence reversed = evidence;
  reversed.contacts = flipped(std::move(reversed.contacts));
  if (one_explains(reversed)) {
    return "no pose explains these contacts, but with all normals reversed one does; they must "
           "point out of the object";
  }
  if (!evidence.free_space.empty()) {
    lo::Evidence without = evidence;
    without.free_space.clear();
    if (one_explains(without)) {
      return "no pose explains these contacts beside the free space, but without --free one does; "
             "its centers and radii must be in m, in the contacts' frame";
    }
  }
  if (!evidence.table) {
    return "no pose explains these contacts: another object, more noise than stated, or a mesh "
           "less "
           "exact than surface_sigma states";
  }
  const double height = evidence.table->T_frame_table.translation().z();
  evidence.table.reset();
  if (one_explains(evidence)) {
    return fmt::format(
        "no pose explains these contacts on the table, but without --table one does; {} m must be "
        "the height of the table in the contacts' frame, z up",
        height);
  }
  return "no pose explains these contacts, with --table or without: another object, more noise "
         "than "
         "stated, or a mesh less exact than surface_sigma states";
}

/// Contacts sensed at the same time are of one grasp, whose place in the world is uncertain.
std::vector<lo::CommonModeBias> offsets_of_grasps(const std::vector<tactile::Contact>& contacts,
                                                  double rms) {
  std::map<double, lo::CommonModeBias> grasps;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    grasps[contacts[k].time].members.push_back({k});
  }
  std::vector<lo::CommonModeBias> offsets;
  for (auto& [time, offset] : grasps) {
    offset.sigma = rms / std::sqrt(3.0);
    if (rms > 0) offsets.push_back(std::move(offset));
  }
  return offsets;
}

/// Read once: the file may be a pipe.
/// @throws BadInput also for a file without contacts, if nothing else says where the object is
ContactFile read_contact_file(const LocalizeArguments& arguments) {
  ContactFile file{arguments.contacts, read_file(arguments.contacts), {}};
  file.contacts = lo::parse_contacts(file.text, file.name,
                                     {arguments.point_noise, arguments.normal_noise_deg * kDegree});
  const bool alone = !arguments.table && arguments.prior.empty();
  if (file.contacts.empty() && alone) {
    throw BadInput(file.name + " has no contacts: there is nothing below its header");
  }
  return file;
}

lo::Evidence evidence_of(const LocalizeArguments& arguments, const LocalizeOptions& options,
                         const ContactFile& file, const geometry::KnownObject& object) {
  check_together(file, geometry::bounds(object.mesh).diagonal().norm());
  lo::Evidence evidence;
  evidence.contacts = file.contacts;
  if (!arguments.prior.empty()) {
    evidence.prior = read_prior(arguments.prior, arguments.mesh, object.T_mesh_object);
  }
  if (arguments.table) {
    evidence.table = table_at(*arguments.table, evidence, object);
    evidence.table->centroid_sigma = options.centroid_sigma;
  } else if (options.centroid_sigma > 0) {
    throw BadInput(
        fmt::format("centroid_sigma = {} goes with --table: it is how far an object on "
                    "a table may lean",
                    options.centroid_sigma));
  }
  if (!arguments.free.empty()) evidence.free_space = lo::read_free_space(arguments.free);
  if (!arguments.planes.empty()) evidence.planes = lo::read_plane_contacts(arguments.planes);
  evidence.false_contact_share = options.false_contacts;
  evidence.noise_scale_prior = options.noise_scale_prior;
  evidence.size_prior = options.size_prior;
  evidence.surface_sigma = options.surface_sigma;
  evidence.offsets = offsets_of_grasps(evidence.contacts, options.hand_offset);
  return evidence;
}

/// The pose of the one object.
lo::Posterior search(const geometry::ObjectModel& model, const LocalizeArguments& arguments,
                     const LocalizeOptions& options, const ContactFile& file,
                     LocalizeResult& result) {
  const lo::Evidence evidence = evidence_of(arguments, options, file, model.object());
  const RandomStream random(arguments.common.seed, "localize");
  auto posterior = arguments.method == "fast"
                       ? lo::localize_fast(model, evidence, random, options.search, options.fast)
                       : lo::localize(model, evidence, random, options.search);
  if (posterior.status == lo::PoseStatus::no_pose) {
    result.hint = hint_for(model, evidence, random, options);
  }
  result.objects.candidates = {1};
  result.objects.probability = 1;
  result.objects.size = model.object().size;
  return posterior;
}

/// Which object it is, and its pose.
lo::Posterior identify(const std::vector<geometry::ObjectModel>& models,
                       const LocalizeArguments& arguments, const LocalizeOptions& options,
                       const ContactFile& file, LocalizeResult& result) {
  double area = 0, seconds = 0;
  for (const auto& model : models) area += model.area() / static_cast<double>(models.size());
  std::vector<lo::ObjectHypothesis> hypotheses;
  for (const auto& model : models) {
    lo::Evidence evidence = evidence_of(arguments, options, file, model.object());
    evidence.contact_area = area;
    hypotheses.push_back(lo::hypothesis_of(model, evidence,
                                           RandomStream(arguments.common.seed, "localize"),
                                           options.search, options.identify));
    seconds += hypotheses.back().posterior.seconds;
  }
  result.objects = lo::object_probabilities(hypotheses, options.identify);
  lo::SizedCandidates candidates;
  std::vector<lo::Posterior> posteriors;
  for (std::size_t i = 0; i < models.size(); ++i) {
    candidates.push_back(&models[i].object());
    posteriors.push_back(
        lo::weighted(std::move(hypotheses[i].posterior), result.objects.candidates[i]));
  }
  lo::choose_shape(candidates, result.objects);
  auto posterior = lo::pooled(candidates, result.objects, posteriors);
  posterior.seconds = seconds;
  return posterior;
}

LocalizeResult solve(const LocalizeArguments& arguments, const LocalizeOptions& options) {
  const Notice notice("preparing " + arguments.mesh + " and searching", arguments.common.quiet);
  const auto start = std::chrono::steady_clock::now();
  LocalizeResult result;
  result.method = arguments.method;
  result.ignore_spin = arguments.ignore_spin;
  result.names = with_sizes(mesh_names(arguments.mesh), arguments.size_range);
  if (result.names.size() > 1 && !arguments.prior.empty()) {
    throw BadInput(fmt::format("--prior {} is of one MESH of one size, {} are given",
                               arguments.prior, result.names.size()));
  }
  require_mesh_file(result.names, arguments.units);
  const ContactFile file = read_contact_file(arguments);  // before a mesh is prepared
  ObjectArguments known;
  known.units = arguments.units;
  const auto models = load_models(result.names, known);
  const std::chrono::duration<double> prepared = std::chrono::steady_clock::now() - start;
  result.prepare_seconds = prepared.count();
  result.posterior = models.size() == 1 ? search(models.front(), arguments, options, file, result)
                                        : identify(models, arguments, options, file, result);
  const auto& object = models[result.objects.best].object();
  result.T_object_mesh = object.T_mesh_object.inverse();
  result.repairs = object.repairs;
  return result;
}

/// What goes on from the pose of the one object.
void print_next_of(const LocalizeArguments& arguments, const CLI::App& command,
                   const LocalizeResult& result) {
  if (result.names.size() > 1) return;
  const std::string& out = arguments.common.out;
  if (!out.empty()) {
    print_next(arguments.common, fmt::format("palpate localize {} MORE_CONTACTS --prior {}",
                                             quoted(arguments.mesh), quoted(out + "/report.json")));
  } else if (result.posterior.status != lo::PoseStatus::no_pose) {
    const std::string folder = "out/localize-" + short_name(arguments.mesh);
    print_next(arguments.common, fmt::format("{} --out {} writes report.json, which --prior reads",
                                             given_command(command), quoted(folder)));
  }
}

int localize(const LocalizeArguments& arguments, const CLI::App& command) {
  if (arguments.demo) return demonstrate_localize(arguments.common);
  const auto options = resolve<LocalizeOptions>(arguments.common);
  const LocalizeResult result = solve(arguments, options);
  const auto report = report_of(result);
  if (!arguments.common.out.empty()) {
    const std::filesystem::path folder = arguments.common.out;
    const auto output = claim_output(arguments.common, {"report.json", "config.toml"});
    write_file_atomically(folder / "report.json", json_text(report));
    write_file_atomically(folder / "config.toml",
                          config_header(arguments.common) + to_toml(options));
  }
  if (arguments.common.json) {
    print_json(report);
  } else {
    print_result(result);
  }
  print_next_of(arguments, command, result);
  return result.posterior.status == lo::PoseStatus::no_pose ? kNoSolution : kDone;
}

constexpr const char* kLocalizeFooter =
    "Statuses: certain (the probability of one pose is above 0.95), ambiguous (the modes list "
    "the\n"
    "possible poses), no_pose (no pose explains the contacts; exit code 4).\n"
    "A mode's pose maps the mesh's own coordinates, in metres, into the contacts' frame; its\n"
    "covariance is of [rotation; translation] in that frame, rad and m. A mode with a free axis\n"
    "stands for all turns about that axis by up to its extent to either side.\n\n"
    "Examples:\n"
    "  palpate localize mug contacts.csv\n"
    "  palpate localize mug,box,part.ply contacts.csv\n"
    "  palpate localize part.ply contacts.csv --method full --json\n"
    "  palpate localize box contacts.csv --point-noise 0.002 --normal-noise-deg 15\n"
    "  palpate localize mug contacts.csv --set hand_offset=0.002   # contacts of one t: one "
    "grasp\n"
    "  palpate localize box contacts.csv --table 0 --free swept.csv\n"
    "  palpate localize box more.csv --prior before.json\n"
    "  palpate localize --demo --out demo";

}  // namespace

std::vector<OptionInfo> localize_option_list() { return list_options(LocalizeOptions{}); }

void add_localize(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<LocalizeArguments>();
  auto& command = *program.add_subcommand(
      "localize", "Estimate the pose of a known object from contacts, with a posterior");
  add_localize_arguments(command, *arguments);
  command.footer(kLocalizeFooter);
  command.callback([arguments, &command, &chosen] {
    check_localize_arguments(command, *arguments);
    chosen = [arguments, &command] { return localize(*arguments, command); };
  });
}

}  // namespace palpate::app
