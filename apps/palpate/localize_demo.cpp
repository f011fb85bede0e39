// SPDX-License-Identifier: Apache-2.0
#include "localize_demo.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "palpate/core/assets.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/localization/synthetic/grasp_scene.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "palpate/simulation/world/world.hpp"
#include "terminal.hpp"

namespace palpate::app {
namespace {

namespace lo = localization;

constexpr std::size_t kScenes = 4;
constexpr int kCounts[] = {5, 10, 20};      // contacts
constexpr const char* kInFile = "bracket";  // whose contacts are written

struct Share {
  double right = 0, stated = 0;
};

/// What of a scene the search is told.
struct Told {
  std::string name;
  lo::SceneEvidenceOptions evidence;
  bool normals = true;
};

Told told(const std::string& name, int contacts, bool normals, bool hand, bool swept) {
  Told result{name, {}, normals};
  result.evidence.contacts = contacts;
  result.evidence.hand = hand;
  result.evidence.swept = swept;
  return result;
}

/// Success and stated probability of each scene.
std::vector<Share> search_all(const geometry::ObjectModel& model,
                              const std::vector<lo::GraspScene>& scenes, const Told& told,
                              const CommonOptions& common) {
  constexpr double kNothing = 100;  // rad of noise: the normal tells nothing
  std::vector<Share> each(scenes.size());
  parallel_for(scenes.size(), common.threads, [&](std::size_t i) {
    const RandomStream random = RandomStream(common.seed, "demo").fork("evidence", i);
    auto evidence = lo::scene_evidence(scenes[i], told.evidence, random);
    for (auto& contact : evidence.contacts) {
      if (!told.normals) contact.normal_sigma = kNothing;
    }
    const auto posterior = lo::localize_fast(model, evidence, random);
    if (posterior.modes.empty()) return;
    const auto& best = posterior.modes.front();
    const auto error =
        lo::pose_error(best.T_frame_object, scenes[i].truth, model.object().symmetries);
    each[i].right = error.rotation < 5 * std::numbers::pi / 180 && error.translation < 0.01;
    each[i].stated = lo::pose_probability(best);
  });
  return each;
}

Share mean_of(const std::vector<Share>& shares) {
  Share mean;
  for (const Share& one : shares) {
    mean.right += one.right / static_cast<double>(shares.size());
    mean.stated += one.stated / static_cast<double>(shares.size());
  }
  return mean;
}

std::vector<lo::GraspScene> scenes_with(const geometry::ObjectModel& model,
                                        const hand::Description& hand,
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

/// A pose as four lines of four numbers.
std::string pose_rows(const Eigen::Isometry3d& T) {
  std::string text;
  for (int row = 0; row < 4; ++row) {
    text +=
        fmt::format("{:.9f} {:.9f} {:.9f} {:.9f}\n", T(row, 0), T(row, 1), T(row, 2), T(row, 3));
  }
  return text;
}

/// Share right against stated probability, in bins of equal numbers of searches.
plotting::Plot calibration_plot(std::vector<Share> searches) {
  constexpr std::size_t kMarginalBins = 5;
  std::stable_sort(searches.begin(), searches.end(),
                   [](const Share& a, const Share& b) { return a.stated < b.stated; });
  plotting::LineSeries measured{"measured", {}, {}};
  for (std::size_t bin = 0; bin < kMarginalBins; ++bin) {
    const auto at = [&](std::size_t i) {
      return searches.begin() + static_cast<std::ptrdiff_t>(searches.size() * i / kMarginalBins);
    };
    const Share mean = mean_of({at(bin), at(bin + 1)});
    measured.x.push_back(mean.stated);
    measured.y.push_back(mean.right);
  }
  plotting::Plot plot;
  plot.title = fmt::format("Is the stated probability true? {} searches", searches.size());
  plot.x = {"stated probability of the best pose", false, 0.0, 1.0};
  plot.y = {"share within 5 deg and 10 mm", false, 0.0, 1.0};
  plot.series = {plotting::LineSeries{"perfect", {0, 1}, {0, 1}}, measured};
  return plot;
}

/// What each kind of evidence adds, with ten contacts.
std::vector<Told> ablation() {
  return {told("points only", 10, false, false, false), told("+ normals", 10, true, false, false),
          told("+ hand", 10, true, true, false), told("+ swept tips", 10, true, true, true)};
}

}  // namespace

int demonstrate_localize(const CommonOptions& common) {
  const std::filesystem::path folder = common.out.empty() ? "out/localize-demo" : common.out;
  const OutputFolder output(
      folder, {"success.svg", "ablation.svg", "calibration.svg", "contacts.csv", "truth.txt"},
      common.force);
  const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  plotting::Plot plot, ablated;
  plot.title = "Pose from contacts and what the hand does not touch";
  plot.x = {"contacts of fingertips", false, 0.0, 20.0};
  plot.y = {"share within 5 deg and 10 mm", false, 0.0, 1.0};
  ablated.title = "Ten contacts: points, + normals, + hand, + swept tips";
  ablated.x = {"kinds of evidence", false, 1.0, 4.0};
  ablated.y = plot.y;
  auto objects = nlohmann::json::object();
  std::vector<Share> all;
  if (!common.json) {
    fmt::print("right / stated  5 contacts    10            20\n");
  }
  for (const auto& name : geometry::built_in_objects()) {
    const geometry::ObjectModel model(geometry::load_known_object(name));
    const auto scenes = scenes_with(model, hand, common);
    if (name == kInFile) {
      write_file_atomically(folder / "contacts.csv", contacts_csv(scenes[0], common.seed));
      write_file_atomically(folder / "truth.txt",
                            pose_rows(scenes[0].truth * model.object().T_mesh_object.inverse()));
    }
    plotting::LineSeries line{name, {}, {}}, kinds{name, {}, {}};
    std::string row = fmt::format("{:<14}", name);
    const Notice notice(name, common.quiet);
    for (const int count : kCounts) {
      const auto each = search_all(model, scenes, told("", count, true, true, true), common);
      all.insert(all.end(), each.begin(), each.end());
      const Share share = mean_of(each);
      line.x.push_back(count);
      line.y.push_back(share.right);
      row += fmt::format("  {:.2f} / {:.2f} ", share.right, share.stated);
      objects[name][std::to_string(count)] = {{"right", share.right}, {"stated", share.stated}};
    }
    for (const Told& kind : ablation()) {
      const Share share = mean_of(search_all(model, scenes, kind, common));
      kinds.x.push_back(static_cast<double>(kinds.x.size() + 1));
      kinds.y.push_back(share.right);
      objects[name][kind.name] = {{"right", share.right}, {"stated", share.stated}};
    }
    plot.series.push_back(line);
    ablated.series.push_back(kinds);
    if (!common.json) fmt::print("{}\n", row);
  }
  write_file_atomically(folder / "success.svg", plotting::to_svg(plot));
  write_file_atomically(folder / "ablation.svg", plotting::to_svg(ablated));
  write_file_atomically(folder / "calibration.svg",
                        plotting::to_svg(calibration_plot(std::move(all))));
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"objects", objects}, {"out", folder.string()}}.dump(2));
  } else {
    fmt::print(
        "wrote {1}: success.svg, ablation.svg, calibration.svg, contacts.csv (20 of the {0}), "
        "truth.txt (where it is)\n",
        kInFile, folder.string());
    print_next(common,
               fmt::format("palpate localize {} {}/contacts.csv", kInFile, folder.string()));
  }
  return kDone;
}

}  // namespace palpate::app
