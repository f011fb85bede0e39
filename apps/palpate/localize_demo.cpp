// SPDX-License-Identifier: Apache-2.0
#include "localize_demo.hpp"

#include <fmt/format.h>

#include <numbers>

#include "palpate/core/assets.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/plot.hpp"
#include "palpate/localization/grasp_scene.hpp"
#include "palpate/simulation/world.hpp"

namespace palpate::app {
namespace {

namespace lo = localization;

constexpr std::size_t kScenes = 4;
constexpr int kCounts[] = {3, 5, 10, 20};  // contacts

struct Share {
  double right = 0, stated = 0;
};

/// Success and stated probability with the first contacts of each scene.
Share share_right(const lo::ObjectModel& model, const std::vector<lo::GraspScene>& scenes,
                  int contacts, const CommonOptions& common) {
  std::vector<Share> each(scenes.size());
  parallel_for(scenes.size(), common.threads, [&](std::size_t i) {
    lo::SceneEvidenceOptions told;
    told.contacts = contacts;
    const RandomStream random = RandomStream(common.seed, "demo").fork("evidence", i);
    const auto posterior =
        lo::localize_fast(model, lo::scene_evidence(scenes[i], told, random), random);
    if (posterior.modes.empty()) return;
    const auto& best = posterior.modes.front();
    const auto error =
        lo::pose_error(best.T_frame_object, scenes[i].truth, model.object().symmetries);
    each[i].right = error.rotation < 5 * std::numbers::pi / 180 && error.translation < 0.01;
    each[i].stated = best.weight;
  });
  Share mean;
  for (const Share& one : each) {
    mean.right += one.right / static_cast<double>(each.size());
    mean.stated += one.stated / static_cast<double>(each.size());
  }
  return mean;
}

std::vector<lo::GraspScene> scenes_with(const lo::ObjectModel& model, const hand::HandModel& hand,
                                        const CommonOptions& common) {
  const geometry::MeshQuery mesh(model.object().mesh);
  std::vector<lo::GraspScene> scenes;
  for (std::size_t i = 0; i < kScenes; ++i) {
    const RandomStream random = RandomStream(common.seed, "demo").fork(model.object().name, i);
    scenes.push_back(lo::make_grasp_scene(model, mesh, hand, {}, random));
  }
  return scenes;
}

/// Contacts of a scene in the mesh's own frame of reference, as the command reads them.
std::string contacts_csv(const lo::GraspScene& scene, std::uint64_t seed) {
  lo::SceneEvidenceOptions told;
  told.contacts = 20;
  std::string text = "x,y,z,nx,ny,nz,t\n";
  for (const auto& c : lo::scene_evidence(scene, told, RandomStream(seed)).contacts) {
    text += fmt::format("{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{}\n", c.p[0], c.p[1], c.p[2],
                        c.n[0], c.n[1], c.n[2], c.time);
  }
  return text;
}

}  // namespace

int demonstrate_localize(const CommonOptions& common) {
  const std::filesystem::path folder = common.out.empty() ? "out/localize-demo" : common.out;
  const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  Plot plot;
  plot.title = "Pose from contacts and what the hand does not touch";
  plot.x = {"contacts of fingertips", false, 0.0, 20.0};
  plot.y = {"share within 5 deg and 10 mm", false, 0.0, 1.0};
  auto objects = nlohmann::json::object();
  if (!common.json) {
    fmt::print("right / stated  3 contacts    5             10            20\n");
  }
  for (const auto& name : geometry::built_in_objects()) {
    const lo::ObjectModel model(geometry::load_known_object(name));
    const auto scenes = scenes_with(model, hand, common);
    if (name == "mug") {
      write_file_atomically(folder / "contacts.csv", contacts_csv(scenes[0], common.seed));
    }
    LineSeries line{name, {}, {}};
    std::string row = fmt::format("{:<14}", name);
    for (const int count : kCounts) {
      const Share share = share_right(model, scenes, count, common);
      line.x.push_back(count);
      line.y.push_back(share.right);
      row += fmt::format("  {:.2f} / {:.2f} ", share.right, share.stated);
      objects[name][std::to_string(count)] = {{"right", share.right}, {"stated", share.stated}};
    }
    plot.series.push_back(line);
    if (!common.json) fmt::print("{}\n", row);
  }
  write_file_atomically(folder / "success.svg", to_svg(plot));
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"objects", objects}, {"out", folder.string()}}.dump(2));
  } else {
    fmt::print("wrote {}: success.svg, contacts.csv (20 contacts of the mug)\n", folder.string());
  }
  return kDone;
}

}  // namespace palpate::app
