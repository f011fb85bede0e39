// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/read_joints.hpp"

#include <fmt/format.h>

#include <cmath>

#include "palpate/core/error.hpp"
#include "simulation/hand/joint_drives.hpp"
#include "simulation/hand/model_checks.hpp"

namespace palpate::simulation {
namespace {

constexpr double kUsualBend = 1.57;  // rad, without limits

/// The limits the right way round, else those of its actuator's commands, else usual ones.
hand::Range range_without_limits(const mjModel& model, int joint,
                                 std::vector<HandProblem>& problems) {
  const mjtNum* const given = model.jnt_range + 2 * joint;
  const auto commanded = commanded_range(model, joint);
  const bool reversed = given[1] < given[0];
  const hand::Range range =
      reversed ? hand::Range{given[1], given[0]} : commanded.value_or(hand::Range{0, kUsualBend});
  problems.push_back(
      {fmt::format("{} of joint {}", reversed ? "reversed limits" : "no limits",
                   model_name(model, mjOBJ_JOINT, joint)),
       fmt::format("give it a range in the file; {:.3g} .. {:.3g} rad is used{}", range.low,
                   range.high, commanded && !reversed ? ", the commands of its actuator" : "")});
  return range;
}

}  // namespace

std::vector<int> read_joints(const mjModel& model, const Anatomy& anatomy, DescribedHand& result) {
  hand::Description& hand = result.hand;
  std::vector<int> ids;
  std::vector<std::string> stiff;
  for (int joint = 0; joint < model.njnt; ++joint) {
    if (!anatomy.is_below(model.jnt_bodyid[joint])) continue;
    const std::string name = model_name(model, mjOBJ_JOINT, joint);
    hand::Range range{model.jnt_range[2 * joint], model.jnt_range[2 * joint + 1]};
    const bool endless = std::isinf(range.low) || std::isinf(range.high);
    if (!endless) check_limits(name, range);
    if (endless || !model.jnt_limited[joint] || !(range.high > range.low)) {
      range = range_without_limits(model, joint, result.problems);
      check_limits(name, range);
    }
    if (range.high - range.low < kLeastBend) stiff.push_back(name);
    hand.joints.push_back({name, range});
    ids.push_back(joint);
  }
  if (!stiff.empty()) {
    result.problems.push_back(
        {fmt::format("joints turn by less than {} rad: {}", kLeastBend, first_of(stiff)),
         "are their limits in radians where the file's angles are degrees?"});
  }
  if (hand.joints.empty()) throw BadInput("the hand has no joints");
  if (hand.joint_count() > hand::kMaxJoints) {
    throw BadInput(fmt::format("the hand has {} joints, but at most {} are possible",
                               hand.joint_count(), hand::kMaxJoints));
  }
  return ids;
}

}  // namespace palpate::simulation
