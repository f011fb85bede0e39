// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <thread>

#include "common.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/cache.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/version.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/rendering/renderer.hpp"
#include "palpate/simulation/world/convex_parts.hpp"
#include "palpate/simulation/world/world.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

struct Check {
  std::string name;
  bool ok = false;
  std::string hint;  ///< what was found, or how to get it
  bool required = true;
};

Check check_program() {
  return {"palpate", true, fmt::format("{}, built with GCC {}", version(), __VERSION__)};
}

Check check_simulator() { return {"MuJoCo", true, std::string(simulation::simulator_version())}; }

Check check_asset(const char* name, const char* path) {
  try {
    return {name, true, asset(path).string()};
  } catch (const BadInput& error) {
    return {name, false, error.what()};
  }
}

Check check_hand() {
  Check check = check_asset("hand model", "shadow_hand/right_hand.xml");
  if (!check.ok) return check;
  try {
    simulation::load_shadow_hand(check.hint);
  } catch (const BadInput& error) {
    return {check.name, false, error.what()};
  }
  return check;
}

Check check_decomposition() {
  geometry::TriangleMesh tetrahedron;
  tetrahedron.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}};
  tetrahedron.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  try {
    const auto parts = simulation::convex_parts(tetrahedron);
    return {"CoACD", true, fmt::format("a tetrahedron has {} convex part", parts.size())};
  } catch (const BadInput& error) {
    return {"CoACD", false, error.what()};
  }
}

Check check_cache() {
  constexpr std::string_view kKey = "doctor";
  write_cache(kKey, version());
  const bool kept = read_cache(kKey) == version();
  return {"cache", kept,
          kept ? "keeps what is slow to compute"
               : "every run computes convex parts again: set PALPATE_CACHE to a writable folder",
          false};
}

Check check_rendering() {
  const auto backend = simulation::working_render_backend();
  return {"rendering", backend.has_value(),
          backend ? std::string(to_string(*backend))
                  : "palpate render needs EGL or OSMesa (Debian: apt-get install libegl1 "
                    "libgl1-mesa-dri libopengl0)",
          false};
}

Check check_threads() {
  return {"threads", true, fmt::format("{} for --threads", std::thread::hardware_concurrency())};
}

Check check_data() {
  const char* const folder = std::getenv("PALPATE_DATA");
  return {
      "PALPATE_DATA", true,
      folder ? folder : "optional, not set: only tests on measured data use it, and skip without",
      false};
}

std::vector<Check> all_checks() {
  return {check_program(),
          check_simulator(),
          check_decomposition(),
          check_hand(),
          check_asset("Adroit hand", "adroit_hand/adroit_relocate.xml"),
          check_asset("viewer", "viewer.js"),
          check_asset("page", "page.html"),
          check_cache(),
          check_rendering(),
          check_threads(),
          check_data()};
}

void print_checks_as_json(const std::vector<Check>& checks) {
  auto list = nlohmann::json::array();
  for (const Check& check : checks) {
    list.push_back({{"name", check.name},
                    {"ok", check.ok},
                    {"required", check.required},
                    {"hint", check.hint}});
  }
  print_json(nlohmann::json{{"checks", list}});
}

int doctor(bool as_json) {
  const auto checks = all_checks();
  const bool ready = std::all_of(checks.begin(), checks.end(),
                                 [](const Check& check) { return check.ok || !check.required; });
  if (as_json) {
    print_checks_as_json(checks);
  } else {
    for (const Check& check : checks) {
      const std::string_view status =
          check.ok ? "ok" : "missing";  // then padded: colors have no width
      fmt::print("{:<13} {}{:<{}} {}\n", check.name, colored_status(status), "", 8 - status.size(),
                 check.hint);
    }
    fmt::print("{}\n", ready ? "ready" : "not ready: see what is missing");
  }
  return ready ? kDone : kBadInput;
}

}  // namespace

void add_doctor(CLI::App& program, Command& chosen) {
  auto common = std::make_shared<CommonOptions>();
  auto& command =
      *program.add_subcommand("doctor", "Check that everything palpate needs is installed");
  add_common_options(command, *common, 0);
  command.footer(
      "Lists what is installed, what is missing, and how to get it. Exit code 0 if nothing that "
      "is\n"
      "needed is missing, else 3. Without rendering or a cache only palpate render fails.\n\n"
      "Examples:\n"
      "  palpate doctor\n"
      "  palpate doctor --json");
  command.callback([common, &chosen] { chosen = [common] { return doctor(common->json); }; });
}

}  // namespace palpate::app
