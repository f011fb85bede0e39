// SPDX-License-Identifier: Apache-2.0
// Contacts alone on objects that nobody chose: generated shapes and scans, by number of contacts.
#include <array>
#include <filesystem>

#include "experiment.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/localization/synthetic/grasp_scene.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "search_outcomes.hpp"

namespace {

using namespace palpate;
using namespace palpate::localization;
using experiment::SearchMethod;
using experiment::SearchOutcome;
using experiment::SearchOutcomes;
using experiment::SearchSubject;

constexpr int kShapes = 30, kScenesOfShape = 2, kScenesOfScan = 12;
constexpr std::array kContacts = {3, 5, 10, 20, 60};
constexpr int kGrasps = 40;  // at most, for a scene of that many contacts
constexpr std::array kMethods = {SearchMethod::fast, SearchMethod::full};
using OutcomesOfMethods = std::array<SearchOutcomes, kMethods.size()>;

std::array<SearchOutcome, kMethods.size()> run_one(const SearchSubject& subject,
                                                   const hand::Description& hand, int contacts,
                                                   std::uint64_t seed) {
  GraspSceneOptions scene_options;
  scene_options.contacts = contacts;
  scene_options.max_grasps = kGrasps;
  const RandomStream random(seed, "objects");
  const GraspScene scene =
      make_grasp_scene(subject.model, subject.mesh, hand, scene_options, random);
  SceneEvidenceOptions input;
  input.contacts = contacts;
  const Evidence evidence = scene_evidence(scene, input, random.fork("evidence"));
  const auto search_by = [&](SearchMethod method) {
    return search_pose(subject, evidence, scene.truth, method, random.fork("search"));
  };
  return {search_by(kMethods[0]), search_by(kMethods[1])};
}

OutcomesOfMethods run_subject(const experiment::Options& options, const SearchSubject& subject,
                              const hand::Description& hand, int contacts) {
  std::vector<std::array<SearchOutcome, kMethods.size()>> scenes(
      static_cast<std::size_t>(subject.scenes));
  parallel_for(scenes.size(), options.threads, [&](std::size_t i) {
    scenes[i] = run_one(subject, hand, contacts, subject.first_seed + i);
  });
  OutcomesOfMethods outcomes;
  for (const auto& scene : scenes) {
    for (std::size_t method = 0; method < scene.size(); ++method) {
      outcomes[method].push_back(scene[method]);
    }
  }
  return outcomes;
}

/// All subjects together, and each by itself.
void publish(const experiment::Options& options, const experiment::SearchSubjects& subjects,
             const std::string& name, const std::string& title) {
  if (subjects.empty()) return;
  const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  const auto columns = experiment::search_columns({"objects", "search", "contacts"});
  experiment::Table all(columns), each(columns);
  const auto row = [](const std::string& who, SearchMethod method, int contacts,
                      const SearchOutcomes& outcomes) {
    return experiment::search_row({who, std::string(to_string(method)), std::to_string(contacts)},
                                  outcomes);
  };
  for (const int contacts : kContacts) {
    OutcomesOfMethods pool;
    for (const auto& subject : subjects) {
      const auto outcomes = run_subject(options, *subject, hand, contacts);
      for (std::size_t m = 0; m < kMethods.size(); ++m) {
        each.add_row(row(std::filesystem::path(subject->name).stem().string(), kMethods[m],
                         contacts, outcomes[m]));
        pool[m].insert(pool[m].end(), outcomes[m].begin(), outcomes[m].end());
      }
    }
    for (std::size_t m = 0; m < kMethods.size(); ++m) {
      all.add_row(row(name, kMethods[m], contacts, pool[m]));
    }
    if (options.quick) break;
  }
  each.publish(options, name + "_each", title + ", each");
  all.publish(options, name, title);
}

void objects(const experiment::Options& options) {
  const int shapes = options.quick ? 1 : kShapes, scenes = options.quick ? 1 : kScenesOfShape;
  publish(options, experiment::generated_subjects(options, shapes, scenes), "generated",
          "contacts alone, generated shapes");
  publish(options, experiment::scanned_subjects(options, kScenesOfScan), "scans",
          "contacts alone, scanned objects");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "localization_objects",
                         "Right, stated probability and coverage of the pose posterior on "
                         "generated shapes and scans, by number of contacts",
                         objects);
}
