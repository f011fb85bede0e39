// SPDX-License-Identifier: Apache-2.0
// Success, stated probability and coverage of the pose posterior, per object and kind of evidence.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "experiment.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/localization/synthetic/grasp_scene.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "processor_time.hpp"

namespace {

using namespace palpate;
using namespace palpate::localization;

constexpr int kBins = 10;
constexpr std::size_t kScenes = 100;  // a cell

/// A column of a table: one kind of scene and what of it the search is told.
struct Cell {
  std::string name;
  bool table = false;
  double false_share = 0;
  SceneEvidenceOptions evidence;
  double scale = 1;  // of the true object, the search believing it is 1
  bool no_normals = false;
  int effort = 1;     // times the usual numbers of proposals, particles and starts
  bool full = false;  // without the fast path
};

/// What became of one search.
struct Outcome {
  double probability = 0;  // that the best mode's pose is right, as stated
  bool success = false;    // it is: within 5 deg and 10 mm modulo symmetry
  bool covered = false;    // the truth is in the smallest set of poses that holds 95 %
  double seconds = 0;      // of the processor
};

Cell cell(const std::string& name, int contacts, bool table, bool hand, bool swept) {
  Cell result;
  result.name = name;
  result.table = table;
  result.evidence.contacts = contacts;
  result.evidence.hand = hand;
  result.evidence.swept = swept;
  return result;
}

std::vector<Cell> main_cells() {
  return {cell("K5 free, none", 5, false, false, false), cell("K5 free", 5, false, true, true),
          cell("K10 free", 10, false, true, true),       cell("K20 free", 20, false, true, true),
          cell("K5 table", 5, true, true, true),         cell("K10 table", 10, true, true, true)};
}

/// An object in a kind of scene.
struct Case {
  std::string object;
  Cell cell;
};

/// Where the search might miss what is there to be found.
std::vector<Case> effort_cases() {
  const Cell k10 = cell("K10 free", 10, false, true, true);
  const Cell k20 = cell("K20 free", 20, false, true, true);
  const Cell table = cell("K5 table", 5, true, true, true);
  return {{"bottle", k10}, {"box", k10}, {"mug", k20}, {"box", table}, {"bracket", table}};
}

std::vector<Cell> ablation_cells() {
  Cell points = cell("points only", 10, false, false, false);
  points.no_normals = true;
  return {points,
          cell("+ normals", 10, false, false, false),
          cell("+ hand", 10, false, true, false),
          cell("+ swept tips", 10, false, true, true),
          cell("table, contacts", 10, true, false, false),
          cell("table + hand + swept", 10, true, true, true)};
}

std::vector<Cell> wrong_cells() {
  auto with = [](const std::string& name, int contacts) {
    return cell(name, contacts, false, true, true);
  };
  Cell lies5 = with("K5, 10 % false", 5), lies10 = with("K10, 10 % false", 10);
  for (Cell* lies : {&lies5, &lies10}) lies->false_share = lies->evidence.false_share = 0.1;
  Cell large = with("K10, mesh 3 % small", 10), offset = with("K10, 2 mm hand offset", 10);
  Cell small = with("K10, mesh 3 % large", 10);
  large.scale = 1.03;
  small.scale = 0.97;
  offset.evidence.hand_offset = 0.002;
  Cell expected = offset;
  expected.name += ", expected";
  expected.evidence.assumed_offset = 0.002;
  Cell sure = with("K10, noise taken as half", 10), unsure = with("K10, noise taken as twice", 10);
  sure.evidence.assumed_noise = 0.5;
  unsure.evidence.assumed_noise = 2;
  Cell twice = with("K10, noise twice as stated", 10);
  twice.evidence.point_noise *= 2;
  twice.evidence.normal_noise *= 2;
  twice.evidence.assumed_noise = 0.5;
  return {lies5, lies10, large, small, offset, expected, sure, unsure, twice};
}

/// An object, and what makes scenes with it.
struct Subject {
  explicit Subject(geometry::KnownObject object)
      : model(std::move(object)), mesh(model.object().mesh) {}
  geometry::ObjectModel model;
  geometry::MeshQuery mesh;
};

geometry::KnownObject scaled(geometry::KnownObject object, double scale) {
  for (auto& vertex : object.mesh.vertices) vertex *= scale;
  for (auto& stable_pose : object.stable_poses) stable_pose.height *= scale;
  return object;
}

struct Bench {
  const experiment::Options& options;
  hand::Description hand;
  std::map<std::string, std::unique_ptr<Subject>> subjects;
  std::map<std::pair<std::string, double>, std::unique_ptr<Subject>> scaled_subjects;
};

Outcome judged(const Posterior& posterior, const Eigen::Isometry3d& truth,
               const geometry::KnownObject& object) {
  Outcome outcome;
  if (posterior.modes.empty()) return outcome;
  const Mode& best = posterior.modes.front();
  const PoseError error = pose_error(best.T_frame_object, truth, object.symmetries);
  outcome.probability = pose_probability(best);
  outcome.success = error.rotation < 5 * kDegree && error.translation < 0.01;
  outcome.covered = truth_in_credible_set(posterior, truth, object.symmetries);
  return outcome;
}

Outcome run_one(const Bench& bench, const Subject& subject, const Subject& believed,
                const Cell& cell, std::uint64_t seed) {
  GraspSceneOptions scene_options;
  scene_options.table = cell.table;
  scene_options.false_share = cell.false_share;
  const RandomStream random(seed, cell.table ? "table" : "free");
  const GraspScene scene =
      make_grasp_scene(subject.model, subject.mesh, bench.hand, scene_options, random);
  Evidence evidence = scene_evidence(scene, cell.evidence, random.fork("evidence"));
  if (cell.no_normals) {
    for (auto& contact : evidence.contacts) contact.normal_sigma = 100;
  }
  LocalizerOptions search;
  search.proposals *= cell.effort;
  search.particles *= cell.effort;
  search.starts *= cell.effort;
  const double start = experiment::processor_seconds();
  const Posterior posterior =
      cell.full ? localize(believed.model, evidence, random.fork("search"), search)
                : localize_fast(believed.model, evidence, random.fork("search"), search);
  const double seconds = experiment::processor_seconds() - start;
  Outcome outcome = judged(posterior, scene.truth, believed.model.object());
  outcome.seconds = seconds;
  return outcome;
}

std::vector<Outcome> run_cell(Bench& bench, const std::string& object, const Cell& cell,
                              std::size_t scenes) {
  const Subject& believed = *bench.subjects.at(object);
  const Subject& true_one =
      cell.scale == 1 ? believed : *bench.scaled_subjects.at({object, cell.scale});
  std::vector<Outcome> outcomes(scenes);
  parallel_for(scenes, bench.options.threads, [&](std::size_t i) {
    outcomes[i] = run_one(bench, true_one, believed, cell, bench.options.seed + i);
  });
  return outcomes;
}

template <class Member>
double mean_of(const std::vector<Outcome>& outcomes, Member member) {
  double sum = 0;
  for (const Outcome& outcome : outcomes) sum += static_cast<double>(outcome.*member);
  return sum / static_cast<double>(outcomes.size());
}

/// Bins of equal numbers of searches by stated probability.
struct Reliability {
  std::vector<double> stated, right;
  double error = 0;  // mean distance of the two: expected calibration error
};
Reliability reliability(std::vector<Outcome> outcomes) {
  std::stable_sort(outcomes.begin(), outcomes.end(), [](const Outcome& a, const Outcome& b) {
    return a.probability < b.probability;
  });
  Reliability result;
  for (int bin = 0; bin < kBins; ++bin) {
    const auto count = static_cast<std::ptrdiff_t>(outcomes.size());
    const std::vector<Outcome> part(outcomes.begin() + count * bin / kBins,
                                    outcomes.begin() + count * (bin + 1) / kBins);
    if (part.empty()) continue;
    result.stated.push_back(mean_of(part, &Outcome::probability));
    result.right.push_back(mean_of(part, &Outcome::success));
    result.error += std::abs(result.stated.back() - result.right.back()) *
                    static_cast<double>(part.size()) / static_cast<double>(outcomes.size());
  }
  return result;
}

/// One table, its raw outcomes added to `pool`.
void publish_table(Bench& bench, const std::vector<Cell>& cells, const std::string& name,
                   const std::string& title, std::vector<Outcome>& pool) {
  const std::size_t scenes = bench.options.quick ? 1 : kScenes;
  std::vector<std::string> columns{"object"};
  for (const Cell& cell : cells) columns.push_back(cell.name);
  experiment::Table table(columns);
  std::map<std::string, std::vector<Outcome>> by_cell;
  for (const auto& [object, subject] : bench.subjects) {
    std::vector<std::string> row{object};
    for (const Cell& cell : cells) {
      const auto outcomes = run_cell(bench, object, cell, scenes);
      row.push_back(fmt::format("{:.2f}/{:.2f}/{:.2f}", mean_of(outcomes, &Outcome::success),
                                mean_of(outcomes, &Outcome::probability),
                                mean_of(outcomes, &Outcome::covered)));
      by_cell[cell.name].insert(by_cell[cell.name].end(), outcomes.begin(), outcomes.end());
      fmt::print(stderr, "{} {}: {}\n", object, cell.name, row.back());
    }
    table.add_row(row);
  }
  std::vector<std::string> calibration{"calibration error"}, milliseconds{"median ms"};
  for (const Cell& cell : cells) {
    const auto& outcomes = by_cell[cell.name];
    pool.insert(pool.end(), outcomes.begin(), outcomes.end());
    calibration.push_back(fmt::format("{:.3f}", reliability(outcomes).error));
    std::vector<double> seconds;
    for (const Outcome& outcome : outcomes) seconds.push_back(outcome.seconds);
    milliseconds.push_back(fmt::format("{:.0f}", 1e3 * median(seconds)));
  }
  table.add_row(calibration);
  table.add_row(milliseconds);
  table.publish(bench.options, name, title);
}

void publish_calibration(const Bench& bench, const std::vector<Outcome>& pool) {
  const Reliability bins = reliability(pool);
  experiment::Table table({"stated", "right"});
  for (std::size_t i = 0; i < bins.stated.size(); ++i) {
    table.add_row({fmt::format("{:.3f}", bins.stated[i]), fmt::format("{:.3f}", bins.right[i])});
  }
  std::vector<Outcome> sure;
  for (const Outcome& outcome : pool) {
    if (outcome.probability > 0.95) sure.push_back(outcome);
  }
  table.publish(
      bench.options, "calibration",
      fmt::format("{} searches: expected calibration error {:.3f}; right where stated "
                  "above .95: {:.3f} of {}; truth in the 95 % set: {:.3f}",
                  pool.size(), bins.error, sure.empty() ? 1.0 : mean_of(sure, &Outcome::success),
                  sure.size(), mean_of(pool, &Outcome::covered)));
  plotting::Plot plot;
  plot.title = "Stated probability and share right";
  plot.x = {"stated probability of the best pose", false, 0.0, 1.0};
  plot.y = {"share within 5 deg and 10 mm", false, 0.0, 1.0};
  plot.series = {plotting::LineSeries{"perfect", {0, 1}, {0, 1}},
                 plotting::LineSeries{"measured", bins.stated, bins.right},
                 plotting::ScatterSeries{"", bins.stated, bins.right}};
  plot.width = plot.height = 440;
  experiment::publish_figure(bench.options, "calibration", plotting::to_svg(plot));
}

/// The usual search and one of ten times the proposals, particles and starts on the same scenes.
void publish_effort(Bench& bench) {
  const std::size_t scenes = bench.options.quick ? 1 : kScenes;
  experiment::Table table({"object", "scenes", "usual", "ten times", "difference"});
  for (Case one : effort_cases()) {
    if (!bench.subjects.contains(one.object)) continue;
    const auto usual = run_cell(bench, one.object, one.cell, scenes);
    one.cell.effort = 10;
    const auto more = run_cell(bench, one.object, one.cell, scenes);
    double gain = 0, squares = 0;
    for (std::size_t i = 0; i < scenes; ++i) {
      const double d = static_cast<double>(more[i].success) - static_cast<double>(usual[i].success);
      gain += d / static_cast<double>(scenes);
      squares += d * d / static_cast<double>(scenes);
    }
    const double error = std::sqrt((squares - gain * gain) / static_cast<double>(scenes));
    const auto entry = [](const std::vector<Outcome>& outcomes) {
      return fmt::format("{:.2f}/{:.2f}", mean_of(outcomes, &Outcome::success),
                         mean_of(outcomes, &Outcome::probability));
    };
    table.add_row({one.object, one.cell.name, entry(usual), entry(more),
                   fmt::format("{:+.2f} +- {:.2f}", gain, error)});
    fmt::print(stderr, "{} {}: {} and {}\n", one.object, one.cell.name, entry(usual), entry(more));
  }
  table.publish(bench.options, "effort", "success / stated with ten times the search");
}

/// Processor time of the full search.
void publish_time(Bench& bench) {
  const std::size_t scenes = bench.options.quick ? 1 : 40;
  experiment::Table table({"scenes", "object", "median ms", "90 %", "most"});
  for (Cell one : main_cells()) {
    one.full = true;
    for (const auto& [object, subject] : bench.subjects) {
      std::vector<double> ms;
      for (const Outcome& outcome : run_cell(bench, object, one, scenes)) {
        ms.push_back(1e3 * outcome.seconds);
      }
      table.add_row({one.name, object, fmt::format("{:.0f}", median(ms)),
                     fmt::format("{:.0f}", quantile(ms, 0.9)),
                     fmt::format("{:.0f}", *std::max_element(ms.begin(), ms.end()))});
    }
  }
  table.publish(bench.options, "time", "processor time of the full search");
}

void publish_success(Bench& bench) {
  const std::vector<int> counts =
      bench.options.quick ? std::vector<int>{5} : std::vector<int>{3, 5, 7, 10, 14, 20};
  plotting::Plot plot;
  plot.title = "Success from several grasps, nothing known of the pose before";
  plot.x = {"contacts", false, 0.0, 20.0};
  plot.y = {"share within 5 deg and 10 mm", false, 0.0, 1.0};
  for (const auto& [object, subject] : bench.subjects) {
    plotting::LineSeries line{object, {}, {}};
    for (int count : counts) {
      const auto outcomes =
          run_cell(bench, object, cell("", count, false, true, true), bench.options.quick ? 1 : 50);
      line.x.push_back(count);
      line.y.push_back(mean_of(outcomes, &Outcome::success));
    }
    plot.series.push_back(line);
  }
  experiment::publish_figure(bench.options, "success", plotting::to_svg(plot));
}

void tables(const experiment::Options& options) {
  Bench bench{options, simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml")), {}, {}};
  const std::vector<std::string> objects =
      options.quick ? std::vector<std::string>{"box"} : geometry::built_in_objects();
  for (const auto& name : objects) {
    bench.subjects[name] = std::make_unique<Subject>(geometry::load_known_object(name));
    for (const double scale : {1.03, 0.97}) {
      bench.scaled_subjects[{name, scale}] =
          std::make_unique<Subject>(scaled(bench.subjects[name]->model.object(), scale));
    }
  }
  std::vector<Outcome> pool, others;
  publish_table(bench, main_cells(), "main",
                "success / mean stated probability / truth in the 95 % set", pool);
  publish_calibration(bench, pool);
  publish_table(bench, wrong_cells(), "wrong", "false contacts and wrong assumptions", others);
  publish_table(bench, ablation_cells(), "ablation", "each kind of evidence, 10 contacts", others);
  publish_time(bench);
  publish_effort(bench);
  publish_success(bench);
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "localization_tables",
                         "Success, stated probability and coverage of the pose posterior by object "
                         "and kind of evidence",
                         tables);
}
