// SPDX-License-Identifier: Apache-2.0
#include "palpate/localization/localizer.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "palpate/core/error.hpp"
#include "scenes.hpp"

namespace palpate::localization {
namespace {

constexpr double kDegree = M_PI / 180;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

LocalizerOptions quick() {
  LocalizerOptions options;
  options.proposals = 30000;
  options.particles = 600;
  return options;
}

bool right(const Posterior& posterior, const ObjectModel& model, const Scene& scene) {
  return !posterior.modes.empty() &&
         within_tolerance(mode_error(posterior.modes[0], scene.truth, model.object().symmetries));
}

Scene scene_of(const std::string& name, SceneOptions options, std::uint64_t seed) {
  return make_scene(model_of(name), options, RandomStream(seed, "scene"));
}

double success_rate(const std::string& name, const SceneOptions& options, int scenes) {
  const ObjectModel& model = model_of(name);
  int successes = 0;
  for (int i = 0; i < scenes; ++i) {
    const Scene scene = scene_of(name, options, static_cast<std::uint64_t>(i));
    successes += right(localize(model, scene.evidence, RandomStream(7), quick()), model, scene);
  }
  return successes / static_cast<double>(scenes);
}

TEST(Localize, ExactContactsGiveTheExactPose) {
  SceneOptions options;
  options.contacts = 20;
  options.point_noise = 0;
  options.normal_noise = 0;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const ObjectModel& model = model_of("bunny");
    Scene scene = scene_of("bunny", options, seed);
    scene.evidence.noise_doubt = 0;
    const Posterior posterior = localize(model, scene.evidence, RandomStream(seed));
    ASSERT_FALSE(posterior.modes.empty());
    EXPECT_EQ(posterior.status, PoseStatus::certain);
    const PoseError error = mode_error(posterior.modes[0], scene.truth, model.object().symmetries);
    EXPECT_LT(error.rotation, 1 * kDegree);
    EXPECT_LT(error.translation, 0.001);
  }
}

TEST(Localize, SucceedsOftenOnNoisyContacts) {
  for (const std::string name : {"box", "bracket", "bunny"}) {
    SceneOptions options;
    options.contacts = 20;
    EXPECT_GE(success_rate(name, options, 15), 0.8) << name;
    options.contacts = 10;
    EXPECT_GE(success_rate(name, options, 15), 0.65) << name;
  }
}

TEST(Localize, FourContactsSufficeOnATable) {
  SceneOptions options;
  options.contacts = 4;
  options.table = true;
  for (const std::string name : {"box", "bracket", "bunny"}) {
    EXPECT_GE(success_rate(name, options, 15), 0.7) << name;
  }
}

TEST(Localize, BearsFalseContacts) {
  SceneOptions options;
  options.contacts = 20;
  options.false_share = 0.15;
  EXPECT_GE(success_rate("bunny", options, 12), 0.75);
}

TEST(Localize, CountsEqualPosesOfASymmetricObjectOnce) {
  const ObjectModel& model = model_of("box");
  ASSERT_EQ(model.object().symmetries.size(), 4U);
  SceneOptions options;
  options.contacts = 20;
  options.table = true;
  const Scene scene = scene_of("box", options, 4);
  const Posterior posterior = localize(model, scene.evidence, RandomStream(1));
  ASSERT_FALSE(posterior.modes.empty());
  EXPECT_EQ(posterior.status, PoseStatus::certain);
  EXPECT_GT(posterior.modes[0].weight, 0.95);
}

/// A mug that stands upright, touched round its side but for the half with the handle.
Scene mug_without_handle() {
  const ObjectModel& model = model_of("mug");
  const auto& stances = model.object().stances;
  const auto upright = std::find_if(stances.begin(), stances.end(), [](const auto& stance) {
    return stance.R_table_object(2, 2) > 0.99;
  });
  TableSupport table;
  table.T_frame_table = Eigen::Isometry3d::Identity();
  table.stance_weights.assign(stances.size(), 0);
  table.stance_weights[static_cast<std::size_t>(upright - stances.begin())] = 1;
  Scene scene;
  scene.truth.linear() = upright->R_table_object;
  scene.truth.translation().z() = upright->height;
  scene.evidence.table = table;
  // The handle stands out farthest from the axis of the cup.
  Eigen::Vector3d handle = Eigen::Vector3d::Zero();
  for (const auto& vertex : model.object().mesh.vertices) {
    if (vertex.head<2>().norm() > handle.head<2>().norm()) handle = vertex;
  }
  const Eigen::Vector3d away = -handle.cwiseProduct(Eigen::Vector3d(1, 1, 0)).normalized();
  for (int angle = -70; angle <= 70; angle += 10) {
    const Eigen::Vector3d side = exp_so3({0, 0, angle * kDegree}) * away;
    const double wall = 0.2 - mesh_of(model).raycast(0.2 * side, -side, 0.4)->distance;
    if (angle % 40 == 20 || angle % 40 == -20) {
      touch::Contact contact;
      contact.p = scene.truth * (wall * side);
      contact.n = scene.truth.linear() * side;
      scene.evidence.contacts.push_back(contact);
    }
    for (const double z : {-0.02, 0.0, 0.02}) {  // fingers, where no handle can be
      const Eigen::Vector3d beside = (wall + 0.013) * side + Eigen::Vector3d(0, 0, z);
      scene.evidence.free_space.push_back({scene.truth * beside, 0.009});
    }
  }
  return scene;
}

TEST(Localize, AMugWhoseHandleWasNotTouchedTurnsFreely) {
  const ObjectModel& model = model_of("mug");
  const Scene scene = mug_without_handle();
  const Posterior posterior = localize(model, scene.evidence, RandomStream(1));
  ASSERT_FALSE(posterior.modes.empty());
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  EXPECT_LE(posterior.modes.size(), 4U);
  const Mode& mode = posterior.modes[0];
  ASSERT_TRUE(mode.free_axis);
  EXPECT_GT(std::abs(mode.free_axis->direction.z()), std::cos(4 * kDegree));
  EXPECT_GT(mode.free_axis->extent, 70 * kDegree);
  EXPECT_LT(mode.free_axis->extent, 170 * kDegree);  // not where the fingers are
  EXPECT_TRUE(truth_in_modes(posterior, scene.truth, model.object().symmetries));
}

TEST(Localize, FreeSpaceRulesPosesOut) {
  const ObjectModel& model = model_of("mug");
  Scene scene = mug_without_handle();
  const Posterior with = localize(model, scene.evidence, RandomStream(1));
  scene.evidence.free_space.clear();
  const Posterior without = localize(model, scene.evidence, RandomStream(1));
  ASSERT_TRUE(!with.modes.empty() && with.modes[0].free_axis);
  ASSERT_TRUE(!without.modes.empty() && without.modes[0].free_axis);
  EXPECT_LT(with.modes[0].free_axis->extent, without.modes[0].free_axis->extent - 10 * kDegree);
}

TEST(Localize, WeightsAreAsOftenRight) {
  double expected = 0, successes = 0;
  constexpr int kScenes = 60;
  const std::string names[] = {"mug", "bottle", "box", "bracket", "bunny"};
  for (std::uint64_t i = 0; i < kScenes; ++i) {
    SceneOptions options;
    options.contacts = 4 + static_cast<int>(i % 4);
    const std::string& name = names[i % 5];
    const ObjectModel& model = model_of(name);
    const Scene scene = scene_of(name, options, i);
    const Posterior posterior = localize(model, scene.evidence, RandomStream(i), quick());
    expected += posterior.modes.empty() ? 0 : posterior.modes[0].weight;
    successes += right(posterior, model, scene);
  }
  EXPECT_NEAR(expected / kScenes, successes / kScenes, 0.2);
}

TEST(Localize, SaysWhenTheContactsAreOfSomethingElse) {
  const ObjectModel& model = model_of("bracket");
  SceneOptions options;
  options.contacts = 20;
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
    Scene scene = scene_of("mug", options, seed);
    scene.evidence.contacts[0].finger = 1;
    EXPECT_EQ(localize(model, scene.evidence, RandomStream(1), quick()).status,
              PoseStatus::no_pose);
  }
}

/// The misfit that is allowed grows with the expected share of false contacts, not without end.
TEST(Localize, TellsFalseContactsFromAnotherObject) {
  SceneOptions options;
  options.contacts = 20;
  for (const double share : {0.1, 0.2, 0.3}) {
    for (const std::uint64_t seed : {1U, 2U, 3U, 4U}) {
      Scene scene = scene_of("mug", options, seed);
      scene.evidence.false_contact_share = share;
      EXPECT_EQ(localize(model_of("bracket"), scene.evidence, RandomStream(1), quick()).status,
                PoseStatus::no_pose)
          << share;
      SceneOptions some_false = options;
      some_false.false_share = share;
      const Scene own = scene_of("bracket", some_false, seed);
      EXPECT_NE(localize(model_of("bracket"), own.evidence, RandomStream(1), quick()).status,
                PoseStatus::no_pose)
          << share;
    }
  }
}

/// Success with `change` made to what the search is told.
template <class Change>
double success_when(const std::string& name, const Change& change) {
  const ObjectModel& model = model_of(name);
  constexpr int kScenes = 15;
  int successes = 0;
  for (int i = 0; i < kScenes; ++i) {
    Scene scene = scene_of(name, {}, static_cast<std::uint64_t>(i));
    change(scene.evidence);
    successes += right(localize(model, scene.evidence, RandomStream(7), quick()), model, scene);
  }
  return successes / static_cast<double>(kScenes);
}

TEST(Localize, BearsNoiseOfAnotherSizeThanStated) {
  const double exact = success_when("bottle", [](Evidence&) {});
  for (const double times : {0.5, 2.0}) {
    const double wrong = success_when("bottle", [times](Evidence& evidence) {
      for (auto& contact : evidence.contacts) {
        contact.point_sigma *= times;
        contact.normal_sigma *= times;
      }
    });
    EXPECT_GE(wrong, exact - 0.1) << times;
  }
}

TEST(Localize, RefusesContactsInMillimetres) {
  Scene scene = scene_of("box", {}, 1);
  for (auto& contact : scene.evidence.contacts) contact.p *= 1000;
  EXPECT_THROW(localize(model_of("box"), scene.evidence, RandomStream(1)), BadInput);
}

TEST(Localize, FlippedNormalsGiveNoPose) {
  SceneOptions options;
  options.contacts = 20;
  Scene scene = scene_of("bunny", options, 1);
  for (auto& contact : scene.evidence.contacts) contact.n *= -1;
  EXPECT_EQ(localize(model_of("bunny"), scene.evidence, RandomStream(1)).status,
            PoseStatus::no_pose);
}

TEST(Localize, NoContactsGiveNoPose) {
  const Posterior posterior = localize(model_of("box"), {}, RandomStream(1));
  EXPECT_EQ(posterior.status, PoseStatus::no_pose);
  EXPECT_TRUE(posterior.modes.empty());
}

TEST(Localize, ContactsAtOnePointAreAmbiguous) {
  Scene scene = scene_of("bunny", {}, 3);
  scene.evidence.contacts.assign(8, scene.evidence.contacts.front());
  const Posterior posterior = localize(model_of("bunny"), scene.evidence, RandomStream(1), quick());
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  EXPECT_LT(posterior.modes.at(0).weight, 0.5);
}

TEST(Localize, ContactsOnOnePlaneAreAmbiguous) {
  const ObjectModel& model = model_of("box");
  Evidence evidence;
  for (int k = 0; k < 9; ++k) {
    touch::Contact contact;
    contact.p = {0.008 * (k % 3), 0.008 * static_cast<double>(k / 3), 0};
    contact.n = Eigen::Vector3d::UnitZ();
    evidence.contacts.push_back(contact);
  }
  const Posterior posterior = localize(model, evidence, RandomStream(1), quick());
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  for (const Mode& mode : posterior.modes) {  // the plane itself is found
    const double height = std::abs(mode.T_frame_object.translation().z());
    EXPECT_TRUE(std::abs(height - 0.025) < 0.004 || std::abs(height - 0.047) < 0.004 ||
                std::abs(height - 0.0875) < 0.004)
        << height;
  }
}

TEST(Localize, TenThousandContactsGiveThePose) {
  const ObjectModel& model = model_of("bunny");
  SceneOptions options;
  options.contacts = 100;
  Scene scene = scene_of("bunny", options, 5);
  auto& contacts = scene.evidence.contacts;
  while (contacts.size() < 10000) contacts.push_back(contacts[contacts.size() - 100]);
  const Posterior posterior = localize(model, scene.evidence, RandomStream(1), quick());
  EXPECT_TRUE(right(posterior, model, scene));
}

TEST(Localize, OneContactIsAmbiguous) {
  SceneOptions options;
  options.contacts = 1;
  const Scene scene = scene_of("bracket", options, 1);
  const Posterior posterior = localize(model_of("bracket"), scene.evidence, RandomStream(1));
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  ASSERT_FALSE(posterior.modes.empty());
  EXPECT_LT(posterior.modes[0].weight, 0.5);
}

TEST(Localize, ATableAloneGivesThePrior) {
  const ObjectModel& model = model_of("bracket");
  Evidence evidence;
  evidence.table.emplace().T_frame_table = Eigen::Isometry3d::Identity();
  evidence.table->half_width = 0.002;
  evidence.table->edge_sigma = 0.001;
  const Posterior posterior = localize(model, evidence, RandomStream(1));
  EXPECT_EQ(posterior.status, PoseStatus::ambiguous);
  ASSERT_FALSE(posterior.modes.empty());
  ASSERT_TRUE(posterior.modes[0].free_axis);
  EXPECT_NEAR(posterior.modes[0].free_axis->extent, M_PI, 1e-9);
  EXPECT_NEAR(posterior.modes[0].weight, model.object().stances[0].probability, 0.1);
}

TEST(Localize, IsTheSameForTheSameSeed) {
  const Scene scene = scene_of("bracket", {}, 1);
  const auto run = [&] {
    return localize(model_of("bracket"), scene.evidence, RandomStream(3), quick());
  };
  const Posterior a = run(), b = run();
  ASSERT_EQ(a.modes.size(), b.modes.size());
  for (std::size_t i = 0; i < a.modes.size(); ++i) {
    EXPECT_EQ(a.modes[i].weight, b.modes[i].weight);
    EXPECT_EQ(a.modes[i].T_frame_object.matrix(), b.modes[i].T_frame_object.matrix());
    EXPECT_EQ(a.modes[i].covariance, b.modes[i].covariance);
  }
}

TEST(Localize, MovesWithTheFrame) {
  SceneOptions options;
  options.contacts = 12;
  Scene scene = scene_of("bunny", options, 5);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = exp_so3({0.3, -1, 2});
  T.translation() << 1, -2, 0.5;
  scene.truth = T * scene.truth;
  for (auto& contact : scene.evidence.contacts) {
    contact.p = T * contact.p;
    contact.n = T.linear() * contact.n;
  }
  const ObjectModel& model = model_of("bunny");
  EXPECT_TRUE(right(localize(model, scene.evidence, RandomStream(1)), model, scene));
}

template <class Spoil>
void expect_bad(const std::string& value, Spoil&& spoil) {
  SceneOptions options;
  options.table = true;
  Scene scene = scene_of("box", options, 1);
  scene.evidence.free_space.push_back({Eigen::Vector3d::Zero(), 0.01});
  spoil(scene.evidence);
  try {
    localize(model_of("box"), scene.evidence, RandomStream(1), quick());
    FAIL() << "accepted; expected a complaint about " << value;
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find(value), std::string::npos) << error.what();
  }
}

TEST(Localize, RefusesWhatCannotBeUsed) {
  expect_bad("nan", [](Evidence& e) { e.contacts[2].p.x() = kNan; });
  expect_bad("contact 2", [](Evidence& e) { e.contacts[2].n.x() = kNan; });
  expect_bad("length 2", [](Evidence& e) { e.contacts[0].n *= 2; });
  expect_bad("point_sigma is 0", [](Evidence& e) { e.contacts[0].point_sigma = 0; });
  expect_bad("normal_sigma is -1", [](Evidence& e) { e.contacts[0].normal_sigma = -1; });
  expect_bad("false_contact_share is 1", [](Evidence& e) { e.false_contact_share = 1; });
  expect_bad("noise_doubt is 1", [](Evidence& e) { e.noise_doubt = 1; });
  expect_bad("size_doubt is -0.1", [](Evidence& e) { e.size_doubt = -0.1; });
  expect_bad("offset 0: sigma is 0", [](Evidence& e) { e.offsets = {{0.0, {}}}; });
  expect_bad("contact 1000 of", [](Evidence& e) { e.offsets = {{0.001, {{1000}}}}; });
  expect_bad("contact 0 is in another one", [](Evidence& e) {
    e.offsets = {{0.001, {{0}}}, {0.001, {{0}}}};
  });
  expect_bad("offset 0: its rotation is off", [](Evidence& e) {
    e.offsets = {{0.001, {{0, 2 * Eigen::Matrix3d::Identity()}}}};
  });
  expect_bad("penetration_sigma is 0", [](Evidence& e) { e.penetration_sigma = 0; });
  expect_bad("radius is -0.5", [](Evidence& e) { e.free_space[0].radius = -0.5; });
  expect_bad("free sphere 0", [](Evidence& e) { e.free_space[0].center.y() = kNan; });
  expect_bad("tilt_sigma is 0", [](Evidence& e) { e.table->tilt_sigma = 0; });
  expect_bad("1 stance weights", [](Evidence& e) { e.table->stance_weights = {1}; });
  expect_bad("T_frame_table", [](Evidence& e) { e.table->T_frame_table(0, 3) = kNan; });
}

TEST(ObjectModel, RefusesAnObjectWithoutTriangles) {
  EXPECT_THROW(ObjectModel{geometry::KnownObject{}}, BadInput);
}

TEST(ObjectModel, SamplesTheWholeSurface) {
  const ObjectModel& model = model_of("box");
  EXPECT_NEAR(model.area(), geometry::area(model.object().mesh), 1e-12);
  Eigen::AlignedBox3d box;
  Eigen::Vector3f flux = Eigen::Vector3f::Zero();
  for (const auto& point : model.surface()) {
    box.extend(point.p.cast<double>());
    flux += point.n;
    EXPECT_LT(std::abs(model.field().distance(point.p)), 0.001F);
  }
  EXPECT_LT((box.sizes() - geometry::bounds(model.object().mesh).sizes()).norm(), 0.004);
  EXPECT_LT(flux.norm() / static_cast<float>(model.surface().size()), 0.02F);
}

}  // namespace
}  // namespace palpate::localization
