// SPDX-License-Identifier: Apache-2.0
// How many touches of an object on the table make its pose certain: chosen by information against
// random ones.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "experiment.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/query/mesh_query.hpp"
#include "palpate/localization/information/next_touch.hpp"
#include "palpate/localization/synthetic/grasp_scene.hpp"
#include "palpate/plotting/plot.hpp"

namespace {

using namespace palpate;
using namespace palpate::localization;

constexpr double kTip = 0.0075;  // m
constexpr double kWayIn = 0.15;  // m before the aim at which a probe starts
constexpr double kReach = 0.30;  // m
constexpr std::size_t kCandidates = 120;
constexpr int kLasting = 2;  // further probes after which the pose must still be certain
constexpr int kNever = 1000;

struct Subject {
  explicit Subject(const std::string& name)
      : model(geometry::load_known_object(name)), mesh(model.object().mesh) {}
  geometry::ObjectModel model;
  geometry::MeshQuery mesh;
};

/// From above or the side towards a place over the table.
TouchAction probe_at(const Eigen::Vector3d& aim, RandomStream& random) {
  Eigen::Vector3d direction = random.unit_vector();
  direction.z() = -std::abs(direction.z());
  TouchAction probe{aim - kWayIn * direction, direction, kReach, 1};
  if (direction.z() < -1e-3) {
    probe.reach = std::min(kReach, (kTip - probe.start.z()) / direction.z());
  }
  return probe;
}

TouchAction random_probe(RandomStream& random) {
  const double x = random.uniform(-0.05, 0.05), y = random.uniform(-0.05, 0.05);
  return probe_at({x, y, random.uniform(0.012, 0.13)}, random);
}

/// Half anywhere over the place, half at the surface of poses that are possible.
std::vector<TouchAction> candidates(const Subject& subject, const Posterior& posterior,
                                    RandomStream& random) {
  std::vector<TouchAction> probes;
  const auto poses = draw_poses(posterior, static_cast<int>(kCandidates / 2), random);
  const auto& surface = subject.model.surface();
  for (const auto& T : poses) {
    probes.push_back(probe_at(T * surface[random.index(surface.size())].p.cast<double>(), random));
  }
  while (probes.size() < kCandidates) probes.push_back(random_probe(random));
  return probes;
}

/// Adds what the true object gives: the free way, and the contact with a sensor's noise.
void touch(const Subject& subject, const Eigen::Isometry3d& truth, const TouchAction& probe,
           Evidence& evidence, RandomStream& random) {
  const PredictedTouch end = predict_touch(subject.model, truth, probe, kTip);
  const double way = end.hit ? end.distance : probe.reach;
  for (double s = 0.05; s < way - 0.002; s += 0.006) {
    evidence.free_space.push_back({probe.start + s * probe.direction, kTip});
  }
  if (!end.hit) return;
  const Eigen::Vector3d center = probe.start + end.distance * probe.direction;
  const auto closest = subject.mesh.closest_point(truth.inverse() * center);
  tactile::Contact contact;
  contact.p = truth * closest.point;
  contact.n = (center - contact.p).normalized();
  evidence.contacts.push_back(disturbed(contact, 0.001, 0.1745, random));
}

bool right(const Posterior& posterior, const Eigen::Isometry3d& truth, const Subject& subject) {
  if (posterior.modes.empty() || posterior.modes.front().free_axis) return false;
  const PoseError error =
      pose_error(posterior.modes.front().T_frame_object, truth, subject.model.object().symmetries);
  return error.rotation < 5 * kDegree && error.translation < 0.01;
}

struct Trial {
  int probes = kNever;  // until the pose is certain and stays so
  bool correct = false;
  std::vector<double> decision_seconds;
};

Trial run_trial(const Subject& subject, bool chosen, int most, RandomStream random) {
  const Eigen::Isometry3d truth = random_rest(subject.model, 0.02, random);
  Evidence evidence;
  evidence.table.emplace();
  evidence.table->T_frame_table = Eigen::Isometry3d::Identity();
  evidence.false_contact_share = 0.01;
  LocalizerOptions options;
  options.proposals = 20000;
  options.particles = 400;
  Posterior posterior = localize(subject.model, evidence, random.fork("start"), options);
  Trial trial;
  int certain_since = 0;
  for (int i = 1; i <= most; ++i) {
    TouchAction probe = random_probe(random);
    if (chosen && !posterior.modes.empty()) {
      const auto probes = candidates(subject, posterior, random);
      const auto start = std::chrono::steady_clock::now();
      probe =
          probes[choose_touch(subject.model, posterior, probes, random.fork("choice", i)).index];
      const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
      trial.decision_seconds.push_back(elapsed.count());
    }
    touch(subject, truth, probe, evidence, random);
    posterior = localize_fast(subject.model, evidence, random.fork("search", i), options);
    const bool certain = posterior.status == PoseStatus::certain;
    if (!certain) certain_since = 0;
    if (certain && certain_since == 0) certain_since = i;
    if (certain_since == 0 || i - certain_since < kLasting) continue;
    trial.probes = certain_since;
    trial.correct = right(posterior, truth, subject);
    break;
  }
  return trial;
}

struct Policy {
  std::vector<double> probes;
  double correct = 0;   // of those that ended
  double decision = 0;  // s, median
};

Policy run_policy(const experiment::Options& options, const Subject& subject, bool chosen) {
  const std::size_t trials = options.quick ? 1 : 30;
  const int most = options.quick ? 4 : 14;
  std::vector<Trial> all(trials);
  parallel_for(trials, options.threads, [&](std::size_t i) {
    all[i] = run_trial(subject, chosen, most, RandomStream(options.seed + i, "probes"));
  });
  Policy policy;
  std::vector<double> seconds{0};
  double ended = 0;
  for (const Trial& trial : all) {
    policy.probes.push_back(trial.probes);
    ended += trial.probes < kNever;
    policy.correct += trial.correct;
    seconds.insert(seconds.end(), trial.decision_seconds.begin(), trial.decision_seconds.end());
  }
  policy.correct /= std::max(1.0, ended);
  policy.decision = median(seconds);
  return policy;
}

plotting::LineSeries reached(const std::string& name, const std::vector<double>& probes) {
  plotting::LineSeries line{name, {}, {}};
  for (int k = 0; k <= 12; ++k) {
    const auto done = std::count_if(probes.begin(), probes.end(), [k](double p) { return p <= k; });
    line.x.push_back(k);
    line.y.push_back(static_cast<double>(done) / static_cast<double>(probes.size()));
  }
  return line;
}

std::string shown(double probes) {
  return probes >= kNever ? "> 12" : fmt::format("{:.1f}", probes);
}

void probes(const experiment::Options& options) {
  experiment::Table table({"object", "chosen: median probes", "right", "random: median probes",
                           "right", "decision ms"});
  std::vector<double> chosen_probes, random_probes;
  const auto objects =
      options.quick ? std::vector<std::string>{"box"} : geometry::built_in_objects();
  for (const auto& name : objects) {
    const Subject subject(name);
    const Policy chosen = run_policy(options, subject, true);
    const Policy random = run_policy(options, subject, false);
    table.add_row({name, shown(median(chosen.probes)), fmt::format("{:.2f}", chosen.correct),
                   shown(median(random.probes)), fmt::format("{:.2f}", random.correct),
                   fmt::format("{:.1f}", 1e3 * chosen.decision)});
    fmt::print(stderr, "{} done\n", name);
    chosen_probes.insert(chosen_probes.end(), chosen.probes.begin(), chosen.probes.end());
    random_probes.insert(random_probes.end(), random.probes.begin(), random.probes.end());
  }
  table.publish(options, "probes", "Touches until the pose is certain and stays so, on the table");
  plotting::Plot plot;
  plot.title = "Touches until the pose is certain, all objects";
  plot.x = {"touches", false, 0.0, 12.0};
  plot.y = {"share of trials certain", false, 0.0, 1.0};
  plot.series = {reached("chosen by information", chosen_probes), reached("random", random_probes)};
  experiment::publish_figure(options, "probes", plotting::to_svg(plot));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "localization_probes",
                         "Touches until the pose of an object on the table is certain: chosen by "
                         "information against random",
                         probes);
}
