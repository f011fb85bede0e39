// SPDX-License-Identifier: Apache-2.0
#include "inputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "mutate.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFewRuns = 100;  // of which none may be accepted

}  // namespace

Inputs::Inputs(const Target& target, const fs::path& source, const fs::path& work)
    : keep_bytes_(target.keep_bytes) {
  const fs::path corpus = source / "corpus" / target.name;
  std::vector<fs::path> paths;
  if (fs::exists(corpus)) {
    for (const auto& entry : fs::directory_iterator(corpus)) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  for (const auto& path : paths) seeds_.push_back(read_file(path));
  if (target.sample) seeds_.push_back(target.sample(work));
  if (!target.grammar.empty()) grammar_.emplace(source / "grammars" / (target.grammar + ".txt"));
}

std::string Inputs::next(RandomStream& random) {
  if (count_ < seeds_.size()) return seeds_[count_++];
  const bool write = grammar_ && (seeds_.empty() || random.index(2) == 0);
  std::string input = write ? grammar_->sentence(random) : seeds_[random.index(seeds_.size())];
  if (keep_bytes_) return input;
  return random.index(3) > 0 ? mutated(std::move(input), random) : input;
}

std::string Inputs::changed(std::string bytes, RandomStream& random) const {
  if (keep_bytes_) return bytes;
  if (grammar_ && random.index(4) == 0) return grammar_->sentence(random);
  return mutated(std::move(bytes), random);
}

bool try_input(const Target& target, std::string_view input, const fs::path& folder,
               RandomStream& random) {
  const fs::path file = folder / target.file;  // what is left there after a crash caused it
  std::ofstream(file, std::ios::binary) << input;
  if (target.finish) target.finish(file, random);
  try {
    target.load(file);
    return true;
  } catch (const BadInput& error) {
    if (std::string_view(error.what()).find('\n') != std::string_view::npos) {
      throw std::logic_error(fmt::format("a message of several lines: {}", error.what()));
    }
    return false;
  }
}

bool report(const Target& target, std::size_t runs, std::size_t accepted) {
  fmt::print("{:<11} {:>9} inputs, {:>8} accepted\n", target.name, runs, accepted);
  std::fflush(stdout);
  if (accepted > 0 || runs < kFewRuns) return true;
  fmt::print(stderr, "{}: not even the inputs that are whole were accepted\n", target.name);
  return false;
}

}  // namespace palpate::fuzz
