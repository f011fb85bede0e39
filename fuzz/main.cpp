// SPDX-License-Identifier: Apache-2.0
// Structure-aware fuzzing of every loader. See ./dev fuzz and docs/loaders.md.
#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <string>

#include "grammar.hpp"
#include "mutate.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "targets.hpp"

namespace palpate::fuzz {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr unsigned kMaxSeconds = 20;  // for one input
constexpr rlim_t kMaxMemory = rlim_t{4} << 30;

constexpr std::size_t kFewRuns = 100;  // of which none may be accepted

struct Budget {
  double seconds = 1e9;
  std::size_t runs = static_cast<std::size_t>(-1);
  std::uint64_t seed = 1;
};

/// Inputs for a target: sentences of its grammar, its corpus, and mutations of both.
class Inputs {
 public:
  Inputs(const Target& target, const fs::path& source, const fs::path& work)
      : keep_bytes_(target.keep_bytes) {
    const fs::path corpus = source / "corpus" / target.name;
    if (fs::exists(corpus)) {
      for (const auto& entry : fs::directory_iterator(corpus)) paths_.push_back(entry.path());
    }
    std::sort(paths_.begin(), paths_.end());
    for (const auto& path : paths_) seeds_.push_back(read_file(path));
    if (target.sample) seeds_.push_back(target.sample(work));
    if (!target.grammar.empty()) {
      grammar_.emplace(source / "grammars" / (target.grammar + ".txt"));
    }
  }

  /// The corpus as it is comes first, then what is made of it.
  std::string next(RandomStream& random) {
    if (count_ < seeds_.size()) return seeds_[count_++];
    const bool write = grammar_ && (seeds_.empty() || random.index(2) == 0);
    std::string input = write ? grammar_->sentence(random) : seeds_[random.index(seeds_.size())];
    if (keep_bytes_) return input;
    return random.index(3) > 0 ? mutated(std::move(input), random) : input;
  }

 private:
  bool keep_bytes_;
  std::vector<fs::path> paths_;
  std::vector<std::string> seeds_;
  std::optional<Grammar> grammar_;
  std::size_t count_ = 0;
};

/// Loads one input. @return whether it was accepted
/// @throws what the loader throws beside a BadInput of one line
bool try_input(const Target& target, const fs::path& file) {
  alarm(kMaxSeconds);
  bool accepted = true;
  try {
    target.load(file);
  } catch (const BadInput& error) {
    accepted = false;
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) {
      throw std::logic_error(fmt::format("a message of several lines: {}", error.what()));
    }
  }
  alarm(0);
  return accepted;
}

void run(const Target& target, const Budget& budget, const fs::path& source, const fs::path& work) {
  const fs::path folder = work / target.name;
  fs::create_directories(folder);
  Inputs inputs(target, source, folder);
  RandomStream random(budget.seed, target.name);
  const auto end = Clock::now() + std::chrono::duration<double>(budget.seconds);
  std::size_t runs = 0, accepted = 0;
  for (; runs < budget.runs && Clock::now() < end; ++runs) {
    const fs::path file = folder / target.file;  // what is left there after a crash caused it
    std::ofstream(file, std::ios::binary) << inputs.next(random);
    if (target.finish) target.finish(file, random);
    try {
      accepted += try_input(target, file) ? 1 : 0;
    } catch (const std::exception& error) {
      fmt::print(stderr, "{}: {} (run {}): {}\n", target.name, file.string(), runs, error.what());
      std::abort();
    }
  }
  fmt::print("{:<11} {:>9} inputs, {:>8} accepted\n", target.name, runs, accepted);
  std::fflush(stdout);
  if (accepted > 0 || runs < kFewRuns) return;
  fmt::print(stderr, "{}: not even the inputs that are whole were accepted\n", target.name);
  std::abort();
}

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
    run(target, budget, argv[1], argv[2]);
  }
  if (!found) fmt::print(stderr, "no target is called '{}'\n", wanted);
  return found ? 0 : 2;
}

}  // namespace
}  // namespace palpate::fuzz

int main(int argc, char** argv) {
  // A sanitizer reserves more address space than any limit; it has limits of its own.
  if (std::getenv("ASAN_OPTIONS") == nullptr) {
    const rlimit limit{palpate::fuzz::kMaxMemory, palpate::fuzz::kMaxMemory};
    setrlimit(RLIMIT_AS, &limit);
  }
  return palpate::fuzz::main(argc, argv);
}
