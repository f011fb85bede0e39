// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include "common.hpp"
#include "localize_demo.hpp"
#include "localize_evidence.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/se3.hpp"
#include "palpate/localization/contacts_io.hpp"
#include "palpate/localization/identification.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

namespace lo = localization;

constexpr std::size_t kMaxShown = 10;  // modes
constexpr double kCertain = 0.95;      // probability, as of the search's own status

struct LocalizeOptions {
  lo::LocalizerOptions search;
  lo::FastOptions fast;
  lo::IdentificationOptions identify;
  double false_contacts = 0.02;
  double noise_scale_prior = 0.4;
  double size_prior = 0.25;
  double surface_sigma = 0.0003;
  double hand_offset = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("false_contacts", false_contacts, 0.001, 0.9, "prior share of contacts with something else");
    v("noise_scale_prior", noise_scale_prior, 0.0, 0.99,
      "chance of noise other than stated, half to twice");
    v("size_prior", size_prior, 0.0, 0.99, "chance of an object up to 3 % off its mesh's size");
    v("surface_sigma", surface_sigma, 0.0, 0.01, "m by which the mesh is off the object's surface");
    v("hand_offset", hand_offset, 0.0, 0.02, "m rms, by which contacts of one time are displaced");
    v.section("search", search);
    v.section("fast", fast);
    v.section("identify", identify);
  }
};

struct LocalizeArguments {
  CommonOptions common;
  std::string mesh, contacts;
  std::string method = "fast";
  bool demo = false, ignore_spin = false;
  double point_noise = 0.001, normal_noise_deg = 10;
  std::optional<double> table;
  std::string free, prior;
};

struct Result {
  std::vector<std::string> names;   // of the objects
  lo::ObjectProbabilities objects;  // which one it is
  lo::Posterior posterior;          // of the most probable one
  Eigen::Isometry3d T_object_mesh;  // the search's object frame is at the centroid, the file's not
  std::vector<std::string> repairs;
  std::string hint;
  double prepare_seconds = 0;
};

std::vector<tactile::Contact> flipped(std::vector<tactile::Contact> contacts) {
  for (auto& contact : contacts) contact.n = -contact.n;
  return contacts;
}

/// Why no pose may explain the contacts.
std::string hint_for(const geometry::ObjectModel& model, lo::Evidence evidence, RandomStream random,
                     const LocalizeOptions& options) {
  if (evidence.contacts.empty()) return "there are no contacts";
  evidence.contacts = flipped(std::move(evidence.contacts));
  const auto posterior = lo::localize(model, evidence, random, options.search);
  if (posterior.status == lo::PoseStatus::no_pose) {
    return "no pose explains these contacts: another object, or more noise than stated";
  }
  return "no pose explains these contacts, but with all normals reversed one does; they must point "
         "out of the object";
}

/// Contacts felt at the same time are of one grasp, whose place in the world is uncertain.
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

/// MESH or MESH,MESH..; a file may have commas in its name.
std::vector<std::string> names_of(const std::string& meshes) {
  if (std::filesystem::exists(meshes)) return {meshes};
  return CLI::detail::split(meshes, ',');
}

lo::Evidence evidence_of(const LocalizeArguments& arguments, const LocalizeOptions& options,
                         const geometry::KnownObject& object) {
  lo::Evidence evidence;
  evidence.contacts = lo::read_contacts(
      arguments.contacts, {arguments.point_noise, arguments.normal_noise_deg * kDegree});
  if (arguments.table) evidence.table = table_at(*arguments.table, evidence.contacts, object);
  if (!arguments.free.empty()) evidence.free_space = lo::read_free_spheres(arguments.free);
  if (!arguments.prior.empty()) {
    evidence.prior = read_prior(arguments.prior, object.T_mesh_object);
  }
  evidence.false_contact_share = options.false_contacts;
  evidence.noise_scale_prior = options.noise_scale_prior;
  evidence.size_prior = options.size_prior;
  evidence.surface_sigma = options.surface_sigma;
  evidence.offsets = offsets_of_grasps(evidence.contacts, options.hand_offset);
  return evidence;
}

/// The pose of the one object.
lo::Posterior search(const geometry::ObjectModel& model, const LocalizeArguments& arguments,
                     const LocalizeOptions& options, Result& result) {
  const lo::Evidence evidence = evidence_of(arguments, options, model.object());
  const RandomStream random(arguments.common.seed, "localize");
  auto posterior = arguments.method == "fast"
                       ? lo::localize_fast(model, evidence, random, options.search, options.fast)
                       : lo::localize(model, evidence, random, options.search);
  if (posterior.status == lo::PoseStatus::no_pose) {
    result.hint = hint_for(model, evidence, random, options);
  }
  result.objects.candidates = {1};
  return posterior;
}

/// Which object it is, and its pose.
lo::Posterior identify(const std::vector<geometry::ObjectModel>& models,
                       const LocalizeArguments& arguments, const LocalizeOptions& options,
                       Result& result) {
  double area = 0, seconds = 0;
  for (const auto& model : models) area += model.area() / static_cast<double>(models.size());
  std::vector<lo::ObjectHypothesis> hypotheses;
  for (const auto& model : models) {
    lo::Evidence evidence = evidence_of(arguments, options, model.object());
    evidence.contact_area = area;
    hypotheses.push_back(lo::hypothesis_of(model, evidence,
                                           RandomStream(arguments.common.seed, "localize"),
                                           options.search, options.identify));
    seconds += hypotheses.back().posterior.seconds;
  }
  result.objects = lo::object_probabilities(hypotheses, options.identify);
  const std::size_t best = result.objects.best;
  auto posterior =
      lo::weighted(std::move(hypotheses[best].posterior), result.objects.candidates[best]);
  posterior.seconds = seconds;
  return posterior;
}

Result solve(const LocalizeArguments& arguments, const LocalizeOptions& options) {
  const Notice notice("preparing " + arguments.mesh + " and searching", arguments.common.quiet);
  const auto start = std::chrono::steady_clock::now();
  Result result;
  result.names = names_of(arguments.mesh);
  if (result.names.size() > 1 && !arguments.prior.empty()) {
    throw BadInput(fmt::format("--prior {} is of one MESH, {} are given", arguments.prior,
                               result.names.size()));
  }
  std::vector<geometry::ObjectModel> models;
  for (const auto& name : result.names) models.emplace_back(geometry::load_known_object(name));
  const std::chrono::duration<double> prepared = std::chrono::steady_clock::now() - start;
  result.prepare_seconds = prepared.count();
  result.posterior = models.size() == 1 ? search(models.front(), arguments, options, result)
                                        : identify(models, arguments, options, result);
  const auto& object = models[result.objects.best].object();
  result.T_object_mesh = object.T_mesh_object.inverse();
  result.repairs = object.repairs;
  return result;
}

/// Of the mesh's pose in the contacts' frame.
Matrix6d mesh_covariance(const lo::Mode& mode, const Eigen::Isometry3d& T_object_mesh) {
  return covariance_at(mode.T_frame_object.linear() * T_object_mesh.translation(), mode.covariance);
}

/// That the object is where the mode says, turns about the mode's free axis aside if asked.
double probability_of(const lo::Mode& mode, bool ignore_spin) {
  return ignore_spin ? mode.weight : lo::pose_probability(mode);
}

/// As the posterior's own, or where spin does not matter by the best mode's weight.
std::string_view status_of(const lo::Posterior& posterior, bool ignore_spin) {
  if (!ignore_spin || posterior.modes.empty()) return lo::to_string(posterior.status);
  const bool certain = posterior.modes.front().weight > kCertain;
  return lo::to_string(certain ? lo::PoseStatus::certain : lo::PoseStatus::ambiguous);
}

double best_probability(const lo::Posterior& posterior, bool ignore_spin) {
  if (posterior.modes.empty()) return 0;
  return probability_of(posterior.modes.front(), ignore_spin);
}

std::vector<double> row_major(const Matrix6d& matrix) {
  std::vector<double> values;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) values.push_back(matrix(i, j));
  }
  return values;
}

std::array<double, 3> triple(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }

nlohmann::json axis_json(const lo::Mode& mode) {
  if (!mode.free_axis) return nullptr;
  return {{"point", triple(mode.free_axis->point)},
          {"direction", triple(mode.free_axis->direction)},
          {"extent", mode.free_axis->extent}};
}

nlohmann::json report_of(const LocalizeArguments& arguments, const Result& result) {
  auto modes = nlohmann::json::array();
  for (const lo::Mode& mode : result.posterior.modes) {
    modes.push_back({{"T_contact_object", to_json(mode.T_frame_object * result.T_object_mesh)},
                     {"weight", mode.weight},
                     {"probability", probability_of(mode, arguments.ignore_spin)},
                     {"covariance", row_major(mesh_covariance(mode, result.T_object_mesh))},
                     {"free_axis", axis_json(mode)}});
  }
  auto further = nlohmann::json::array();
  for (const auto& T : result.posterior.further)
    further.push_back(to_json(T * result.T_object_mesh));
  auto objects = nlohmann::json::array();
  for (std::size_t i = 0; i < result.names.size(); ++i) {
    objects.push_back({{"name", result.names[i]}, {"probability", result.objects.candidates[i]}});
  }
  return {{"status", status_of(result.posterior, arguments.ignore_spin)},
          {"object", result.names[result.objects.best]},
          {"objects", objects},
          {"other_object", result.objects.other},
          {"probability", best_probability(result.posterior, arguments.ignore_spin)},
          {"modes", modes},
          {"unlisted", result.posterior.unlisted()},
          {"further", further},
          {"method", arguments.method},
          {"hint", result.hint},
          {"repairs", result.repairs},
          {"prepare_seconds", result.prepare_seconds},
          {"seconds", result.posterior.seconds}};
}

void print_mode(const lo::Mode& mode, const Eigen::Isometry3d& T_object_mesh, bool ignore_spin) {
  const Eigen::Isometry3d T = mode.T_frame_object * T_object_mesh;
  const Eigen::Vector3d w = log_so3(T.linear()) / kDegree, t = 1e3 * T.translation();
  const Matrix6d covariance = mesh_covariance(mode, T_object_mesh);
  fmt::print(
      "{:6.3f}  ({:7.1f}, {:7.1f}, {:7.1f}) deg  ({:7.1f}, {:7.1f}, {:7.1f}) mm  +- {:.1f} deg, "
      "{:.1f} mm",
      probability_of(mode, ignore_spin), w[0], w[1], w[2], t[0], t[1], t[2],
      std::sqrt(covariance.topLeftCorner<3, 3>().trace()) / kDegree,
      1e3 * std::sqrt(covariance.bottomRightCorner<3, 3>().trace()));
  if (mode.free_axis) {
    const auto& axis = *mode.free_axis;
    fmt::print("  free by +- {:.0f} deg about ({:.2f}, {:.2f}, {:.2f})", axis.extent / kDegree,
               axis.direction[0], axis.direction[1], axis.direction[2]);
  }
  fmt::print("\n");
}

void print_result(const Result& result, bool ignore_spin) {
  fmt::print("{}: {} mode{} in {:.0f} ms, after {:.2f} s of preparation\n",
             colored_status(status_of(result.posterior, ignore_spin)),
             result.posterior.modes.size(), result.posterior.modes.size() == 1 ? "" : "s",
             1e3 * result.posterior.seconds, result.prepare_seconds);
  for (std::size_t i = 0; result.names.size() > 1 && i < result.names.size(); ++i) {
    fmt::print("{:6.3f}  {}\n", result.objects.candidates[i], result.names[i]);
  }
  if (result.names.size() > 1) fmt::print("{:6.3f}  another object\n", result.objects.other);
  for (const auto& repair : result.repairs) fmt::print("mesh repaired: {}\n", repair);
  if (!result.hint.empty()) fmt::print("{}\n", result.hint);
  if (result.posterior.modes.empty()) return;
  fmt::print("weight  rotation vector                translation\n");
  const auto& modes = result.posterior.modes;
  const std::size_t shown = std::min(kMaxShown, modes.size());
  for (std::size_t i = 0; i < shown; ++i) {
    print_mode(modes[i], result.T_object_mesh, ignore_spin);
  }
  if (shown < modes.size()) {
    double rest = 0;
    for (std::size_t i = shown; i < modes.size(); ++i) rest += modes[i].weight;
    fmt::print("{:6.3f}  in {} more (--json lists them)\n", rest, modes.size() - shown);
  }
  const std::size_t further = result.posterior.further.size();
  if (further == 0) return;
  fmt::print("{:6.3f}  elsewhere, most of it about {} poses (--json lists them)\n",
             result.posterior.unlisted(), further);
}

int localize(const LocalizeArguments& arguments) {
  if (arguments.demo) return demonstrate_localize(arguments.common);
  const auto options = resolve<LocalizeOptions>(arguments.common);
  const Result result = solve(arguments, options);
  const auto report = report_of(arguments, result);
  if (!arguments.common.out.empty()) {
    const std::filesystem::path folder = arguments.common.out;
    const auto output = claim_output(arguments.common, {"report.json", "config.toml"});
    write_file_atomically(folder / "report.json", report.dump(2) + "\n");
    write_file_atomically(folder / "config.toml",
                          config_header(arguments.common) + to_toml(options));
  }
  if (arguments.common.json) {
    fmt::print("{}\n", report.dump(2));
  } else {
    print_result(result, arguments.ignore_spin);
  }
  return result.posterior.status == lo::PoseStatus::no_pose ? kNoSolution : kDone;
}

/// Whether the demonstration has an option's effect.
bool is_of_demo(const std::string& option) {
  constexpr std::array kNames = {"--seed", "--threads", "--out", "--force", "--json", "--quiet"};
  return std::find(kNames.begin(), kNames.end(), option) != kNames.end();
}

}  // namespace

std::vector<OptionInfo> localize_option_list() { return list_options(LocalizeOptions{}); }

void add_localize(CLI::App& program, Command& chosen) {
  auto arguments = std::make_shared<LocalizeArguments>();
  auto& command = *program.add_subcommand(
      "localize", "Estimate the pose of a known object from contacts, with a posterior");
  command.add_flag("--demo", arguments->demo,
                   "grasp the built-in objects with a kinematic hand instead, and report how "
                   "many contacts determine their poses");
  command
      .add_option("mesh", arguments->mesh,
                  "built-in object (mug, bottle, box, bracket, duck) or mesh file in metres; of "
                  "several, with commas between, it may be any: which one is estimated, too")
      ->option_text("MESH[,MESH..]");
  command
      .add_option(
          "contacts", arguments->contacts,
          "CSV with x,y,z[,nx,ny,nz,point_sigma,normal_sigma,group,finger,t,fx,fy,fz] in metres, "
          "normals out of the object; of a group at least one contact touches")
      ->option_text("CONTACTS");
  command
      .add_option("--method", arguments->method,
                  "fast (which turns to full where several poses fit) or full")
      ->check(CLI::IsMember({"fast", "full"}))
      ->capture_default_str();
  command.add_option("--point-noise", arguments->point_noise, "of contact points per axis, m")
      ->option_text("M")
      ->check(CLI::Range(1e-5, 0.1))
      ->capture_default_str();
  command
      .add_option("--normal-noise-deg", arguments->normal_noise_deg,
                  "of contact normals per tangent axis, deg")
      ->option_text("DEG")
      ->check(CLI::Range(0.1, 90.0))
      ->capture_default_str();
  command
      .add_option("--table", arguments->table,
                  "the object rests on a table at this height in the contacts' frame, z up, m")
      ->option_text("Z")
      ->check(CLI::Range(-100.0, 100.0));
  command
      .add_option("--free", arguments->free,
                  "CSV with x,y,z,radius of balls that are known to be free of the object, m")
      ->option_text("FILE");
  command
      .add_option("--prior", arguments->prior,
                  "prior: an earlier result of localize --json for the same MESH")
      ->option_text("FILE");
  command.add_flag("--ignore-spin", arguments->ignore_spin,
                   "turns about a mode's free axis do not matter: its probability is its weight");
  add_common_options(command, arguments->common);
  command.footer(
      "Statuses: certain (the probability of one pose is above 0.95), ambiguous (the modes list "
      "the\n"
      "possible poses), no_pose (no pose explains the contacts; exit code 4).\n"
      "A mode's pose maps the mesh's own coordinates into the contacts' frame; its covariance is "
      "of\n"
      "[rotation; translation] in that frame, rad and m. A mode with a free axis stands for all\n"
      "turns about that axis by up to its extent to either side.\n\n"
      "Examples:\n"
      "  palpate localize mug contacts.csv\n"
      "  palpate localize mug,box,part.ply contacts.csv\n"
      "  palpate localize part.ply contacts.csv --method full --json\n"
      "  palpate localize box contacts.csv --point-noise 0.002 --normal-noise-deg 15\n"
      "  palpate localize mug contacts.csv --set hand_offset=0.002   # contacts of one t: one "
      "grasp\n"
      "  palpate localize box contacts.csv --table 0 --free swept.csv\n"
      "  palpate localize box more.csv --prior before.json\n"
      "  palpate localize --demo --out demo");
  command.callback([arguments, &command, &chosen] {
    for (const CLI::Option* option : command.get_options()) {
      if (option->count() == 0 || option->get_name() == "--demo") continue;
      if (arguments->demo && !is_of_demo(option->get_name())) {
        throw CLI::ExcludesError("--demo", option->get_name());
      }
      if (!arguments->demo && option->get_name() == "--threads") {
        throw CLI::RequiresError("--threads", "--demo");
      }
    }
    if (!arguments->demo && arguments->contacts.empty()) {
      throw CLI::RequiredError("MESH and CONTACTS, or --demo,");
    }
    chosen = [arguments] { return localize(*arguments); };
  });
}

}  // namespace palpate::app
