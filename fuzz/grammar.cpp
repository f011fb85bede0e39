// SPDX-License-Identifier: Apache-2.0
#include "grammar.hpp"

#include <fmt/format.h>

#include <array>

#include "palpate/core/csv.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::fuzz {
namespace {

constexpr int kMaxDepth = 60;
constexpr std::size_t kMaxSize = 1 << 17;

constexpr std::array<std::string_view, 22> kIntegers = {"-1",
                                                        "127",
                                                        "128",
                                                        "255",
                                                        "256",
                                                        "32767",
                                                        "65535",
                                                        "65536",
                                                        "1000000",
                                                        "2147483647",
                                                        "2147483648",
                                                        "4294967295",
                                                        "4294967296",
                                                        "4611686018427387904",
                                                        "9223372036854775807",
                                                        "9223372036854775798",
                                                        "9223372036854775808",
                                                        "18446744073709551615",
                                                        "-9223372036854775808",
                                                        "99999999999999999999",
                                                        "0x10",
                                                        "1e3"};
constexpr std::array<std::string_view, 14> kReals = {"nan",    "-nan",  "inf",   "-inf",   "1e200",
                                                     "-1e200", "1e308", "1e309", "1e-320", "-0.0",
                                                     "0.1.2",  "1e",    "+1",    "1,5"};

template <class Array>
std::string any_of(const Array& values, RandomStream& random) {
  return std::string(values[random.index(values.size())]);
}

char unescaped(std::string_view& rest) {
  const char kind = rest.front();
  rest.remove_prefix(1);
  if (kind == 'n') return '\n';
  if (kind == 't') return '\t';
  if (kind != 'x') return kind;
  const int byte = std::stoi(std::string(rest.substr(0, 2)), nullptr, 16);
  rest.remove_prefix(2);
  return static_cast<char>(byte);
}

}  // namespace

std::string hostile_integer(RandomStream& random) {
  return random.index(4) > 0 ? std::to_string(random.index(6)) : any_of(kIntegers, random);
}

std::string hostile_real(RandomStream& random) {
  if (random.index(6) == 0) return any_of(kReals, random);
  return random.index(3) == 0 ? hostile_integer(random)
                              : fmt::format("{:.4g}", 0.1 * random.normal());
}

Grammar::Grammar(const std::filesystem::path& path) {
  const std::string text = read_file(path);
  for (std::size_t at = 0; at < text.size();) {
    const auto end = std::min(text.find('\n', at), text.size());
    const std::string_view line = trimmed(std::string_view(text).substr(at, end - at));
    at = end + 1;
    if (line.empty() || line.starts_with('#')) continue;
    const auto equals = line.find('=');
    if (equals == std::string_view::npos) {
      throw BadInput(fmt::format("{}: '{}' is no rule", path.string(), line));
    }
    const std::string name(trimmed(line.substr(0, equals)));
    if (start_.empty()) start_ = name;
    std::string_view rest = line.substr(equals + 1);
    while (true) {
      const auto bar = rest.find("||");
      rules_[name].emplace_back(trimmed(rest.substr(0, bar)));
      if (bar == std::string_view::npos) break;
      rest.remove_prefix(bar + 2);
    }
  }
}

std::string Grammar::sentence(RandomStream& random) const {
  std::string out;
  expand("<" + start_ + ">", 0, random, out);
  return out;
}

bool Grammar::expand_built_in(std::string_view name, RandomStream& random, std::string& out) const {
  if (name == "int") {
    out += hostile_integer(random);
  } else if (name == "real") {
    out += hostile_real(random);
  } else if (name == "word") {
    for (std::size_t i = random.index(9); i > 0; --i)
      out += static_cast<char>('a' + random.index(26));
  } else if (name == "bytes") {
    for (std::size_t i = random.index(64); i > 0; --i) out += static_cast<char>(random.index(256));
  } else {
    return false;
  }
  return true;
}

void Grammar::expand(std::string_view text, int depth, RandomStream& random,
                     std::string& out) const {
  while (!text.empty() && out.size() < kMaxSize) {
    const char c = text.front();
    text.remove_prefix(1);
    if (c == '\\') {
      out += unescaped(text);
    } else if (c != '<') {
      out += c;
    } else {
      const auto end = text.find('>');
      const std::string_view name = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      if (expand_built_in(name, random, out)) continue;
      const auto rule = rules_.find(name);
      if (rule == rules_.end()) throw BadInput(fmt::format("no rule <{}>", name));
      const auto& alternatives = rule->second;
      const std::size_t choice = depth > kMaxDepth ? 0 : random.index(alternatives.size());
      expand(alternatives[choice], depth + 1, random, out);
    }
  }
}

}  // namespace palpate::fuzz
