// SPDX-License-Identifier: Apache-2.0
// Structure-aware fuzzing of every loader. See ./dev fuzz and docs/loaders.md.
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <string>

#include "guided.hpp"
#include "inputs.hpp"

namespace palpate::fuzz {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

#ifndef PALPATE_LIBFUZZER
void run(const Target& target, const Budget& budget, const fs::path& source,
         const fs::path& folder) {
  Inputs inputs(target, source, folder);
  RandomStream random(budget.seed, target.name);
  const auto end = Clock::now() + std::chrono::duration<double>(budget.seconds);
  std::size_t runs = 0, accepted = 0;
  for (; runs < budget.runs && Clock::now() < end; ++runs) {
    const std::string input = inputs.next(random);
    alarm(kMaxSeconds);
    try {
      accepted += try_input(target, input, folder, random) ? 1 : 0;
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}: {} (run {}): {}\n", target.name, (folder / target.file).string(),
                 runs, error.what());
      std::abort();
    }
    alarm(0);
  }
  if (!report(target, runs, accepted)) std::abort();
}
#else
/// In a process of its own, for libFuzzer ends it.
void run(const Target& target, const Budget& budget, const fs::path& source,
         const fs::path& folder) {
  const pid_t child = fork();
  if (child == 0) run_guided(target, budget, source, folder);
  int status = 1;
  waitpid(child, &status, 0);
  if (status == 0) return;
  fmt::print(stderr, "{}: failed; the input is in {}\n", target.name, folder.string());
  std::exit(1);
}
#endif

int main(int argc, char** argv) {
  if (argc < 4) {
    fmt::print(stderr,
               "usage: palpate_fuzz FUZZ_FOLDER WORK_FOLDER all|TARGET "
               "[--minutes N] [--runs N] [--seed N]\n");
    return 2;
  }
  const std::string wanted = argv[3];
  Budget budget;
  for (int i = 4; i + 1 < argc; i += 2) {
    const std::string option = argv[i];
    if (option == "--minutes") budget.seconds = 60 * std::stod(argv[i + 1]);
    if (option == "--runs") budget.runs = std::stoul(argv[i + 1]);
    if (option == "--seed") budget.seed = std::stoul(argv[i + 1]);
  }
  const auto targets = all_targets();
  if (wanted == "all") budget.seconds /= static_cast<double>(targets.size());
  bool found = false;
  for (const auto& target : targets) {
    if (wanted != "all" && wanted != target.name) continue;
    found = true;
    const fs::path folder = fs::path(argv[2]) / target.name;
    fs::create_directories(folder);
    run(target, budget, argv[1], folder);
  }
  if (!found) fmt::print(stderr, "no target is called '{}'\n", wanted);
  return found ? 0 : 2;
}

}  // namespace
}  // namespace palpate::fuzz

int main(int argc, char** argv) {
  // A sanitizer reserves more address space than any limit; it has limits of its own.
  if (std::getenv("ASAN_OPTIONS") == nullptr) {
    const rlim_t bytes = rlim_t{palpate::fuzz::kMaxMegabytes} << 20;
    const rlimit limit{bytes, bytes};
    setrlimit(RLIMIT_AS, &limit);
  }
  return palpate::fuzz::main(argc, argv);
}
