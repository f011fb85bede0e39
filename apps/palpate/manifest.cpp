// SPDX-License-Identifier: Apache-2.0
#include "manifest.hpp"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <fstream>
#include <string>
#include <thread>

#include "palpate/core/csv.hpp"
#include "palpate/core/version.hpp"

namespace palpate::app {
namespace {

/// As Linux names it; empty where it does not.
std::string processor() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with("model name")) continue;
    return std::string(trimmed(std::string_view(line).substr(line.find(':') + 1)));
  }
  return "";
}

}  // namespace

nlohmann::json manifest() {
  utsname system{};
  uname(&system);
  return {{"program_version", version()},
          {"commit", commit()},
          {"machine",
           {{"name", system.nodename},
            {"system", fmt::format("{} {} {}", system.sysname, system.release, system.machine)},
            {"processor", processor()},
            {"cores", std::thread::hardware_concurrency()}}}};
}

}  // namespace palpate::app
