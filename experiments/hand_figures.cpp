// SPDX-License-Identifier: Apache-2.0
// The thesis' drawings of hands (figures 5.12, 7.1, A.1), from the descriptions that are computed
// with.
#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "experiment.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/hand/kinematics.hpp"
#include "palpate/learning/demonstrations/human_hand.hpp"
#include "palpate/plotting/plot.hpp"
#include "palpate/simulation/hand/load_hand.hpp"
#include "touch_surfaces.hpp"

namespace {

using namespace palpate;
using namespace palpate::experiment;

/// With the links and fingertips of its model.
hand::Description shadow_hand() {
  return simulation::load_shadow_hand(asset("shadow_hand/right_hand.xml"));
}

/// Points of the plane with which a line or a mark is drawn.
using Points = std::vector<Eigen::Vector2d>;

template <class Series>
Series series_of(const std::string& name, const Points& points) {
  Series series{.name = name, .x = {}, .y = {}};
  for (const auto& p : points) {
    series.x.push_back(p.x());
    series.y.push_back(p.y());
  }
  return series;
}

/// Orthographic view along one axis, in mm.
struct View {
  int right, up;
  Eigen::Vector2d operator()(const Eigen::Vector3d& p) const {
    return 1e3 * Eigen::Vector2d(p[right], p[up]);
  }
};

plotting::Plot drawing(const std::string& title, const View& view) {
  plotting::Plot plot;
  plot.title = title;
  plot.width = plot.height = 560;
  plot.x.label = fmt::format("{} (mm)", "xyz"[view.right]);
  plot.y.label = fmt::format("{} (mm)", "xyz"[view.up]);
  return plot;
}

/// Links as lines from joint to joint, tips as the axes of their capsules.
void draw_hand(const hand::Description& hand, const std::vector<Eigen::Isometry3d>& T_world_link,
               const View& view, plotting::Plot& plot) {
  for (std::size_t i = 0; i < hand.links.size(); ++i) {
    if (hand.links[i].parent < 0) continue;
    const auto parent = static_cast<std::size_t>(hand.links[i].parent);
    plot.series.emplace_back(series_of<plotting::LineSeries>(
        "", {view(T_world_link[parent].translation()), view(T_world_link[i].translation())}));
  }
  Points tips;
  for (const auto& finger : hand.fingers) {
    const auto& T = T_world_link[static_cast<std::size_t>(finger.link)];
    plot.series.emplace_back(
        series_of<plotting::LineSeries>("", {view(T.translation()), view(T * finger.tip.b)}));
    tips.push_back(view(T * finger.tip.b));
  }
  plot.series.emplace_back(series_of<plotting::ScatterSeries>("fingertips", tips));
}

/// Outline of an upright box, seen along y.
void draw_box(const geometry::TriangleMesh& box, const Eigen::Isometry3d& T_world_box,
              const View& view, plotting::Plot& plot) {
  const auto bounds = geometry::bounds(box);
  const Eigen::Vector3d low = bounds.min(), high = bounds.max();
  Points outline;
  for (const auto& [x, z] :
       {std::pair(low.x(), low.z()), std::pair(high.x(), low.z()), std::pair(high.x(), high.z()),
        std::pair(low.x(), high.z()), std::pair(low.x(), low.z())}) {
    outline.push_back(view(T_world_box * Eigen::Vector3d(x, 0, z)));
  }
  plot.series.emplace_back(series_of<plotting::LineSeries>("box", outline));
}

/// Figure 5.12: the hand with its first finger on the edge of the box, in the world's axes.
void draw_hand_on_edge(const Options& options) {
  const auto surface = touched_surface("edge");
  SlidingFinger finger(surface.object, sliding_world(), options.seed,
                       straight_finger(hand::FingerName::first));
  const auto ticks =
      finger.follow(path_over(surface, finger.tip_radius(), 4), surface.start, kPress);
  const auto on_edge = std::ranges::find_if(
      ticks, [](const SlideTick& tick) { return tick.true_normals.size() > 1; });
  const recording::Frame& frame = (on_edge == ticks.end() ? ticks.back() : *on_edge).frame;
  auto poses = hand::forward_kinematics(finger.believed_hand(), frame.reading.joints);
  for (auto& pose : poses) pose = frame.reading.mount.pose() * pose;
  const View view{0, 2};
  plotting::Plot plot = drawing("The hand on an edge, which runs along y", view);
  draw_hand(finger.believed_hand(), poses, view, plot);
  draw_box(surface.object.mesh, frame.truth.value().T_world_object, view, plot);
  publish_figure(options, "hand_on_edge", plotting::to_svg(plot));
}

/// Figure 7.1: vectors from the hand's root to the tips and to the middle joints.
void draw_task_space_vectors(const Options& options) {
  const hand::Description hand = shadow_hand();
  const auto poses =
      hand::forward_kinematics(hand, hand::joints_in_free_flexion(hand, hand.postures.top.open));
  const View view{0, 1};
  plotting::Plot plot = drawing("Task-space vectors of the Shadow hand, seen from above", view);
  const Eigen::Vector2d root = view(poses[static_cast<std::size_t>(hand.palm)].translation());
  Points tips, middles;
  for (const auto& finger : hand.fingers) {
    const auto& T = poses[static_cast<std::size_t>(finger.link)];
    tips.push_back(view(T * finger.tip.b));
    middles.push_back(view(T.translation()));
  }
  for (const Points& ends : {tips, middles}) {
    for (const auto& end : ends) {
      plot.series.emplace_back(series_of<plotting::LineSeries>("", {root, end}));
    }
  }
  plot.series.emplace_back(series_of<plotting::ScatterSeries>("root", {root}));
  plot.series.emplace_back(series_of<plotting::ScatterSeries>("middle joints", middles));
  plot.series.emplace_back(series_of<plotting::ScatterSeries>("tips", tips));
  publish_figure(options, "task_space_vectors", plotting::to_svg(plot));
}

/// A hinge of a kinematic tree: the fingers that it moves, and the hinge before it.
struct Hinge {
  std::string name;
  int parent = -1;
  std::vector<int> fingers = {};
  bool coupled = false;
};

/// A hand as hinges, parents first.
struct Tree {
  std::string name;
  std::vector<std::string> fingers;
  std::vector<Hinge> hinges;
};

bool is_coupled(const hand::Description& hand, int joint) {
  return std::ranges::any_of(hand.actuators, [&](const hand::Actuator& actuator) {
    return actuator.joints.size() > 1 &&
           std::ranges::any_of(actuator.joints, [&](const auto& d) { return d.joint == joint; });
  });
}

Tree tree_of(const hand::Description& hand) {
  Tree tree{"Shadow hand", {}, {}};
  std::vector<int> hinge_of(hand.links.size(), -1);  // the last one at or before each link
  for (std::size_t i = 0; i < hand.links.size(); ++i) {
    const hand::Link& link = hand.links[i];
    if (link.parent >= 0) hinge_of[i] = hinge_of[static_cast<std::size_t>(link.parent)];
    if (link.joint < 0) continue;
    const auto& name = hand.joints[static_cast<std::size_t>(link.joint)].name;
    tree.hinges.push_back({name, hinge_of[i], {}, is_coupled(hand, link.joint)});
    hinge_of[i] = static_cast<int>(tree.hinges.size()) - 1;
  }
  for (std::size_t f = 0; f < hand.fingers.size(); ++f) {
    tree.fingers.push_back(hand.fingers[f].name);
    for (int h = hinge_of[static_cast<std::size_t>(hand.fingers[f].link)]; h >= 0;) {
      Hinge& hinge = tree.hinges[static_cast<std::size_t>(h)];
      hinge.fingers.push_back(static_cast<int>(f));
      h = hinge.parent;
    }
  }
  return tree;
}

/// From the names of its joints: two letters for the wrist or a finger, numbered from the tip.
Tree human_tree() {
  Tree tree{"human hand", {}, {}};
  std::map<std::string, int> last;  // hinge of every finger
  for (const std::string_view name : learning::kHumanJointNames) {
    const std::string finger(name.substr(0, 2));
    const int wrist = last.contains("WR") ? last["WR"] : -1;
    const int parent = last.contains(finger) ? last[finger] : wrist;
    last[finger] = static_cast<int>(tree.hinges.size());
    tree.hinges.push_back({std::string(name), parent});
    if (finger == "WR") continue;
    if (tree.fingers.empty() || tree.fingers.back() != finger) tree.fingers.push_back(finger);
    tree.hinges.back().fingers = {static_cast<int>(tree.fingers.size()) - 1};
  }
  for (Hinge& hinge : tree.hinges) {
    if (!hinge.fingers.empty()) continue;
    for (std::size_t f = 0; f < tree.fingers.size(); ++f)
      hinge.fingers.push_back(static_cast<int>(f));
  }
  return tree;
}

/// Figure A.1: hinges from the wrist (top) to the tips, a column a finger.
void draw_tree(const Tree& tree, const std::string& file, const Options& options) {
  plotting::Plot plot;
  plot.title = fmt::format("Kinematic tree of the {}: {} joints", tree.name, tree.hinges.size());
  plot.categories = tree.fingers;
  plot.y.label = "joints from the wrist";
  Points places, coupled, single;
  for (const Hinge& hinge : tree.hinges) {
    double column = 0;
    for (const int finger : hinge.fingers)
      column += finger / static_cast<double>(hinge.fingers.size());
    const double depth =
        hinge.parent < 0 ? 1 : places[static_cast<std::size_t>(hinge.parent)].y() + 1;
    places.emplace_back(column, depth);
    (hinge.coupled ? coupled : single).push_back(places.back());
    if (hinge.parent < 0) continue;
    plot.series.emplace_back(series_of<plotting::LineSeries>(
        "", {places[static_cast<std::size_t>(hinge.parent)], places.back()}));
  }
  plot.series.emplace_back(series_of<plotting::ScatterSeries>("joint", single));
  if (!coupled.empty()) {
    plot.series.emplace_back(series_of<plotting::ScatterSeries>("coupled with another", coupled));
  }
  publish_figure(options, file, plotting::to_svg(plot));
}

void list_tree(const Tree& tree, Table& table) {
  for (std::size_t f = 0; f < tree.fingers.size(); ++f) {
    std::string chain;
    for (const Hinge& hinge : tree.hinges) {
      if (std::ranges::find(hinge.fingers, static_cast<int>(f)) == hinge.fingers.end()) continue;
      chain += (chain.empty() ? "" : " ") + hinge.name;
    }
    table.add_row({tree.name, tree.fingers[f], chain});
  }
}

void figures(const Options& options) {
  draw_hand_on_edge(options);
  draw_task_space_vectors(options);
  const Tree shadow = tree_of(shadow_hand()), human = human_tree();
  draw_tree(shadow, "tree_shadow", options);
  draw_tree(human, "tree_human", options);
  Table table({"hand", "finger", "joints from the wrist"});
  list_tree(shadow, table);
  list_tree(human, table);
  table.publish(options, "trees", "Kinematic trees");
}

}  // namespace

int main(int argc, char** argv) {
  return run(argc, argv, "hand_figures",
             "Draws the hand on an edge, task-space vectors, and the kinematic trees of the Shadow "
             "hand and a human hand (thesis figures 5.12, 7.1, A.1)",
             figures);
}
