// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <numbers>

#include "experiment.hpp"
#include "palpate/core/random.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/objects/known_object.hpp"
#include "palpate/grasping/force_closure.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/simulation/world/open_loop_grasp.hpp"

namespace {

using namespace palpate;

constexpr int kEvery = 100;         // steps of the physics between grasps that are looked at
constexpr double kTall = 0.1;       // m, from the side; lower objects from above
constexpr std::size_t kFewest = 2;  // contacts
constexpr double kPerMicro = 1e6;

/// What the held objects' grasps were like, one value a look.
struct Tally {
  int looks = 0, closed = 0, balanced = 0, lifted = 0;
  std::vector<double> contacts, force_errors, margins, qualities, force_ratios;
  std::vector<double> closure_us, quality_us, balance_us;
};

template <class Call>
auto timed(std::vector<double>& micros, Call call) {
  const std::clock_t start = std::clock();
  auto result = call();
  micros.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC * kPerMicro);
  return result;
}

/// Sum of the normal forces, N.
double normal_force_sum(const Eigen::VectorXd& wrenches) {
  double sum = 0;
  for (Eigen::Index i = 3; i < wrenches.size(); i += 6) sum += wrenches[i];
  return sum;
}

void look(const simulation::ObjectStep& step, double time_step, Tally& tally) {
  grasping::GraspContacts contacts;
  Eigen::VectorXd wrenches(6 * static_cast<Eigen::Index>(step.contacts.size()));
  for (const simulation::ObjectContact& contact : step.contacts) {
    if (contact.link < 0) return;  // it still stands on the table
    wrenches.segment<6>(6 * static_cast<Eigen::Index>(contacts.size())) = contact.wrench;
    contacts.push_back({contact.T_world_contact, contact.link, contact.model, contact.friction});
  }
  if (contacts.size() < kFewest) return;
  ++tally.looks;
  tally.contacts.push_back(static_cast<double>(contacts.size()));
  const Eigen::Vector3d center = step.T_world_object.translation();
  const Eigen::Vector3d needed = step.momentum_change / time_step - step.gravity;
  const Vector6d made = grasping::object_wrench(grasping::grasp_matrix(contacts, center), wrenches);
  tally.force_errors.push_back((made.tail<3>() - needed).norm() / step.gravity.norm() * 100);
  const auto closure = timed(tally.closure_us, [&] { return grasping::force_closure(contacts); });
  tally.closed += closure.closed;
  tally.margins.push_back(closure.margin);
  tally.qualities.push_back(
      timed(tally.quality_us, [&] { return grasping::grasp_quality(contacts, center); }));
  Vector6d weight = Vector6d::Zero();
  weight.tail<3>() = -step.gravity;
  const auto balance =
      timed(tally.balance_us, [&] { return grasping::balance_wrench(contacts, center, weight); });
  if (balance.status != grasping::BalanceStatus::balanced) return;
  ++tally.balanced;
  tally.force_ratios.push_back(normal_force_sum(wrenches) /
                               normal_force_sum(balance.contact_wrenches));
}

Tally grasp_object(const std::string& name, int grasps, std::uint64_t seed) {
  const geometry::KnownObject object = geometry::load_known_object(name);
  const simulation::WorldOptions options;
  simulation::World world(object, options, seed);
  Tally tally;
  int steps = 0;
  world.observe([&](const simulation::ObjectStep& step) {
    if (steps++ % kEvery == 0) look(step, options.time_step, tally);
  });
  for (int i = 0; i < grasps; ++i) {
    RandomStream random = RandomStream(seed, "grasp").fork(name, static_cast<std::uint64_t>(i));
    simulation::OpenLoopGrasp grasp;
    grasp.start.yaw = random.uniform(-std::numbers::pi, std::numbers::pi);
    const double middle = object.stable_poses.front().height;
    grasp.side = 2 * middle > kTall;
    if (!grasp.side) grasp.height = middle + 0.015;
    tally.lifted += simulation::run_open_loop_grasp(world, grasp);
  }
  return tally;
}

std::string middle_of(const std::vector<double>& values, const char* format) {
  return values.empty() ? "-" : fmt::format(fmt::runtime(format), median(values));
}

std::string share(int part, int whole) {
  return whole == 0 ? "-" : fmt::format("{:.3f}", static_cast<double>(part) / whole);
}

void run(const experiment::Options& options) {
  experiment::Table table({"object", "grasps lifted", "looks", "contacts", "G w_c error % (max)",
                           "force closure", "margin N", "quality", "weight balanced",
                           "force over minimum", "closure us", "quality us", "balance us"});
  plotting::Plot plot;
  plot.title = "Grasp quality (largest ball in the wrench hull) of held objects";
  plot.y.label = "quality (N for 1 N of normal force)";
  plotting::BoxSeries boxes;
  const std::vector<std::string> objects =
      options.quick ? std::vector<std::string>{"bracket"}
                    : std::vector<std::string>{"bunny", "mug", "bracket", "bottle", "box"};
  const int grasps = options.quick ? 1 : 4;
  for (const std::string& name : objects) {
    const Tally tally = grasp_object(name, grasps, options.seed);
    const double worst = tally.looks ? quantile(tally.force_errors, 1) : 0;
    table.add_row({name, fmt::format("{} of {}", tally.lifted, grasps), std::to_string(tally.looks),
                   middle_of(tally.contacts, "{:.0f}"), fmt::format("{:.4f}", worst),
                   share(tally.closed, tally.looks), middle_of(tally.margins, "{:.3f}"),
                   middle_of(tally.qualities, "{:.3f}"), share(tally.balanced, tally.looks),
                   middle_of(tally.force_ratios, "{:.1f}"), middle_of(tally.closure_us, "{:.0f}"),
                   middle_of(tally.quality_us, "{:.0f}"), middle_of(tally.balance_us, "{:.0f}")});
    if (tally.looks == 0) continue;
    plot.categories.push_back(name);
    boxes.samples.push_back(tally.qualities);
  }
  table.publish(options, "grasp_kinematics", "Held objects: what the contacts can do (medians)");
  if (plot.categories.empty()) return;
  plot.series.emplace_back(boxes);
  experiment::publish_figure(options, "grasp_quality", plotting::to_svg(plot));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "hand_grasp_kinematics",
                         "Grasp matrix, force closure, quality and balancing forces (thesis eqs "
                         "4.2-4.9) in simulated grasps.",
                         run);
}
