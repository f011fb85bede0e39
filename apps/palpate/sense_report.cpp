// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "given_command.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/plotting/plot.hpp"
#include "sense.hpp"
#include "terminal.hpp"
#include "units_hint.hpp"

namespace palpate::app {
namespace {

constexpr double kChiSquared95 = 5.991;  // of the two tangent axes
constexpr double kWidest = 3;            // m, that a hand reaches
constexpr const char* kContacts = "contacts.csv";
constexpr const char* kNormalFigure = "-normal.svg";  // after the stream's name
constexpr const char* kForceFigure = "-force.svg";

struct StreamSummary {
  std::size_t samples = 0, flagged = 0;
  std::map<std::string, std::size_t> flags;
  std::vector<double> errors, forces;
  std::vector<double> normalized;  // squared errors by their variance: 2 in the mean, where honest
};

StreamSummary summarize(const SensedStream& stream) {
  StreamSummary summary;
  summary.samples = stream.samples.size();
  for (const SensedSample& sample : stream.samples) {
    if (!sample.flags.empty()) {
      ++summary.flagged;
      ++summary.flags[sample.flags];
    }
    if (std::isfinite(sample.error_deg)) summary.errors.push_back(sample.error_deg);
    const double ratio = sample.error_deg / sample.sigma_deg;
    if (std::isfinite(ratio)) summary.normalized.push_back(ratio * ratio);
    if (sample.force.allFinite()) summary.forces.push_back(sample.force.norm());
  }
  return summary;
}

nlohmann::json stream_json(const StreamSummary& summary) {
  nlohmann::json stream = {{"samples", summary.samples}, {"flagged", summary.flagged}};
  stream["flags"] = summary.flags;
  if (!summary.forces.empty()) stream["force_n"] = {{"median", median(summary.forces)}};
  if (!summary.errors.empty()) {
    stream["error_deg"] = {{"median", median(summary.errors)},
                           {"p90", quantile(summary.errors, 0.9)},
                           {"p95", quantile(summary.errors, 0.95)}};
  }
  stream["normalized_error_squared"] = nullptr;
  stream["coverage_95"] = nullptr;
  if (!summary.normalized.empty()) {
    stream["normalized_error_squared"] = mean(summary.normalized);
    const auto within = std::count_if(summary.normalized.begin(), summary.normalized.end(),
                                      [](double square) { return square < kChiSquared95; });
    stream["coverage_95"] =
        static_cast<double>(within) / static_cast<double>(summary.normalized.size());
  }
  return stream;
}

std::string row(const std::string& name, const StreamSummary& summary) {
  const std::string force =
      summary.forces.empty() ? "-" : fmt::format("{:.2f}", median(summary.forces));
  std::string error = fmt::format("{:>10}{:>8}{:>8}", "-", "-", "-");
  if (!summary.errors.empty()) {
    error = fmt::format("{:>10.2f}{:>8.2f}{:>8.2f}", median(summary.errors),
                        quantile(summary.errors, 0.9), quantile(summary.errors, 0.95));
  }
  std::string flags;
  for (const auto& [flag, count] : summary.flags) flags += fmt::format("  {} {}", flag, count);
  return fmt::format("{:<16}{:>9}{:>9}{:>10}{}{}", name, summary.samples, summary.flagged, force,
                     error, flags);
}

std::string series_csv(const SensedStream& stream) {
  std::string text = "t,x,y,z,fx,fy,fz,nx,ny,nz,sigma_deg,error_deg,flags\n";
  for (const SensedSample& s : stream.samples) {
    text += fmt::format("{}", s.time);
    for (const auto* v : {&s.point, &s.force, &s.normal}) {
      text += fmt::format(",{:.9g},{:.9g},{:.9g}", v->x(), v->y(), v->z());
    }
    text += fmt::format(",{:.6g},{:.6g},{}\n", s.sigma_deg, s.error_deg, s.flags);
  }
  return text;
}

/// What is known of a normal's error, rad; empty where nothing is.
std::string normal_sigma_cell(const SensedSample& sample) {
  if (!std::isfinite(sample.sigma_deg)) return "";
  return fmt::format("{:.6g}", sample.sigma_deg * kDegree);
}

/// The contacts with a normal of all streams, as `palpate localize` reads them; empty if there are
/// none, or not all of one object at rest.
std::string contacts_csv(const std::vector<SensedStream>& streams) {
  std::string text;
  for (const SensedStream& stream : streams) {
    if (!stream.resting) return "";
    for (const SensedSample& s : stream.samples) {
      if (!(s.point.allFinite() && s.normal.allFinite())) continue;
      if (text.empty()) text = "finger,t,x,y,z,nx,ny,nz,normal_sigma,fx,fy,fz\n";
      const Eigen::Vector3d f = s.force.allFinite() ? s.force : Eigen::Vector3d::Zero();
      text += fmt::format("{},{}", stream.name, s.time);
      for (const auto* v : {&s.point, &s.normal}) {
        text += fmt::format(",{:.9g},{:.9g},{:.9g}", v->x(), v->y(), v->z());
      }
      text += fmt::format(",{},{:.9g},{:.9g},{:.9g}\n", normal_sigma_cell(s), f.x(), f.y(), f.z());
    }
  }
  return text;
}

std::string why_no_contacts(const std::vector<SensedStream>& streams) {
  return std::ranges::all_of(streams, &SensedStream::resting)
             ? "no contacts.csv: no sample has a point and a normal\n"
             : "no contacts.csv: in a recording the object moves; palpate replay finds its pose\n";
}

std::string hint_at_units(const std::vector<SensedStream>& streams) {
  std::vector<Eigen::Vector3d> points;
  for (const SensedStream& stream : streams) {
    for (const SensedSample& sample : stream.samples) {
      if (sample.point.allFinite()) points.push_back(sample.point);
    }
  }
  const double extent = extent_of(points);
  if (extent <= kWidest) return "";
  return fmt::format("the points spread over {:.3g} m; are they in millimetres?", extent);
}

/// Figure of a vector's components over time; none if it is never known.
std::string figure(const SensedStream& stream, const Eigen::Vector3d SensedSample::*vector,
                   const std::string& what, const std::string& label) {
  plotting::Plot plot;
  plot.title = stream.name + ": " + what;
  plot.x.label = "time (s)";
  plot.y.label = label;
  bool known = false;
  for (int axis = 0; axis < 3; ++axis) {
    plotting::LineSeries line{.name = std::string(1, "xyz"[axis]), .x = {}, .y = {}};
    for (const SensedSample& sample : stream.samples) {
      line.x.push_back(sample.time);
      line.y.push_back((sample.*vector)[axis]);
      known = known || std::isfinite(line.y.back());
    }
    plot.series.emplace_back(std::move(line));
  }
  return known ? plotting::to_svg(plot) : "";
}

/// The files of a stream.
std::vector<std::string> file_names(const std::string& stream) {
  return {stream + ".csv", stream + kNormalFigure, stream + kForceFigure};
}

/// The files of the streams of an earlier run, as its report in the folder lists them.
std::vector<std::string> earlier_files(const std::filesystem::path& folder) {
  const auto path = folder / "report.json";
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return {};
  const auto report = nlohmann::json::parse(read_file(path), nullptr, false);
  std::vector<std::string> names;
  const auto streams = report.is_object() ? report.find("streams") : report.end();
  if (streams == report.end() || !streams->is_object()) return names;
  for (const auto& [stream, _] : streams->items()) {
    if (std::filesystem::path(stream).filename() != stream) continue;
    for (auto& name : file_names(stream)) names.push_back(std::move(name));
  }
  return names;
}

/// All that may be written of the streams. @throws BadInput where two of it have one name
std::vector<std::string> result_names(const std::vector<SensedStream>& streams) {
  std::vector<std::string> names = {"report.json", kContacts};
  for (const SensedStream& stream : streams) {
    const auto files = file_names(stream.name);
    if (std::ranges::find(names, files.front()) != names.end()) {
      throw BadInput(
          fmt::format("the series of finger '{}' cannot be written: --out has another {}",
                      stream.name, files.front()));
    }
    names.insert(names.end(), files.begin(), files.end());
  }
  return names;
}

std::vector<std::string> write_stream(const std::filesystem::path& folder,
                                      const SensedStream& stream) {
  std::vector<std::string> written = {stream.name + ".csv"};
  write_file_atomically(folder / written.back(), series_csv(stream));
  const auto draw = [&](const char* name, const std::string& svg) {
    if (svg.empty()) return;
    written.push_back(stream.name + name);
    write_file_atomically(folder / written.back(), svg);
  };
  draw(kNormalFigure,
       figure(stream, &SensedSample::normal, "outward normal of the object", "component"));
  draw(kForceFigure, figure(stream, &SensedSample::force, "force on the object", "force (N)"));
  return written;
}

/// @param contacts  the text of contacts.csv; empty: not to be written
/// @return what was written, for a person
std::string write_sensed(const SenseArguments& arguments, const std::vector<SensedStream>& streams,
                         const std::string& contacts, const nlohmann::json& report) {
  const std::filesystem::path folder = arguments.common.out;
  auto names = result_names(streams);
  if (arguments.common.force) {
    for (auto& name : earlier_files(folder)) names.push_back(std::move(name));
  }
  const auto output = claim_output(arguments.common, names);
  std::string wrote = contacts.empty() ? "" : fmt::format(" {}", kContacts);
  for (const SensedStream& stream : streams) {
    for (const auto& file : write_stream(folder, stream)) wrote += " " + file;
  }
  if (!contacts.empty()) write_file_atomically(folder / kContacts, contacts);
  write_file_atomically(folder / "report.json", json_text(report));
  wrote = fmt::format("wrote {}: report.json{}\n", folder.string(), wrote);
  return contacts.empty() ? wrote + why_no_contacts(streams) : wrote;
}

}  // namespace

void report_streams(const SenseArguments& arguments, const CLI::App& command,
                    const std::vector<SensedStream>& streams) {
  nlohmann::json report = {{"streams", nlohmann::json::object()}};
  std::string table =
      fmt::format("{:<16}{:>9}{:>9}{:>10}{:>10}{:>8}{:>8}  {}\n", "stream", "samples", "flagged",
                  "force N", "error deg", "p90", "p95", "flags");
  for (const SensedStream& stream : streams) {
    const StreamSummary summary = summarize(stream);
    report["streams"][stream.name] = stream_json(summary);
    table += row(stream.name, summary) + "\n";
  }
  const std::string contacts = contacts_csv(streams);
  const std::string hint = streams.empty() ? "no finger touches anything in " + arguments.recording
                                           : hint_at_units(streams);
  report["hint"] = hint;
  if (!hint.empty()) table += hint + "\n";
  if (!arguments.common.out.empty()) table += write_sensed(arguments, streams, contacts, report);
  if (arguments.common.json) {
    print_json(report);
    return;
  }
  fmt::print("{}", table);
  if (contacts.empty()) return;
  print_next(
      arguments.common,
      arguments.common.out.empty()
          ? given_command(command) + " --out out/sense writes contacts.csv for palpate localize"
          : "palpate localize MESH " + quoted(arguments.common.out + "/contacts.csv"));
}

}  // namespace palpate::app
