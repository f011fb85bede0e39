// SPDX-License-Identifier: Apache-2.0
// Contacts anywhere on an object's surface, by their number and by how exact the sensor is.
#include <fmt/format.h>

#include <array>

#include "experiment.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/geometry/mesh/sampling.hpp"
#include "search_outcomes.hpp"

namespace {

using namespace palpate;
using experiment::SearchMethod;
using experiment::SearchOutcomes;
using experiment::SearchSubject;

constexpr int kShapes = 20, kScenes = 2, kScenesOfScan = 8;
constexpr std::array<std::size_t, 3> kContacts = {10, 20, 60};
constexpr std::array kPointSigmas = {1e-5, 1e-4, 5e-4, 1e-3};  // m
constexpr double kNormalSigma = 10 * kDegree, kSpread = 0.1;   // of the object's place, m

struct Scene {
  localization::Evidence evidence;
  Eigen::Isometry3d truth = Eigen::Isometry3d::Identity();
};

/// Points of the whole surface, with the normals of their faces, at a random pose.
Scene make_scene(const SearchSubject& subject, std::size_t contacts, double point_sigma,
                 const RandomStream& random) {
  Scene scene;
  RandomStream pose = random.fork("pose"), noise = random.fork("noise");
  scene.truth.linear() = pose.rotation();
  scene.truth.translation() = kSpread * pose.normal3();
  for (const auto& sample :
       geometry::sample_surface(subject.model.object().mesh, contacts, random.fork("points"))) {
    tactile::Contact contact;
    contact.p = scene.truth * sample.point + point_sigma * noise.normal3();
    contact.n =
        (scene.truth.linear() * sample.normal + kNormalSigma * noise.normal3()).normalized();
    contact.point_sigma = point_sigma;
    contact.normal_sigma = kNormalSigma;
    scene.evidence.contacts.push_back(contact);
  }
  return scene;
}

SearchOutcomes run_all(const experiment::Options& options,
                       const experiment::SearchSubjects& subjects, std::size_t contacts,
                       double point_sigma) {
  SearchOutcomes outcomes;
  for (const auto& subject : subjects) {
    SearchOutcomes of_subject(static_cast<std::size_t>(subject->scenes));
    parallel_for(of_subject.size(), options.threads, [&](std::size_t i) {
      const RandomStream random(subject->first_seed + i, "surface");
      const Scene scene = make_scene(*subject, contacts, point_sigma, random);
      of_subject[i] = search_pose(*subject, scene.evidence, scene.truth, SearchMethod::fast,
                                  random.fork("search"));
    });
    outcomes.insert(outcomes.end(), of_subject.begin(), of_subject.end());
  }
  return outcomes;
}

void publish(const experiment::Options& options, const experiment::SearchSubjects& subjects,
             const std::string& name, const std::string& title) {
  if (subjects.empty()) return;
  experiment::Table table(
      experiment::search_columns({"objects", "contacts", "error of a point, mm"}));
  for (const std::size_t contacts : kContacts) {
    for (const double sigma : kPointSigmas) {
      table.add_row(
          experiment::search_row({name, std::to_string(contacts), fmt::format("{}", 1e3 * sigma)},
                                 run_all(options, subjects, contacts, sigma)));
      if (options.quick) break;
    }
    if (options.quick) break;
  }
  table.publish(options, "surface_" + name, title);
}

void surface(const experiment::Options& options) {
  publish(options,
          experiment::generated_subjects(options, options.quick ? 1 : kShapes,
                                         options.quick ? 1 : kScenes),
          "generated", "contacts all over the surface, generated shapes");
  publish(options, experiment::scanned_subjects(options, kScenesOfScan), "scans",
          "contacts all over the surface, scanned objects");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "localization_surface",
                         "Right, stated probability and coverage of the pose posterior from "
                         "contacts all over the surface, by their number and their error",
                         surface);
}
