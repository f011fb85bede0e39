// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/localization/information/next_touch.hpp"
#include "palpate/skills/probe/palpation_phase.hpp"
#include "skills/probe/probe_choice.hpp"

namespace palpate::skills {

/// Contacts that have lasted up to a reading, mount's frame.
std::vector<tactile::Contact> contacts_at(const Executor& robot, std::size_t reading);

/// Touches of other spots of a held object by one finger at a time: one that the others can do
/// without, who take over what it held.
class FingerProbes {
 public:
  /// A finger moved to another spot while the others hold: its actuators before it closes again.
  struct Move {
    int finger = 0;
    hand::ActuatorVector opened;  ///< of the whole hand
    ExpectedGain expected_gain;
  };

  /// @param press  of all fingers together, N, as the grasp's
  FingerProbes(const geometry::ObjectModel& object, const PalpationOptions& options, double press)
      : object_(object), options_(options), press_(press) {}

  /// Of the moves not made yet that should make a finger meet the object where it has not been, by
  /// the poses in question, the one of which most is to be learnt.
  std::optional<Move> choose(const Executor& robot, const localization::Posterior& held,
                             RandomStream random) const;

  /// Lets the others take over, opens the finger, moves it, closes it until it touches or has
  /// closed in vain, records `probed`, and brings it back.
  /// @return whether the thumb and another finger than the moved one still touch the object
  bool make(Executor& robot, const Move& move);

 private:
  /// A finger that the others can do without, and what they do meanwhile.
  struct FreeFinger {
    int finger = 0;
    hand::ActuatorVector held;  ///< the whole hand, pressing without this finger
  };
  /// How a move should end, by the poses in question.
  struct Prediction {
    double chance = 0;  ///< that the tip meets the object where it has not touched it
    localization::TouchAction probe{{0, 0, 0},
                                    {0, 0, 0}};  ///< the tip's way, as if it were straight
  };

  bool was_made(const hand::Description& hand, const Move& move) const;
  std::vector<FreeFinger> free_fingers(const Executor& robot,
                                       const localization::Posterior& held) const;
  std::vector<Move> moves(const Executor& robot, const FreeFinger& free) const;
  Prediction predict(const Executor& robot, const localization::Posterior& held, const Move& move,
                     const std::vector<Eigen::Vector3d>& known) const;

  const geometry::ObjectModel& object_;
  const PalpationOptions& options_;
  double press_;
  std::vector<Move> made_;
};

}  // namespace palpate::skills
