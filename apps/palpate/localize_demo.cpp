// SPDX-License-Identifier: Apache-2.0
#include "localize_demo.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "given_command.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/localization/posterior.hpp"
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

/// Which evidence of a scene the search gets.
struct EvidenceKind {
  std::string name;
  lo::SceneEvidenceOptions evidence;
  bool normals = true;
};

EvidenceKind evidence_kind(const std::string& name, int contacts, bool normals, bool hand,
                           bool swept) {
  EvidenceKind result{name, {}, normals};
  result.evidence.contacts = contacts;
  result.evidence.hand = hand;
  result.evidence.swept = swept;
  return result;
}

/// The columns of the table: all evidence of a number of contacts.
std::vector<EvidenceKind> columns() {
  std::vector<EvidenceKind> all;
  for (const int count : kCounts)
    all.push_back(evidence_kind(std::to_string(count), count, true, true, true));
  return all;
}

/// What each kind of evidence adds, with ten contacts; with the last one it is all evidence, which
/// the table has.
std::vector<EvidenceKind> ablation() {
  return {evidence_kind("points only", 10, false, false, false),
          evidence_kind("+ normals", 10, true, false, false),
          evidence_kind("+ hand", 10, true, true, false)};
}
constexpr const char* kAllEvidence = "+ swept tips";
constexpr std::size_t kTenContacts = 1;  // of kCounts

/// Whether the pose found in a scene is right, and how probable it is stated to be.
Share search(const geometry::ObjectModel& model, const lo::GraspScene& scene,
             const EvidenceKind& kind, const RandomStream& random) {
  constexpr double kNothing = 100;  // rad of noise: the normal has no information
  auto evidence = lo::scene_evidence(scene, kind.evidence, random);
  for (auto& contact : evidence.contacts) {
    if (!kind.normals) contact.normal_sigma = kNothing;
  }
  const auto posterior = lo::localize_fast(model, evidence, random);
  if (posterior.modes.empty()) return {};
  const auto& best = posterior.modes.front();
  const auto error = lo::pose_error(best.T_frame_object, scene.truth, model.object().symmetries);
  const bool right = lo::within(error);
  return {right ? 1.0 : 0.0, lo::pose_probability(best)};
}

using Shares = std::vector<Share>;  // one a scene

/// The searches of all scenes with each kind of evidence.
std::vector<Shares> search_all(const geometry::ObjectModel& model,
                               const std::vector<lo::GraspScene>& scenes,
                               const std::vector<EvidenceKind>& kinds,
                               const CommonOptions& common) {
  std::vector<Shares> each(kinds.size(), Shares(scenes.size()));
  parallel_for(kinds.size() * scenes.size(), common.threads, [&](std::size_t i) {
    const std::size_t kind = i / scenes.size(), scene = i % scenes.size();
    const RandomStream random = RandomStream(common.seed, "demo").fork("evidence", scene);
    each[kind][scene] = search(model, scenes[scene], kinds[kind], random);
  });
  return each;
}

Share mean_of(const Shares& shares) {
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
  lo::SceneEvidenceOptions options;
  options.contacts = 20;
  std::string text = "x,y,z,nx,ny,nz,t\n";
  for (const auto& c : lo::scene_evidence(scene, options, RandomStream(seed)).contacts) {
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
plotting::Plot calibration_plot(Shares searches) {
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

/// The plots while they grow, an object at a time, and the same as JSON.
struct Findings {
  plotting::Plot success, ablation;
  nlohmann::json objects = nlohmann::json::object();
  Shares all;  // of the table
};

Findings no_findings() {
  Findings none;
  none.success.title = "Pose from contacts and what the hand does not touch";
  none.success.x = {"contacts of fingertips", false, 0.0, 20.0};
  none.success.y = {"share within 5 deg and 10 mm", false, 0.0, 1.0};
  none.ablation.title = "What each kind of evidence brings to ten contacts";
  none.ablation.x = {"1: points, 2: + normals, 3: + hand, 4: + swept tips", false, 1.0, 4.0};
  none.ablation.y = none.success.y;
  return none;
}

/// Adds the searches of an object. @return its row of the table
std::string add_object(const geometry::ObjectModel& model,
                       const std::vector<lo::GraspScene>& scenes, const CommonOptions& common,
                       Findings& findings) {
  const std::string& name = model.object().name;
  auto kinds = columns();
  const std::size_t in_table = kinds.size();
  for (EvidenceKind& kind : ablation()) kinds.push_back(std::move(kind));
  auto searches = search_all(model, scenes, kinds, common);
  kinds.push_back({kAllEvidence, {}, true});
  searches.push_back(searches[kTenContacts]);

  plotting::LineSeries line{name, {}, {}}, ablated{name, {}, {}};
  std::string row = fmt::format("{:<14}", name);
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const Share share = mean_of(searches[i]);
    findings.objects[name][kinds[i].name] = {{"right", share.right}, {"stated", share.stated}};
    if (i < in_table) {
      findings.all.insert(findings.all.end(), searches[i].begin(), searches[i].end());
      line.x.push_back(kCounts[i]);
      line.y.push_back(share.right);
      row += fmt::format("  {:.2f} / {:.2f} ", share.right, share.stated);
    } else {
      ablated.x.push_back(static_cast<double>(ablated.x.size() + 1));
      ablated.y.push_back(share.right);
    }
  }
  findings.success.series.push_back(line);
  findings.ablation.series.push_back(ablated);
  return row;
}

void write_contacts(const std::filesystem::path& folder, const geometry::ObjectModel& model,
                    const lo::GraspScene& scene, std::uint64_t seed) {
  write_file_atomically(folder / "contacts.csv", contacts_csv(scene, seed));
  write_file_atomically(folder / "truth.txt",
                        pose_rows(scene.truth * model.object().T_mesh_object.inverse()));
}

void write_plots(const std::filesystem::path& folder, const Findings& findings) {
  write_file_atomically(folder / "success.svg", plotting::to_svg(findings.success));
  write_file_atomically(folder / "ablation.svg", plotting::to_svg(findings.ablation));
  write_file_atomically(folder / "calibration.svg",
                        plotting::to_svg(calibration_plot(findings.all)));
}

}  // namespace

int demonstrate_localize(const CommonOptions& common) {
  const std::filesystem::path folder = common.out.empty() ? "out/localize-demo" : common.out;
  const OutputFolder output(
      folder, {"success.svg", "ablation.svg", "calibration.svg", "contacts.csv", "truth.txt"},
      common.force);
  const auto hand = simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
  Findings findings = no_findings();
  if (!common.json) fmt::print("right / stated  5 contacts    10            20\n");
  for (const auto& name : geometry::built_in_objects()) {
    std::optional<Notice> notice(std::in_place, name, common.quiet);
    const geometry::ObjectModel model(geometry::load_known_object(name));
    const auto scenes = scenes_with(model, hand, common);
    if (name == kInFile) write_contacts(folder, model, scenes[0], common.seed);
    const std::string row = add_object(model, scenes, common, findings);
    notice.reset();
    if (!common.json) fmt::print("{}\n", row);
  }
  write_plots(folder, findings);
  if (common.json) {
    print_json(nlohmann::json{{"objects", findings.objects}, {"out", folder.string()}});
  } else {
    fmt::print(
        "wrote {1}: success.svg, ablation.svg, calibration.svg, contacts.csv (20 of the {0}), "
        "truth.txt (where it is)\n",
        kInFile, folder.string());
    print_next(common, fmt::format("palpate localize {} {}", kInFile,
                                   quoted((folder / "contacts.csv").string())));
  }
  return kDone;
}

}  // namespace palpate::app
