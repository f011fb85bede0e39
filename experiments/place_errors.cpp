// SPDX-License-Identifier: Apache-2.0
// Which step of placing makes the error: the pose that was counted on, or the motion of the object
// in each step from closing the fingers to withdrawing the hand.
#include <fmt/format.h>

#include <cmath>
#include <map>

#include "experiment.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/simulation/collision/forward_model.hpp"

namespace {

using namespace palpate;
using namespace palpate::estimation;
using namespace palpate::evaluation;
using namespace palpate::grasping;
using namespace palpate::skills;

constexpr double kTouches = 0.0005;  // m over the table
constexpr std::size_t kTrials = 6;
const std::vector<std::string> kObjects = {"mug", "bottle", "box", "bracket", "bunny"};

/// What is looked at; the object's error is from the target, as if the mount stood where it is
/// meant to stand as long as it does not.
enum Moment {
  closed,
  squeezed,
  held,
  carried,
  contact,
  borne,
  unloaded,
  open,
  withdrawn,
  kMoments
};
const std::vector<std::string> kMomentNames = {"fingers closed", "squeezed",      "lifted",
                                               "carried",        "first contact", "borne",
                                               "unloaded",       "open",          "withdrawn"};

/// An error on the table: along world axes, and the angle of the whole rotation.
struct Error {
  Eigen::Vector2d xy = Eigen::Vector2d::Constant(NAN);
  double angle = NAN, tilt = NAN;
};

struct Outcome {
  std::string end;
  bool tight = false;
  std::array<Error, kMoments> errors;
  double contact_height = NAN;  // m of the mount over its goal, at the first contact
};

/// Everything that is true at a tick.
struct Tick {
  Eigen::Isometry3d T_world_mount, T_world_object;
  double lowest = 0;
};

class Watch {
 public:
  Watch(const geometry::KnownObject& object, std::uint64_t seed, bool again)
      : object_(object), seed_(seed), world_(object, options_.world, seed) {
    options_.place.target = "random";
    options_.place.reestimate = again;
  }
  Outcome run(const geometry::ObjectModel& model);

 private:
  Error error_at(std::size_t tick, const PlaceResult& place, bool at_target) const;

  const geometry::KnownObject& object_;
  std::uint64_t seed_;
  TrialOptions options_;
  simulation::World world_;
  std::vector<Tick> ticks_;
};

Error Watch::error_at(std::size_t tick, const PlaceResult& place, bool at_target) const {
  const Tick& at = ticks_[std::min(tick, ticks_.size() - 1)];
  const Eigen::Isometry3d T =
      at_target ? at.T_world_object
                : place.goal->mount.pose() * at.T_world_mount.inverse() * at.T_world_object;
  Error error;
  error.xy = (T.translation() - place.T_world_target.translation()).head<2>();
  error.angle = localization::pose_error(T, place.T_world_target, object_.symmetries).rotation;
  double tilt = M_PI;
  for (const auto& S : object_.symmetries) {
    const Eigen::Vector3d up = (T.linear() * S).row(2);
    tilt = std::min(tilt,
                    std::acos(std::clamp(up.dot(place.T_world_target.linear().row(2)), -1.0, 1.0)));
  }
  error.tilt = tilt;
  return error;
}

Outcome Watch::run(const geometry::ObjectModel& model) {
  world_.reset(draw_start(object_, options_.start, seed_), waiting_command(world_.hand_model()));
  std::map<TouchEvent, std::size_t> events;
  std::map<std::string, std::size_t, std::less<>> begins, ends;
  const simulation::SimulatedModels models;
  Executor robot(
      world_.hand(), world_.hand_model(), waiting_command(world_.hand_model()),
      {[&](const hand::HandReading& reading, const auto&) {
         const auto truth = world_.truth();
         ticks_.push_back({reading.mount.pose(), truth.T_world_object, truth.lowest_point});
       },
       [&](TouchEvent event) { events[event] = ticks_.size() - 1; },
       {}},
      &models);
  PhaseObserver observer{
      [&](std::string_view phase, double) { begins[std::string(phase)] = ticks_.size() - 1; },
      [&](const PhaseReport& report, double) { ends[report.name] = ticks_.size() - 1; }};
  const auto target = *place_target(object_, options_.place, seed_, 0);
  const PickAndPlaceResult course =
      pick_and_place(robot, {model, target, {}, options_.pick, options_.place, seed_}, observer);
  Outcome outcome;
  outcome.end = course.place ? std::string(to_string(course.place->status)) : "not held";
  if (!course.place) return outcome;
  const PlaceResult& place = *course.place;
  if (!place.goal || !place.T_world_placed) return outcome;
  std::size_t touch = begins["place"];
  while (touch < ends["place"] && ticks_[touch].lowest > kTouches) ++touch;
  const std::size_t placed = events[TouchEvent::placed];
  const auto later = [&](double seconds) {
    return placed + static_cast<std::size_t>(std::lround(seconds / hand::kTick));
  };
  const std::array<std::size_t, kMoments> moments = {events[TouchEvent::closed],
                                                     begins["lift"],
                                                     events[TouchEvent::held],
                                                     ends["transport"],
                                                     touch,
                                                     placed,
                                                     later(options_.place.lower.unload_seconds),
                                                     ends["place"],
                                                     ends["withdraw"]};
  for (std::size_t m = 0; m < kMoments; ++m) {
    outcome.errors[m] = error_at(moments[m], place, m >= contact);
  }
  const auto& mount = ticks_[touch].T_world_mount;
  outcome.contact_height = mount.translation().z() - place.goal->mount.xyz.z();
  const Error& end = outcome.errors[withdrawn];
  outcome.tight = end.angle < 3 * kDegree && end.xy.norm() < 0.005;
  return outcome;
}

void report(const std::string& name, std::uint64_t seed, const Outcome& outcome) {
  fmt::print(stderr, "{:<8}{:>5} {:<10} {} contact {:+5.1f} mm;", name, seed, outcome.end,
             outcome.tight ? "tight" : "     ", 1e3 * outcome.contact_height);
  for (const Error& e : outcome.errors) {
    fmt::print(stderr, " | {:+.1f} {:+.1f} {:.1f} {:.1f}", 1e3 * e.xy.x(), 1e3 * e.xy.y(),
               e.angle / kDegree, e.tilt / kDegree);
  }
  fmt::print(stderr, "\n");
}

void add_rows(const std::string& name, const std::vector<Outcome>& outcomes,
              experiment::Table& table) {
  for (std::size_t m = 0; m < kMoments; ++m) {
    std::vector<double> from_target, angles, moved, tilts;
    std::size_t off = 0;
    for (const Outcome& outcome : outcomes) {
      const Error& error = outcome.errors[m];
      if (std::isnan(error.angle)) continue;
      from_target.push_back(1e3 * error.xy.norm());
      angles.push_back(error.angle / kDegree);
      tilts.push_back(error.tilt / kDegree);
      if (m > 0) moved.push_back(1e3 * (error.xy - outcome.errors[m - 1].xy).norm());
      off += from_target.back() >= 5 || angles.back() >= 3;
    }
    if (from_target.empty()) return;
    table.add_row(
        {name, kMomentNames[m], fmt::format("{:.1f}", median(from_target)),
         fmt::format("{:.1f}", quantile(from_target, 0.9)),
         m > 0 ? fmt::format("{:.1f}", median(moved)) : "",
         m > 0 ? fmt::format("{:.1f}", quantile(moved, 0.9)) : "",
         fmt::format("{:.1f}", median(angles)), fmt::format("{:.1f}", quantile(angles, 0.9)),
         fmt::format("{:.1f}", median(tilts)), fmt::format("{} of {}", off, from_target.size())});
  }
}

std::vector<Outcome> run_all(const experiment::Options& options, const std::string& name,
                             bool again) {
  const geometry::ObjectModel model(geometry::load_known_object(name));
  std::vector<Outcome> outcomes(options.quick ? 1 : kTrials);
  parallel_ordered(
      outcomes.size(), options.threads,
      [&](std::size_t i) { return Watch(model.object(), options.seed + i, again).run(model); },
      [&](std::size_t i, Outcome outcome) {
        report(name, options.seed + i, outcome);
        outcomes[i] = std::move(outcome);
      });
  return outcomes;
}

void errors(const experiment::Options& options) {
  const std::vector<std::string> names = options.quick ? std::vector<std::string>{"box"} : kObjects;
  for (const bool again : {false, true}) {
    if (options.quick && !again) continue;
    experiment::Table table({"object", "moment", "mm (median)", "mm (.9)", "moved mm (median)",
                             "moved mm (.9)", "deg (median)", "deg (.9)", "tilt deg (median)",
                             "beyond 3 deg, 5 mm"});
    std::vector<Outcome> all;
    for (const std::string& name : names) {
      const auto outcomes = run_all(options, name, again);
      add_rows(name, outcomes, table);
      all.insert(all.end(), outcomes.begin(), outcomes.end());
    }
    add_rows("all", all, table);
    table.publish(options, again ? "estimated_twice" : "estimated_once",
                  again ? "Error from the target, estimated once more over it"
                        : "Error from the target, estimated after lifting alone");
  }
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "place_errors",
                         "Which step of placing makes the error of the placed object", errors);
}
