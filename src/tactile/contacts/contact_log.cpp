// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/contacts/contact_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/plausible.hpp"

namespace palpate::tactile {
namespace {

constexpr std::size_t kMaxName = 200;  // bytes; a file system takes 255, with what is appended
constexpr double kDefaultTick = 0.1;   // s
constexpr std::size_t kMaxLogs = 1000, kMaxAtOnce = 10000;  // fingers; contacts of one at a time

using Columns = palpate::CsvTable::Columns;

Eigen::Vector3d vector_of(const palpate::CsvTable& table, const Columns& columns) {
  return {table.number(columns[0]), table.number(columns[1]), table.number(columns[2])};
}

/// Where a log of contacts has its values.
struct Layout {
  explicit Layout(const palpate::CsvTable& table)
      : finger(table.require("finger")),
        t(table.require("t")),
        p(table.require_xyz(table.find("px") ? "p" : "")),
        f(table.require_xyz("f")) {
    if (table.find("nx")) n = table.require_xyz("n");
    if (table.find("tnx")) tip = table.require_xyz("tn");
  }
  std::size_t finger, t;
  Columns p, f;
  std::optional<Columns> n, tip;
};

/// Of ASCII; the bytes of UTF-8 are none.
bool is_control(char byte) {
  const auto code = static_cast<unsigned char>(byte);
  return code < 0x20 || code == 0x7F;
}

FingerLog& log_of(std::vector<FingerLog>& logs, const palpate::CsvTable& table,
                  const Layout& layout) {
  const std::string_view finger = table.cell(layout.finger);
  const auto found = std::find_if(logs.begin(), logs.end(),
                                  [&](const FingerLog& log) { return log.finger == finger; });
  if (found != logs.end()) return *found;
  check_finger_name(finger, table.where());
  if (logs.size() == kMaxLogs) {
    throw BadInput(
        fmt::format("{}: '{}' is one finger more than {}", table.where(), finger, kMaxLogs));
  }
  return logs.emplace_back(FingerLog{.finger = std::string(finger), .frames = {}, .normals = {}});
}

/// None where there is no column, or the row has zeros or what is not finite.
std::optional<Eigen::Vector3d> tip_normal(const palpate::CsvTable& table, const Layout& layout) {
  if (!layout.tip) return std::nullopt;
  const Eigen::Vector3d n = vector_of(table, *layout.tip);
  if (!n.allFinite() || n.norm() < 1e-6) return std::nullopt;
  return n.normalized();
}

void add_row(const palpate::CsvTable& table, const Layout& layout, FingerLog& log) {
  const double time = table.number(layout.t);
  const Eigen::Vector3d p = vector_of(table, layout.p), f = vector_of(table, layout.f);
  // What is missing is for the estimators to flag; what cannot be is not believed.
  check_plausible(p, kMaxLength, table.where() + ": a coordinate", true);
  check_plausible(f, kMaxForce, table.where() + ": a force", true);
  const bool same_frame = !log.frames.empty() && log.frames.back().time == time;
  if (!same_frame) {
    log.frames.push_back({.time = time, .contacts = {}});
    log.normals.emplace_back();
  }
  auto& contacts = log.frames.back().contacts;
  const bool twice = std::ranges::any_of(
      contacts, [&](const FingerContact& other) { return other.p == p && other.f == f; });
  if (twice) return;
  if (contacts.size() == kMaxAtOnce) {
    throw BadInput(fmt::format("{}: more than {} contacts of {} at the time {}", table.where(),
                               kMaxAtOnce, log.finger, time));
  }
  contacts.push_back({.p = p, .f = f, .tip_normal = tip_normal(table, layout)});
  if (!layout.n) return;
  const Eigen::Vector3d n = vector_of(table, *layout.n);
  auto& normal = log.normals.back();
  if (n.norm() > 1e-6) normal = normal.value_or(Eigen::Vector3d::Zero()) + n.normalized();
}

/// Whether all times are whole, those aside that are not finite.
bool counts_ticks(const std::vector<FingerLog>& logs) {
  bool whole = true;
  for (const FingerLog& log : logs) {
    for (const FingerFrame& frame : log.frames) {
      whole = whole && (!std::isfinite(frame.time) || frame.time == std::floor(frame.time));
    }
  }
  return whole;
}

void add_steps(const std::vector<FingerFrame>& frames, std::vector<double>& steps) {
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double step = frames[i].time - frames[i - 1].time;
    if (step > 0) steps.push_back(step);
  }
}

/// Median; none of nothing.
std::optional<double> median_of(std::vector<double> steps) {
  if (steps.empty()) return std::nullopt;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// Seconds in 1 of t. @throws BadInput where t may be in another unit
double unit_of_time(const std::vector<FingerLog>& logs, const std::optional<double>& tick,
                    const std::string& source) {
  if (!counts_ticks(logs)) {
    if (!tick) return 1;
    throw BadInput(fmt::format(
        "{}: t has fractions and so is in seconds: a tick of {} s (--tick) has no effect", source,
        *tick));
  }
  if (tick) return *tick;
  std::vector<double> steps;
  for (const FingerLog& log : logs) add_steps(log.frames, steps);
  const double step = median_of(std::move(steps)).value_or(1);
  if (step == 1) return kDefaultTick;
  throw BadInput(
      fmt::format("{}: t is whole, which counts ticks, but most often goes on by {}: is it in ms "
                  "or ns? Give seconds, or the length of a tick (--tick)",
                  source, step));
}

void finish(FingerLog& log, double unit, const std::string& source) {
  for (FingerFrame& frame : log.frames) {
    frame.time *= unit;
    if (std::isnan(frame.time)) continue;  // flagged later
    plausible(frame.time, -kMaxTime, kMaxTime, source + ": a time, in s,");
  }
  std::vector<double> steps;
  add_steps(log.frames, steps);
  log.period = median_of(std::move(steps)).value_or(hand::kTick);
  for (auto& n : log.normals) {
    if (n && n->norm() > 1e-6) {
      n->normalize();
    } else {
      n.reset();
    }
  }
}

}  // namespace

void check_finger_name(std::string_view name, const std::string& source) {
  if (name.empty()) throw BadInput(fmt::format("{}: a finger has no name", source));
  if (name.size() > kMaxName) {
    throw BadInput(fmt::format("{}: a finger's name has {} bytes, more than {}", source,
                               name.size(), kMaxName));
  }
  std::string shown(name);
  std::ranges::replace_if(shown, is_control, '?');
  if (shown == name && name.front() != '.' && name.find_first_of("/,") == name.npos) return;
  throw BadInput(
      fmt::format("{}: '{}' cannot be a finger's name, which begins with no dot and holds no "
                  "slash, comma or control character",
                  source, shown));
}

std::vector<FingerLog> read_contact_log(const std::filesystem::path& path,
                                        std::optional<double> tick) {
  if (tick && !(std::isfinite(*tick) && *tick > 0)) {
    throw BadInput(fmt::format("the tick must be positive, not {} s", *tick));
  }
  const std::string text = read_file(path);
  palpate::CsvTable table(text, path.string());
  const Layout layout(table);
  std::vector<FingerLog> logs;
  while (table.next()) add_row(table, layout, log_of(logs, table, layout));
  if (logs.empty()) throw BadInput(fmt::format("{} has no rows", path.string()));
  const double unit = unit_of_time(logs, tick, path.string());
  for (FingerLog& log : logs) finish(log, unit, path.string());
  return logs;
}

}  // namespace palpate::tactile
