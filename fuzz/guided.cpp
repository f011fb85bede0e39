// SPDX-License-Identifier: Apache-2.0
#include "guided.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "palpate/core/file.hpp"

extern "C" {
// Of libFuzzer.
int LLVMFuzzerRunDriver(int* argc, char*** argv, int (*try_one)(const std::uint8_t*, std::size_t));
std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);
}

namespace palpate::fuzz {
namespace {

namespace fs = std::filesystem;

/// An input begins with the seed of what a target changes itself (Target::finish).
constexpr std::size_t kSeed = sizeof(std::uint64_t);

/// What libFuzzer's functions, which have no argument for it, work on.
struct GuidedRun {
  const Target& target;
  Inputs inputs;
  fs::path folder;
  std::size_t runs = 0, accepted = 0;
};
GuidedRun* guided = nullptr;

std::uint64_t seed_of(const std::uint8_t* data) {
  std::uint64_t seed = 0;
  std::memcpy(&seed, data, kSeed);
  return seed;
}

int try_one(const std::uint8_t* data, std::size_t size) {
  if (size < kSeed) return -1;
  RandomStream random(seed_of(data), guided->target.name);
  const std::string_view input(reinterpret_cast<const char*>(data) + kSeed, size - kSeed);
  ++guided->runs;
  guided->accepted += try_input(guided->target, input, guided->folder, random) ? 1 : 0;
  return 0;
}

std::size_t change_bytes(std::uint8_t* bytes, std::size_t size, std::size_t max_size,
                         RandomStream& random) {
  if (!guided->target.keep_bytes && random.index(3) == 0) {
    return LLVMFuzzerMutate(bytes, size, max_size);
  }
  const std::string changed =
      guided->inputs.changed({reinterpret_cast<const char*>(bytes), size}, random);
  const std::size_t length = std::min(changed.size(), max_size);
  std::memcpy(bytes, changed.data(), length);
  return length;
}

/// Without damaged files that a library reads beyond the end of (HDF5 1.10): the last is the
/// sample.
void write_seeds(const fs::path& corpus) {
  fs::create_directories(corpus);
  const auto& seeds = guided->inputs.seeds();
  const std::size_t first = guided->target.keep_bytes ? seeds.size() - 1 : 0;
  for (std::size_t i = first; i < seeds.size(); ++i) {
    write_file_atomically(corpus / fmt::format("seed-{}", i), std::string(kSeed, '\0') + seeds[i]);
  }
}

void end() {
  if (!report(guided->target, guided->runs, guided->accepted)) std::_Exit(1);
}

}  // namespace

void run_guided(const Target& target, const Budget& budget, const fs::path& source,
                const fs::path& work) {
  static GuidedRun current{target, Inputs(target, source, work), work};
  guided = &current;
  write_seeds(work / "corpus");
  std::vector<std::string> arguments = {
      "palpate_fuzz",
      "-verbosity=0",
      "-use_value_profile=1",
      "-detect_leaks=0",
      fmt::format("-seed={}", budget.seed),
      fmt::format("-timeout={}", kMaxSeconds),
      fmt::format("-rss_limit_mb={}", kMaxMegabytes),
      fmt::format("-max_total_time={:.0f}", std::min(budget.seconds, 1e6)),
      fmt::format("-runs={}", std::min<std::size_t>(budget.runs, 1u << 30)),
      fmt::format("-artifact_prefix={}/", work.string()),
      (work / "corpus").string()};
  std::vector<char*> argv;
  for (auto& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  int argc = static_cast<int>(arguments.size());
  char** begin = argv.data();
  std::atexit(end);
  std::exit(LLVMFuzzerRunDriver(&argc, &begin, try_one));
}

}  // namespace palpate::fuzz

/// Called by libFuzzer for each input that it derives from another.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed) {
  using namespace palpate::fuzz;
  if (max_size <= kSeed) return size;
  if (size < kSeed) std::memset(data + size, 0, kSeed - size);
  palpate::RandomStream random(seed);
  if (guided->target.finish && (guided->target.keep_bytes || random.index(2) == 0)) {
    const std::uint64_t bits = random.bits();
    std::memcpy(data, &bits, kSeed);
    return std::max(size, kSeed);
  }
  const std::size_t length = std::max(size, kSeed) - kSeed;
  return kSeed + change_bytes(data + kSeed, length, max_size - kSeed, random);
}
