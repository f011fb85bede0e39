// SPDX-License-Identifier: Apache-2.0
#include "localize_arguments.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <thread>

#include "object_option.hpp"
#include "palpate/localization/contacts_io.hpp"

namespace palpate::app {
namespace {

/// Whether the demonstration has an option's effect.
bool is_of_demo(const std::string& option) {
  constexpr std::array kNames = {"--seed", "--threads", "--out", "--force", "--json", "--quiet"};
  return std::find(kNames.begin(), kNames.end(), option) != kNames.end();
}

/// Only what the demonstration has goes with it, and --threads with nothing else.
void check_demo(const CLI::App& command, bool demo) {
  for (const CLI::Option* option : command.get_options()) {
    if (option->count() == 0 || option->get_name() == "--demo") continue;
    if (demo && !is_of_demo(option->get_name())) {
      throw CLI::ExcludesError("--demo", option->get_name());
    }
    if (!demo && option->get_name() == "--threads") {
      throw CLI::RequiresError("--threads", "--demo");
    }
  }
}

void add_mesh_and_contacts(CLI::App& command, LocalizeArguments& arguments) {
  command
      .add_option(
          "mesh", arguments.mesh,
          "built-in object (mug, bottle, box, bracket, duck), generated:SEED, or mesh file; of "
          "several, separated by commas, the most probable one is identified as well")
      ->option_text("MESH[,MESH..]");
  command
      .add_option(
          "contacts", arguments.contacts,
          "CSV with x,y,z[,nx,ny,nz,point_sigma,normal_sigma,group,finger,t,fx,fy,fz] in metres, "
          "normals pointing out of the object; at least one contact of a group touches")
      ->option_text("CONTACTS");
  add_units_option(command, arguments.units);
  add_size_range_option(command, arguments.size_range);
}

void add_noise(CLI::App& command, LocalizeArguments& arguments) {
  command
      .add_option("--point-noise", arguments.point_noise,
                  "standard deviation of contact points per axis, m")
      ->option_text("M")
      ->check(in_range(1e-5, localization::kMaxPointNoise))
      ->capture_default_str();
  command
      .add_option("--normal-noise-deg", arguments.normal_noise_deg,
                  "standard deviation of contact normals per tangent axis, deg")
      ->option_text("DEG")
      ->check(in_range(0.1, 90.0))
      ->capture_default_str();
}

/// What is known of the pose beside the contacts.
void add_further_evidence(CLI::App& command, LocalizeArguments& arguments) {
  command
      .add_option("--table", arguments.table,
                  "the object rests on a table at this height in the contacts' frame, z up, m")
      ->option_text("Z")
      ->check(in_range(-100.0, 100.0));
  command
      .add_option("--free", arguments.free,
                  "CSV of what is known to be free of the object, m: balls x,y,z,radius, or the "
                  "voxels x,y,z,size of a grid")
      ->option_text("FILE");
  command
      .add_option("--planes", arguments.planes,
                  "CSV of planes on which the held object was let down until it touched, in the "
                  "contacts' frame: nx,ny,nz,height[,sigma], normal to the object's side, m")
      ->option_text("FILE");
  command
      .add_option("--prior", arguments.prior,
                  "use the posterior of an earlier localize --json for the same MESH as prior")
      ->option_text("FILE");
}

}  // namespace

std::vector<std::string> mesh_names(const std::string& meshes) {
  std::error_code error;  // of names that together are too long for one
  if (std::filesystem::exists(meshes, error)) return {meshes};
  return CLI::detail::split(meshes, ',');
}

void add_localize_arguments(CLI::App& command, LocalizeArguments& arguments) {
  command.add_flag("--demo", arguments.demo,
                   "instead, grasp the built-in objects with a kinematic hand and report how "
                   "many contacts determine their poses; on all processors, or --threads of them");
  add_mesh_and_contacts(command, arguments);
  command
      .add_option("--method", arguments.method,
                  "for one MESH: fast (falls back to full if several poses fit) or full")
      ->check(CLI::IsMember({"fast", "full"}))
      ->capture_default_str();
  add_noise(command, arguments);
  add_further_evidence(command, arguments);
  command.add_flag("--ignore-spin", arguments.ignore_spin,
                   "ignore turns about a mode's free axis: its probability is then its weight");
  add_common_options(command, arguments.common);
}

void check_localize_arguments(const CLI::App& command, LocalizeArguments& arguments) {
  check_demo(command, arguments.demo);
  if (arguments.demo && command.count("--threads") == 0) {
    arguments.common.threads = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  }
  if (command.count("--method") > 0 &&
      (mesh_names(arguments.mesh).size() > 1 || arguments.size_range > 0)) {
    throw CLI::ValidationError("--method", "goes with one MESH of one size; of several it is full");
  }
  if (!arguments.demo && arguments.contacts.empty()) {
    if (!arguments.mesh.empty()) throw CLI::RequiredError("CONTACTS");
    throw CLI::RequiredError("MESH and CONTACTS, or --demo, are required",
                             CLI::ExitCodes::RequiredError);
  }
}

}  // namespace palpate::app
