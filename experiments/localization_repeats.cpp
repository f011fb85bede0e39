// SPDX-License-Identifier: Apache-2.0
// Touches that are written down in several rows, as in a log at 100 Hz: what their rows share must
// not count several times.
#include <fmt/format.h>

#include <array>

#include "experiment.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/localization/synthetic/grasp_scene.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "search_outcomes.hpp"

namespace {

using namespace palpate;
using namespace palpate::localization;
using experiment::SearchOutcomes;

/// How often each touch is written, and how its rows scatter, as a share of the stated errors.
struct Rows {
  int count;
  double scatter;
};
constexpr std::array<Rows, 5> kRows{{{1, 0}, {20, 0}, {20, 0.1}, {20, 0.3}, {20, 1}}};
constexpr std::array kTouches = {5, 10};
constexpr int kScenes = 12;  // of each built-in object

Evidence with_rows(Evidence evidence, const Rows& rows, const SceneEvidenceOptions& noise,
                   RandomStream random) {
  if (rows.count == 1) return evidence;
  std::vector<tactile::Contact> written;
  for (const tactile::Contact& touch : evidence.contacts) {
    for (int i = 0; i < rows.count; ++i) {
      written.push_back(rows.scatter > 0 ? disturbed(touch, rows.scatter * noise.point_noise,
                                                     rows.scatter * noise.normal_noise, random)
                                         : touch);
      written.back().point_sigma = touch.point_sigma;
      written.back().normal_sigma = touch.normal_sigma;
    }
  }
  evidence.contacts = std::move(written);
  return evidence;
}

SearchOutcomes run_subject(const experiment::Options& options,
                           const experiment::SearchSubject& subject, const hand::Description& hand,
                           int touches, const Rows& rows) {
  SearchOutcomes outcomes(static_cast<std::size_t>(subject.scenes));
  parallel_for(outcomes.size(), options.threads, [&](std::size_t i) {
    GraspSceneOptions scene_options;
    scene_options.contacts = touches;
    SceneEvidenceOptions input;
    input.contacts = touches;
    const RandomStream random(subject.first_seed + i, "repeats");
    const GraspScene scene =
        make_grasp_scene(subject.model, subject.mesh, hand, scene_options, random);
    const Evidence evidence = with_rows(scene_evidence(scene, input, random.fork("evidence")), rows,
                                        input, random.fork("rows"));
    outcomes[i] = search_pose(subject, evidence, scene.truth, experiment::SearchMethod::fast,
                              random.fork("search"));
  });
  return outcomes;
}

void repeats(const experiment::Options& options) {
  const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  experiment::SearchSubjects subjects;
  std::uint64_t seed = options.seed;
  for (const std::string& name : geometry::built_in_objects()) {
    if (options.quick && !subjects.empty()) break;
    const int scenes = options.quick ? 1 : kScenes;
    subjects.push_back(std::make_unique<experiment::SearchSubject>(name, seed, scenes));
    seed += kScenes;
  }
  experiment::Table table(experiment::search_columns({"touches", "rows of each", "scatter"}));
  for (const int touches : kTouches) {
    for (const Rows& rows : kRows) {
      SearchOutcomes all;
      for (const auto& subject : subjects) {
        const auto outcomes = run_subject(options, *subject, hand, touches, rows);
        all.insert(all.end(), outcomes.begin(), outcomes.end());
      }
      table.add_row(
          experiment::search_row({fmt::format("{}", touches), fmt::format("{}", rows.count),
                                  fmt::format("{}", rows.scatter)},
                                 all));
    }
  }
  table.publish(options, "repeats", "touches written in several rows");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "localization_repeats",
                         "Right, stated probability and coverage of the pose posterior where each "
                         "touch is written in several rows, which scatter by a share of the errors "
                         "stated",
                         repeats);
}
