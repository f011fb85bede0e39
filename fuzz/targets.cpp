// SPDX-License-Identifier: Apache-2.0
#include "targets.hpp"

#include "hdf5_targets.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/options.hpp"
#include "palpate/geometry/io/mesh_io.hpp"
#include "palpate/geometry/io/point_cloud_io.hpp"
#include "palpate/learning/training/checkpoint.hpp"
#include "palpate/localization/contacts_io.hpp"
#include "palpate/localization/free_space.hpp"
#include "palpate/registration/correspondences_io.hpp"
#include "palpate/simulation/hand/describe_hand.hpp"
#include "palpate/tactile/biotac/log.hpp"
#include "palpate/tactile/contacts/contact_log.hpp"
#include "palpate/tasks/relocate/policies/policy_io.hpp"

namespace palpate::fuzz {
namespace {

namespace fs = std::filesystem;
using Load = std::function<void(const fs::path&)>;

/// Runs all of them, also where one refuses the file.
Load each_of(const std::vector<Load>& loads) {
  return [loads](const fs::path& file) {
    bool any = false;
    std::string refusal;
    for (const auto& load : loads) {
      try {
        load(file);
        any = true;
      } catch (const BadInput& error) {
        refusal = error.what();
      }
    }
    if (!any) throw BadInput(refusal);
  };
}

struct SomeOptions {
  int attempts = 1;
  double way = 0.1;
  std::string name;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("attempts", attempts, 0, 10, "an integer");
    v("way", way, 0.0, 1.0, "a number");
    v("name", name, "a text");
  }
};

void load_options(const fs::path& file) {
  SomeOptions options;
  load_toml(file, options);
}

std::string sample_checkpoint(const fs::path& folder) {
  learning::Checkpoint checkpoint;
  checkpoint.method = "cem";
  checkpoint.arrays["mean"] = Eigen::MatrixXd::Constant(3, 5, 0.5);
  checkpoint.arrays["sd"] = Eigen::MatrixXd::Constant(3, 1, 0.1);
  learning::save_checkpoint(folder / "sample", checkpoint);
  return read_file(folder / "sample");
}

/// A network of one layer, 39 observations to 30 joints.
std::string sample_policy(const fs::path& folder) {
  constexpr std::size_t kIn = relocate::kRelocateObservations, kOut = relocate::kRelocateJoints;
  relocate::PolicyRecord record;
  record.kind = "mlp";
  record.sizes = {static_cast<int>(kIn), static_cast<int>(kOut)};
  record.arrays = {{"parameters", std::vector<double>(kIn * kOut + kOut, 0.5)},
                   {"input_shift", std::vector<double>(kIn, 0)},
                   {"input_scale", std::vector<double>(kIn, 1)},
                   {"output_shift", std::vector<double>(kOut, 0)},
                   {"output_scale", std::vector<double>(kOut, 1)},
                   {"log_std", std::vector<double>(kOut, -1)}};
  relocate::save_policy(folder / "sample.json", record);
  return read_file(folder / "sample.json");
}

}  // namespace

std::vector<Target> all_targets() {
  const Load mesh = [](const fs::path& file) { geometry::load_mesh(file); };
  const Load cloud = [](const fs::path& file) { geometry::load_cloud(file, 100); };
  const Load contacts = [](const fs::path& file) { localization::read_contacts(file, {}); };
  const Load spheres = [](const fs::path& file) { localization::read_free_space(file); };
  const Load planes = [](const fs::path& file) { localization::read_plane_contacts(file); };
  const Load log = [](const fs::path& file) { tactile::read_contact_log(file); };
  const Load biotac = [](const fs::path& file) { tactile::read_biotac_log(file); };
  const Load pairs = [](const fs::path& file) { registration::read_correspondences(file); };
  const Load policy = [](const fs::path& file) { relocate::load_policy(file); };
  const Load hand = [](const fs::path& file) { simulation::describe_hand(file, {}); };
  const Load checkpoint = [](const fs::path& file) { learning::load_checkpoint(file); };
  std::vector<Target> targets = {
      {"ply", "ply", "input.ply", each_of({mesh, cloud})},
      {"stl", "stl", "input.stl", each_of({mesh, cloud})},
      {"obj", "obj", "input.obj", each_of({mesh, cloud})},
      {"pcd", "pcd", "input.pcd", cloud},
      {"xyz", "xyz", "input.xyz", cloud},
      {"toml", "toml", "input.toml", load_options},
      {"policy", "json", "input.json", policy, sample_policy},
      {"csv", "csv", "input.csv", each_of({contacts, spheres, planes, log, biotac, pairs})},
      {"mjcf", "mjcf", "input.xml", hand},
      {"urdf", "urdf", "input.urdf", hand},
      {"checkpoint", "json", "input", checkpoint, sample_checkpoint},
  };
  for (auto& target : hdf5_targets()) targets.push_back(std::move(target));
  return targets;
}

}  // namespace palpate::fuzz
