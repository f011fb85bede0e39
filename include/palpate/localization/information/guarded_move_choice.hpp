// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "palpate/localization/localizer.hpp"

namespace palpate::localization {

/// A straight way of the probing fingertip's centre, world, m.
struct GuardedMove {
  Eigen::Vector3d from, to;
};

/// The probing finger during a guarded move: balls around its fingertip's centre, in the world's
/// axes.
struct ProbingFinger {
  std::vector<localization::FreeSphere> tip, rest;  ///< rest: of the hand
  Eigen::Matrix3d R_world_mount = Eigen::Matrix3d::Identity();
  double seconds = 1;  ///< s that a guarded move takes, with the turn of the hand before it
};

/// A guarded move and how well its end distinguishes poses.
struct InformativeMove {
  GuardedMove guarded_move;
  std::size_t index = 0;   ///< of it among the guarded moves
  double information = 0;  ///< probability that two draws from the poses are distinguished, at most
  double rate = 0;         ///< information per second
};

/// An object that it may be, and its poses, which weigh as much as it is probable.
struct PosedObject {
  const geometry::ObjectModel* object = nullptr;
  localization::Posterior posterior;
};

/// The one of some guarded moves whose end differs most between the poses that a posterior holds
/// for credible (poses_of: a mode with a free axis is several along it). Where another part of the
/// hand touches first, the guarded move ends, too. The ends are predicted for the move and for four
/// that pass 3 mm beside it; two poses count as distinguished by how much more their ends differ
/// than those of one pose (energy distance), because where the finger grazes the object chance
/// decides. Moves whose own end does not differ between the poses are left out.
/// @return nothing if no guarded move is informative
std::optional<InformativeMove> most_informative_move(const geometry::ObjectModel& object,
                                                     const localization::Posterior& posterior,
                                                     const ProbingFinger& finger,
                                                     const std::vector<GuardedMove>& guarded_moves);

/// The same where it may be one of several objects.
std::optional<InformativeMove> most_informative_move(const std::vector<PosedObject>& objects,
                                                     const ProbingFinger& finger,
                                                     const std::vector<GuardedMove>& guarded_moves);

/// How far a guarded move goes, m, before it would touch the object at one of its credible poses.
/// The nearest of them do not count as long as they and what the posterior's modes lack of 1
/// together are no more than `neglected`; 0 where the modes alone lack more.
double clear_way(const std::vector<PosedObject>& objects, const ProbingFinger& finger,
                 const GuardedMove& guarded_move, double neglected = 0.05);

/// How far a guarded move goes, m, until it has met the object at every credible pose at which it
/// meets it; its whole length where it would meet none, or where the modes lack more than 0.05
/// of 1.
double useful_way(const std::vector<PosedObject>& objects, const ProbingFinger& finger,
                  const GuardedMove& guarded_move);

/// A guarded move with the hand turned in one of several ways.
struct TurnedMove {
  GuardedMove guarded_move;
  std::size_t turn = 0;  ///< index of the finger
};

/// A guarded move and the errors of the pose without and with it: expected squares over those
/// of 2.5 deg and 3.5 mm, summed.
struct RefiningMove {
  TurnedMove guarded_move;
  double before = 0, after = 0;
};

/// The guarded move that lessens the error of a resting pose most per second, by the linearised
/// errors of the pose and of an offset of the fingertip that all touches share in the mount's
/// frame.
///
/// @param fingers  the probing finger for each turn of the hand
/// @param done     the guarded moves made so far
/// @param worthwhile  largest share of the error that a move may leave
/// @return nothing if no such guarded move touches the object
std::optional<RefiningMove> most_refining_move(const geometry::ObjectModel& object,
                                               const Eigen::Isometry3d& T_world_object,
                                               const std::vector<ProbingFinger>& fingers,
                                               const std::vector<GuardedMove>& guarded_moves,
                                               const std::vector<TurnedMove>& done,
                                               double worthwhile = 1);

}  // namespace palpate::localization
