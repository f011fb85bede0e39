// SPDX-License-Identifier: Apache-2.0
#include "skills/explore/guarded_moves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace palpate::skills {
namespace {

constexpr double kMinDepth = 0.014;       // m of the fingertip's centre over the table
constexpr int kDirections = 16;           // of further guarded moves
constexpr int kOffsets = 3;               // to either side of the object's place
constexpr double kSpacing = 0.015;        // m between them
constexpr double kDepthStep = 0.02;       // m between heights of further guarded moves
constexpr double kMinInformation = 0.03;  // of a guarded move that is worth its time
constexpr double kMuch = 0.15;            // by which other turns of the hand need not be tried
constexpr double kLight = 0.1;            // kg of an object that is touched at touch_speed
constexpr double kFaster = 2;             // times that speed, at most, for what is heavier

}  // namespace

double first_depth(const PickState& state, const ExploreOptions& options) {
  return std::max(kMinDepth, state.height - options.reach);
}

double speed_of_touch(const estimation::Candidates& candidates, const ExploreOptions& options) {
  double mass = std::numeric_limits<double>::infinity();
  for (const geometry::ObjectModel* candidate : candidates) {
    mass = std::min(mass, candidate->object().mass);
  }
  return options.touch_speed * std::clamp(mass / kLight, 1.0, kFaster);
}

Eigen::Vector2d middle_of(const PickState& state, const geometry::KnownObject& object) {
  if (!state.resting || state.resting->modes.empty()) return state.place;
  const Eigen::Isometry3d& T_world_object = state.resting->modes.front().T_frame_object;
  return (T_world_object * object.mass_properties.centroid).head<2>();
}

localization::GuardedMove level_guarded_move(const Eigen::Vector2d& place,
                                             const ExploreOptions& options, double angle,
                                             double offset, double depth) {
  const Eigen::Vector3d out(std::cos(angle), std::sin(angle), 0);
  const Eigen::Vector3d middle =
      Eigen::Vector3d(place.x(), place.y(), depth) + offset * Eigen::Vector3d::UnitZ().cross(out);
  return {middle + options.radius * out, middle - options.past * out};
}

void add_level_guarded_moves(const PickState& state, const ExploreOptions& options, double depth,
                             std::vector<localization::GuardedMove>& guarded_moves) {
  for (int i = 0; i < kDirections; ++i) {
    for (int side = -kOffsets; side <= kOffsets; ++side) {
      guarded_moves.push_back(level_guarded_move(state.place, options,
                                                 2 * std::numbers::pi * i / kDirections,
                                                 kSpacing * side, std::max(kMinDepth, depth)));
    }
  }
}

std::vector<localization::GuardedMove> disambiguating_moves(const PickState& state,
                                                            const ExploreOptions& options,
                                                            double above) {
  std::vector<localization::GuardedMove> guarded_moves;
  for (double depth = first_depth(state, options); depth > kMinDepth - 0.5 * kDepthStep;
       depth -= kDepthStep) {
    add_level_guarded_moves(state, options, depth, guarded_moves);
  }
  for (int x = -kOffsets; x <= kOffsets; ++x) {
    for (int y = -kOffsets; y <= kOffsets; ++y) {
      const Eigen::Vector2d xy = state.place + kSpacing * Eigen::Vector2d(x, y);
      guarded_moves.push_back({{xy.x(), xy.y(), above}, {xy.x(), xy.y(), kMinDepth}});
    }
  }
  return guarded_moves;
}

std::optional<localization::TurnedMove> take_most_informative(
    const std::vector<localization::PosedObject>& objects,
    const std::vector<localization::ProbingFinger>& fingers, UntriedMoves& untried) {
  std::optional<localization::InformativeMove> best;
  std::size_t best_turn = 0;
  double most = 0;
  for (const std::size_t turn : {1, 0, 2, 3}) {
    if (turn >= fingers.size() || (turn == 2 && most > kMuch)) break;
    const auto move = localization::most_informative_move(objects, fingers[turn], untried[turn]);
    if (!move || move->information < kMinInformation) continue;
    most = std::max(most, move->information);
    if (best && move->rate <= best->rate) continue;
    best = move;
    best_turn = turn;
  }
  if (!best) return std::nullopt;
  auto& moves = untried[best_turn];
  moves.erase(moves.begin() + static_cast<std::ptrdiff_t>(best->index));
  return localization::TurnedMove{best->guarded_move, best_turn};
}

}  // namespace palpate::skills
