// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "registration/consensus.hpp"
#include "registration/ego_graph.hpp"
#include "registration/false_alarm_test.hpp"
#include "registration/scorer.hpp"

namespace palpate::registration {

/// Search for the largest consensus about single pairs of samples.
class CliqueSearch {
 public:
  CliqueSearch(const Scorer& scorer, FalseAlarmTest& test, const Correspondences& all,
               const ConsensusOptions& options)
      : scorer_(scorer), false_alarm_test_(test), all_(all), options_(options) {}

  /// @param seeds  how many of the sample to look around; of a consensus found, as many more as
  /// show
  ///        that there is no larger one
  /// @return whether a pose was found that wrong pairs do not explain, and none better would come
  /// up
  bool run(const std::vector<int>& sample, int seeds, RandomStream random, Consensus& best);

  /// Evaluates the best pose.
  void conclude(Consensus& best);

 private:
  struct Pose {
    Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
    double gain = 0;
    int inliers = 0;
  };

  bool look_around(const std::vector<int>& sample, int seeds, RandomStream& random,
                   Consensus& best);
  int next_seed(std::vector<int>& order, const std::vector<int>& sample, std::size_t k,
                RandomStream& random) const;
  std::vector<int> clique_of(EgoGraph& graph, const std::vector<int>& sample, std::size_t& largest);
  std::size_t min_in_clique(std::size_t sample_size) const;
  bool exhausted(int seeds);
  bool is_beyond_doubt();
  bool is_clear(const std::vector<int>& sample, const std::vector<int>& clique);
  void settle();
  bool shows_larger(std::size_t sample_size) const;
  bool is_largest() const;
  bool propose(const std::vector<int>& clique, const PairColumns& nearby, double share,
               Consensus& best);
  void consider_mirror(const std::vector<int>& clique, const Eigen::Isometry3d& T);
  bool is_mirrored();
  double min_of_runner_up() const;
  void consider_runner_up(const Eigen::Isometry3d& T, double gain);
  bool keep_if_best(const Eigen::Isometry3d& T, double gain);
  bool is_beyond_chance(double level);
  void reconsider();
  void polish();
  bool exchange();
  bool refine(const std::vector<int>& exchanged, const std::vector<int>& inliers);
  Eigen::Isometry3d pose_of(const std::vector<int>& clique) const;
  int inliers_beside_best(const Eigen::Isometry3d& T) const;

  const Scorer& scorer_;
  FalseAlarmTest& false_alarm_test_;
  const Correspondences& all_;
  const ConsensusOptions& options_;
  Pose best_, runner_up_, mirrored_;
  double quick_ = 1, tested_ = 0, asked_ = 0, polished_ = 0;  // the last three: gains
  bool settled_ = false;        // the best pose is beyond chance: others are looked for
  int outside_ = 0;             // of a sample, pairs looked around that it does not explain
  std::vector<int> explained_;  // its inliers, ascending
};

}  // namespace palpate::registration
