// SPDX-License-Identifier: Apache-2.0
// What it costs to localize the held object on contacts inferred from BioTac channels.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "evaluation/evaluator.hpp"
#include "experiment.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/tactile/biotac/contact_hand.hpp"

namespace {

using namespace palpate;
using namespace palpate::experiment;

using Inverse = std::shared_ptr<const tactile::BiotacInverse>;

constexpr double kDegrees = 180 / std::numbers::pi;

/// What became of the same pick, located twice.
struct Outcome {
  bool lifted = false;
  evaluation::TrialMetrics solver, biotac;
};

/// Errors of lasting contacts against the object's true surface.
struct ContactErrors {
  std::vector<double> points_mm, normals_deg;
};

struct Result {
  Outcome outcome;
  ContactErrors solver, biotac;
};

/// The shipped inverse, or (for a quick run) one trained for a moment.
Inverse inverse_of(const Options& options) {
  if (!options.quick) return tactile::shipped_biotac_inverse();
  tactile::BiotacDatasetOptions data;
  data.trajectories = 20;
  data.seconds = 1;
  return std::make_shared<const tactile::BiotacInverse>(
      tactile::BiotacInverse::train(tactile::simulate_biotac(data)));
}

/// Whether the estimate may look at a reading: it lies within the longest window before a moment.
bool is_used(const estimation::EventLog& log, std::size_t reading) {
  const auto window =
      static_cast<std::size_t>(estimation::EstimationOptions{}.window / hand::kTick) + 1;
  return std::any_of(log.moments.begin(), log.moments.end(), [&](const auto& moment) {
    return reading <= moment.reading && moment.reading < reading + window;
  });
}

/// The log with its contacts replaced by those inferred from the channels.
estimation::EventLog inferred(estimation::EventLog log, const hand::Description& hand,
                              const Inverse& inverse) {
  tactile::BiotacFingers fingers(hand, inverse);
  for (std::size_t i = 0; i < log.readings.size(); ++i) {
    auto& reading = log.readings[i];
    if (is_used(log, i)) {
      fingers.infer_contacts(reading);
    } else {
      fingers.follow(reading);
      for (auto& contacts : reading.contacts) contacts.clear();
    }
  }
  return log;
}

void add_errors(const estimation::HeldPoseEstimate& estimate, const geometry::MeshQuery& mesh,
                const Eigen::Isometry3d& T_world_object, ContactErrors& errors) {
  for (const auto& contact : estimate.contacts) {
    const auto closest = mesh.closest_point(T_world_object.inverse() * contact.p);
    errors.points_mm.push_back(1e3 * closest.distance);
    const Eigen::Vector3d n = T_world_object.linear().transpose() * contact.n;
    errors.normals_deg.push_back(kDegrees *
                                 std::atan2(n.cross(closest.normal).norm(), n.dot(closest.normal)));
  }
}

/// A pick on the solver's contacts, and its pose once more on the contacts that the same pick's
/// channels show.
Result pick_and_locate_twice(const geometry::ObjectModel& object, const Inverse& inverse,
                             std::uint64_t seed) {
  evaluation::TrialOptions options;
  options.world.biotacs = true;
  simulation::World world(object.object(), options.world, seed);
  world.reset(evaluation::draw_start(object.object(), options.start, seed),
              evaluation::waiting_command(world.hand_model()));
  evaluation::Evaluator evaluator(world);
  skills::Executor robot(world.hand(), world.hand_model(),
                         evaluation::waiting_command(world.hand_model()),
                         {[&](const auto& reading, const auto&) { evaluator.observe(reading); },
                          [](estimation::TouchEvent) {},
                          {}});
  const auto picked = skills::pick(robot, object, options.pick, seed);
  const auto& symmetries = object.object().symmetries;
  Result result;
  result.outcome.solver = evaluator.metrics(picked, robot.log(), options.pick.lift, symmetries);
  result.outcome.lifted = result.outcome.solver.lifted;
  if (!result.outcome.lifted) return result;
  options.touch.source = "biotac";
  auto again = picked;
  again.estimate = estimation::PoseEstimator(object, options.pick_options().estimation, seed)
                       .held(robot.model(), inferred(robot.log(), robot.model(), inverse),
                             robot.log().at(estimation::TouchEvent::held));
  result.outcome.biotac = evaluator.metrics(again, robot.log(), options.pick.lift, symmetries);
  const geometry::MeshQuery mesh(object.object().mesh);
  const auto T_world_object = world.truth().T_world_object;
  add_errors(picked.estimate, mesh, T_world_object, result.solver);
  add_errors(again.estimate, mesh, T_world_object, result.biotac);
  return result;
}

/// Counts of what was right.
struct Tally {
  std::size_t lifted = 0, ok = 0, in_modes = 0;

  void add(const evaluation::TrialMetrics& metrics) {
    ++lifted;
    ok += metrics.pose_ok;
    in_modes += metrics.covered;
  }
  void add(const Tally& other) {
    lifted += other.lifted;
    ok += other.ok;
    in_modes += other.in_modes;
  }
};

std::string rate(std::size_t count, std::size_t of) {
  if (of == 0) return "-";
  const auto interval = wilson_interval(count, of);
  return fmt::format("{:.2f} [{:.2f}, {:.2f}]",
                     static_cast<double>(count) / static_cast<double>(of), interval.low,
                     interval.high);
}

void add_row(Table& table, const std::string& name, std::size_t trials, const Tally& solver,
             const Tally& biotac) {
  table.add_row({name, fmt::format("{}", trials), fmt::format("{}", solver.lifted),
                 rate(solver.in_modes, solver.lifted), rate(biotac.in_modes, biotac.lifted),
                 rate(solver.ok, solver.lifted), rate(biotac.ok, biotac.lifted)});
}

void append(const ContactErrors& more, ContactErrors& errors) {
  errors.points_mm.insert(errors.points_mm.end(), more.points_mm.begin(), more.points_mm.end());
  errors.normals_deg.insert(errors.normals_deg.end(), more.normals_deg.begin(),
                            more.normals_deg.end());
}

void add_row(Table& table, const std::string& name, const ContactErrors& errors) {
  if (errors.points_mm.empty()) return;
  const auto both = [](const std::vector<double>& values) {
    return fmt::format("{:.2f} / {:.2f}", median(values), quantile(values, 0.9));
  };
  table.add_row({name, fmt::format("{}", errors.points_mm.size()), both(errors.points_mm),
                 both(errors.normals_deg)});
}

void biotac_localization(const Options& options) {
  const Inverse inverse = inverse_of(options);
  const std::size_t trials = options.quick ? 1 : 10;
  Table table({"object", "picks", "lifted", "truth in modes: solver", "biotac",
               "pose right: solver", "biotac"});
  Tally all_solver, all_biotac;
  ContactErrors solver_errors, biotac_errors;
  std::size_t picks = 0;
  for (const auto& name : geometry::built_in_objects()) {
    const geometry::ObjectModel object(geometry::load_known_object(name));
    Tally solver, biotac;
    parallel_ordered(
        trials, options.threads,
        [&](std::size_t i) { return pick_and_locate_twice(object, inverse, options.seed + i); },
        [&](std::size_t, const Result& result) {
          if (!result.outcome.lifted) return;
          solver.add(result.outcome.solver);
          biotac.add(result.outcome.biotac);
          append(result.solver, solver_errors);
          append(result.biotac, biotac_errors);
        });
    picks += trials;
    add_row(table, name, trials, solver, biotac);
    all_solver.add(solver);
    all_biotac.add(biotac);
    if (options.quick) break;
  }
  add_row(table, "all", picks, all_solver, all_biotac);
  table.publish(options, "localization", "The same picks on the solver's and on inferred contacts");
  Table contacts({"contacts", "number", "off the surface mm, median / p90",
                  "off the normal deg, median / p90"});
  add_row(contacts, "solver, with noise", solver_errors);
  add_row(contacts, "inferred from channels", biotac_errors);
  contacts.publish(options, "contacts", "Lasting contacts against the true object");
}

}  // namespace

int main(int argc, char** argv) {
  return run(
      argc, argv, "biotac_localization",
      "Localization of the held object on contacts inferred from BioTac channels, beside the "
      "same picks on the solver's contacts.",
      biotac_localization);
}
