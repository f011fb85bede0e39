// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "palpate/simulation/hand/describe_hand.hpp"
#include "simulation/hand/mimic_joints.hpp"
#include "simulation/world/mujoco_handles.hpp"

namespace palpate::simulation {

/// Names that a user has listed, separated by commas.
/// @throws BadInput, naming the key, for one that is empty or there twice
std::vector<std::string> listed(std::string_view key, std::string_view names);

/// Name of a thing in the model; empty for one without.
std::string model_name(const mjModel& model, mjtObj type, int id);

/// The hand's first body: the one with most joints below it.
/// @throws BadInput if no body has joints
std::string find_root(mjSpec& spec, const HandNotes& notes);

/// That the file has another body with joints enough for a hand, in words; empty: it has none.
std::string another_hand(mjSpec& spec, const std::string& root);

struct Chain {
  std::string name;
  std::vector<int> bodies;  ///< from the palm out
  int tip = -1;             ///< body of the fingertip
};

/// Names of fingers without what they all end in from a `_`, `-` or `.` on, as ff, mf and th of
/// ff_tip, mf_tip, th_tip.
void shorten(std::vector<Chain>& fingers);

/// What is below the root, as the compiled file has it.
class Anatomy {
 public:
  /// @param mimics  joints that follow others: they make no finger of their own
  /// @throws BadInput for a name in the notes that the model lacks, or tips that are none
  Anatomy(const mjModel& model, const std::string& root, const HandNotes& notes,
          const std::vector<MimicJoint>& mimics);

  int root() const { return root_; }
  int palm() const { return palm_; }
  const std::vector<Chain>& fingers() const { return fingers_; }
  bool is_below(int body) const { return is_below(body, root_); }
  /// Whether a body is another one or carried by it.
  bool is_below(int body, int above) const;
  /// Joints that move no fingertip, from the root on.
  std::vector<int> joints_of_no_finger() const;
  /// Joints that move several fingertips, as a wrist's, from the root on.
  std::vector<int> joints_before_fingers() const;

 private:
  int joints_in(int body) const;
  int driven_joints_in(int body) const;
  bool collides(int body) const;
  bool is_in_finger(int body) const;
  bool carries_tip(int body) const;
  int find_palm() const;
  std::vector<int> longest_chain(int body) const;
  std::vector<int> limbs(int body) const;
  void add_fingers(int body);
  Chain chain_to(const std::string& name) const;
  void find_fingers(const HandNotes& notes);
  void choose_tips(const HandNotes& notes);
  const std::vector<int>& children(int body) const {
    return children_[static_cast<std::size_t>(body)];
  }

  const mjModel& model_;
  int root_, palm_ = -1;
  std::vector<bool> follows_;  // by joint
  std::vector<std::vector<int>> children_;
  std::vector<Chain> fingers_;
};

/// @throws BadInput for a joint of the hand that slides, with the body to begin at where it only
/// carries the hand
void refuse_slides(const mjModel& model, const Anatomy& anatomy);

}  // namespace palpate::simulation
