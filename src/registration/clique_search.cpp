// SPDX-License-Identifier: Apache-2.0
#include "registration/clique_search.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <numeric>

#include "palpate/registration/gnc.hpp"

namespace palpate::registration {
namespace {

// From so large a sample on a pose is worth more than a quick test.
constexpr std::size_t kLargeSample = 500;
constexpr int kLargestClique = 16;
// Chance proposes cliques too; those well below the largest are passed over, up to this size.
constexpr std::size_t kSurelyLarge = 8;
// Of the best gain, what a clique's pose must have to be refined; of the gain that is wanted of
// all, what the few pairs near a clique must have.
constexpr double kWorthRefining = 0.5, kNearby = 0.5;
constexpr float kNear = 2;  // bounds, within which a slightly wrong pose brings right pairs
// Lengths must agree within this many bounds, instead of the consistency graph's 1.25; where there
// are few pairs to lose, within those.
constexpr double kLengthTolerance = 0.65, kWideTolerance = 1.25;
constexpr int kFewPairs = 64;
// A pose that chance proposes less often than kClear ends the search; in a small sample, by the
// quick test, less often than kClearAtOnce. Above kHopeless no other test is needed.
constexpr double kClear = 1e-4, kHopeless = 1e6;
// A sample shows a consensus if it holds so many of its pairs.
constexpr double kShown = 5;

/// Of ascending lists.
std::vector<int> without(const std::vector<int>& all, const std::vector<int>& excluded) {
  std::vector<int> rest;
  std::ranges::set_difference(all, excluded, std::back_inserter(rest));
  return rest;
}

bool holds(const std::vector<int>& ascending, int value) {
  return std::ranges::binary_search(ascending, value);
}

}  // namespace

bool CliqueSearch::run(const std::vector<int>& sample, int seeds, RandomStream random,
                       Consensus& best) {
  outside_ = 0;
  if (!settled_) look_around(sample, seeds, random, best);
  if (!settled_ && sample.size() >= kLargeSample && is_beyond_doubt()) settle();
  // What the settled pose explains is left out, which makes what is left soon done.
  while (settled_ && shows_larger(sample.size()) && !is_largest()) {
    const std::vector<int> rest = without(sample, explained_);
    if (!look_around(rest, static_cast<int>(rest.size()), random, best)) break;
  }
  return settled_ && shows_larger(sample.size()) && is_largest();
}

/// @return whether a pose was settled on, which ends it
bool CliqueSearch::look_around(const std::vector<int>& sample, int seeds, RandomStream& random,
                               Consensus& best) {
  PairColumns columns;
  gather(scorer_.columns(), sample, columns);
  const bool few = options_.best_effort && scorer_.size() <= kFewPairs;
  EgoGraph graph(columns, few ? kWideTolerance : kLengthTolerance, options_.normal_noise_deg);
  std::vector<int> order(sample.size());
  std::iota(order.begin(), order.end(), 0);
  std::size_t largest = 0;
  const double share = static_cast<double>(sample.size()) / scorer_.size();
  for (int k = 0; k < seeds; ++k) {
    if (settled_ && is_largest()) return false;
    graph.look_around(next_seed(order, sample, static_cast<std::size_t>(k), random));
    ++outside_;
    const std::vector<int> clique = clique_of(graph, sample, largest);
    const bool better = !clique.empty() && propose(clique, graph.nearby(), share, best);
    if (settled_ ? better : exhausted(k + 1) || (better && is_clear(sample, clique))) {
      settle();
      return true;
    }
  }
  return false;
}

void CliqueSearch::settle() {
  polish();
  settled_ = true;
  explained_ = scorer_.near(best_.T, 1);
}

/// Whether a consensus larger than the best would show in a sample of that size.
bool CliqueSearch::shows_larger(std::size_t sample_size) const {
  const double others = scorer_.size() - best_.inliers;
  return static_cast<double>(sample_size) * best_.inliers >= kShown * others ||
         static_cast<int>(sample_size) == scorer_.size();
}

/// Whether, of so many pairs looked around that the best pose does not explain, one of a larger
/// consensus would have come up; and of a runner-up that has an eighth of its inliers, if that is
/// soon done.
bool CliqueSearch::is_largest() const {
  constexpr double kLogMissed = 3.5, kRunnerUpShare = 0.125, kMaxForRunnerUp = 60;
  const double others = scorer_.size() - best_.inliers;
  const double larger = best_.inliers >= others ? 0 : kLogMissed * others / best_.inliers;
  const double runner_up = 2 * kLogMissed * others / (kRunnerUpShare * best_.inliers);
  return outside_ >= std::max(larger, std::min(runner_up, kMaxForRunnerUp));
}

int CliqueSearch::next_seed(std::vector<int>& order, const std::vector<int>& sample, std::size_t k,
                            RandomStream& random) const {
  if (all_.weights.empty()) {
    std::swap(order[k], order[k + random.index(order.size() - k)]);
  } else if (k == 0) {
    std::ranges::stable_sort(order, std::greater<>(), [&](int i) {
      return all_.weights[static_cast<std::size_t>(sample[static_cast<std::size_t>(i)])];
    });
  }
  return order[k];
}

/// Whether the best pose is beyond chance, where that was not asked of it before.
bool CliqueSearch::is_beyond_doubt() {
  if (best_.inliers == 0 || tested_ == best_.gain) return false;
  polish();
  tested_ = best_.gain;
  return is_beyond_chance(kClear);
}

void CliqueSearch::conclude(Consensus& best) {
  if (best_.inliers == 0) return;
  reconsider();
  polish();
  best.T_target_source = scorer_.uncentred(best_.T);
  best.false_alarms = false_alarm_test_.exact(best_.T);
  best.false_inliers = false_alarm_test_.false_inliers(best_.T);
  best.found = options_.best_effort || best.false_alarms < options_.max_false_alarms;
  best.mirrored = is_mirrored();
  best.found = best.found && !best.mirrored;
  const int beside = runner_up_.gain > 0 ? inliers_beside_best(runner_up_.T) : 0;
  if (!best.found || beside == 0 || 2 * beside < runner_up_.inliers) return;
  // The quick number is rather too large, which is enough for a second answer.
  const double false_alarms = false_alarm_test_.quick(runner_up_.T);
  if (false_alarms < kClearAtOnce) {
    best.runner_up = {beside, scorer_.uncentred(runner_up_.T), false_alarms};
  }
}

/// The clique in indices of the sample; empty if it is not worth a look.
std::vector<int> CliqueSearch::clique_of(EgoGraph& graph, const std::vector<int>& sample,
                                         std::size_t& largest) {
  std::vector<int> clique = graph.clique(kLargestClique);
  largest = std::max(largest, clique.size());
  // What is as large as the settled consensus' cliques is not all that matters any more.
  const std::size_t least = settled_ ? min_in_clique(sample.size()) : largest - 1;
  if (clique.size() < std::max<std::size_t>(3, std::min(least, kSurelyLarge - 1))) return {};
  for (int& vertex : clique) vertex = sample[static_cast<std::size_t>(vertex)];
  return clique;
}

/// Of a larger consensus than the settled one about as many pairs of a sample agree as its size
/// estimates; a clique holds part of them. Not more, as runners-up are smaller.
std::size_t CliqueSearch::min_in_clique(std::size_t sample_size) const {
  constexpr double kPart = 0.35;
  constexpr std::size_t kMost = 4;
  const double members = static_cast<double>(sample_size) * best_.inliers / scorer_.size();
  return std::min(kMost, static_cast<std::size_t>(kPart * members));
}

/// Whether, of so many seeds of one sample, one of a larger consensus would have come up 99 times
/// in 100, and the best pose is no accident.
bool CliqueSearch::exhausted(int seeds) {
  constexpr double kLog100 = 4.6;
  if (asked_ == best_.gain || seeds * best_.inliers < kLog100 * scorer_.size()) return false;
  asked_ = best_.gain;
  return is_beyond_chance(options_.max_false_alarms);
}

/// Whether the best pose is so good that it needs no other: beyond chance, and with as large a
/// share of all as the clique that it came from has of the sample, or nearly. A pose that is
/// right for a part, as along a line of right pairs, has less.
bool CliqueSearch::is_clear(const std::vector<int>& sample, const std::vector<int>& clique) {
  constexpr double kNearly = 0.3;
  const double share = static_cast<double>(clique.size()) / static_cast<double>(sample.size());
  if (best_.inliers < kNearly * share * scorer_.size()) return false;
  return sample.size() < kLargeSample ? quick_ < kClearAtOnce : is_beyond_chance(kClear);
}

/// @param nearby  of the sample, the pairs that are consistent with the clique's first one
/// @param share  of all pairs in the sample
/// @return whether the clique's pose is the best so far
bool CliqueSearch::propose(const std::vector<int>& clique, const PairColumns& nearby, double share,
                           Consensus& best) {
  ++best.hypotheses;
  Eigen::Isometry3d T = pose_of(clique);
  consider_mirror(clique, T);
  // Those nearby hold most of what agrees in the sample, and are few.
  const double wanted = std::min(kWorthRefining * best_.gain, min_of_runner_up());
  if (settled_ && scorer_.over(nearby).gain(T) < kNearby * share * wanted) return false;
  const double rough = scorer_.gain(T);
  // The first pose of a clique is rough: half of the best gain is worth a refinement.
  if (rough < kWorthRefining * best_.gain) {
    consider_runner_up(T, rough);
    return false;
  }
  const double gain = scorer_.descend(T);
  const Pose before = best_;
  const bool better = keep_if_best(T, gain);
  if (better && settled_) consider_runner_up(before.T, before.gain);
  if (!better) consider_runner_up(T, gain);
  return better;
}

/// A clique may fit a reflection better than any rotation, as that keeps lengths, too.
/// @param T  of the clique
void CliqueSearch::consider_mirror(const std::vector<int>& clique, const Eigen::Isometry3d& T) {
  constexpr std::size_t kInformative = 5;
  if (clique.size() < kInformative || !options_.turns.all()) return;
  Eigen::Isometry3d reflection = scorer_.align_mirrored(clique);
  if (scorer_.gain_of(clique, reflection) <= scorer_.gain_of(clique, T)) return;
  if (scorer_.gain(reflection) < 0.5 * mirrored_.gain) return;
  const double gain = scorer_.descend(reflection);
  if (gain > mirrored_.gain) mirrored_ = {reflection, gain, 0};
}

/// Whether chance explains neither the reflection nor its surplus over the best pose.
bool CliqueSearch::is_mirrored() {
  constexpr double kAccident = 0.01;
  if (!(mirrored_.gain > best_.gain)) return false;
  const std::vector<int> mirrored = scorer_.near(mirrored_.T, 1), best = scorer_.near(best_.T, 1);
  const auto surplus = static_cast<int>(without(mirrored, best).size()),
             deficit = static_cast<int>(without(best, mirrored).size());
  return sign_test(surplus, deficit) < kAccident &&
         false_alarm_test_.exact(mirrored_.T) < options_.max_false_alarms;
}

/// Of a rough pose.
double CliqueSearch::min_of_runner_up() const {
  constexpr double kMoreThanAccidents = 6;
  return std::max(kMoreThanAccidents, 0.5 * runner_up_.gain);
}

/// Another pose than the settled one, if its inliers are mostly others.
void CliqueSearch::consider_runner_up(const Eigen::Isometry3d& T, double gain) {
  if (!settled_ || gain < min_of_runner_up()) return;
  Pose pose{T, gain, 0};
  pose.gain = scorer_.descend(pose.T);
  pose.inliers = scorer_.score(pose.T).count;
  if (pose.gain > runner_up_.gain && 2 * inliers_beside_best(pose.T) >= pose.inliers) {
    runner_up_ = pose;
  }
}

int CliqueSearch::inliers_beside_best(const Eigen::Isometry3d& T) const {
  const std::vector<int> inliers = scorer_.near(T, 1), best = scorer_.near(best_.T, 1);
  return static_cast<int>(std::ranges::count_if(inliers, [&](int i) { return !holds(best, i); }));
}

bool CliqueSearch::keep_if_best(const Eigen::Isometry3d& T, double gain) {
  if (gain <= best_.gain) return false;
  best_ = {T, gain, scorer_.score(T).count};
  quick_ = false_alarm_test_.quick(T);
  return true;
}

/// Whether chance proposes a pose like the best less often than `level`, for all that is known at
/// little cost.
bool CliqueSearch::is_beyond_chance(double level) {
  if (quick_ < kClearAtOnce || quick_ > kHopeless) return quick_ < kClearAtOnce;
  const double rough = false_alarm_test_.estimate(best_.T, FalseAlarmTest::kRough);
  if (rough < kClearAtOnce || rough >= level) return rough < level;
  return false_alarm_test_.estimate(best_.T, FalseAlarmTest::kMedium) < level;
}

/// A part of a few inliers fits poses about the right one too: tries what becomes of the best one
/// with wider bounds, and with other inliers.
void CliqueSearch::polish() {
  constexpr int kFewInliers = 32, kFewer = 16, kMaxRounds = 4;
  if (best_.inliers > kFewInliers || polished_ == best_.gain) return;
  Eigen::Isometry3d wide = best_.T;
  for (const float reach : {3.0F, 1.7F}) scorer_.descend(wide, reach);
  const double widened = scorer_.descend(wide);
  keep_if_best(wide, widened);
  for (int round = 0; best_.inliers <= kFewer && round < kMaxRounds && exchange(); ++round) {
  }
  polished_ = best_.gain;
}

/// A part of the right pairs and some wrong ones may agree on a pose several degrees off: looks
/// around each inlier of a few, as most of them are right ones.
void CliqueSearch::reconsider() {
  constexpr int kFewInliers = 12;
  constexpr std::size_t kInformative = 4;
  if (best_.inliers > kFewInliers) return;
  EgoGraph graph(scorer_.columns(), kLengthTolerance, options_.normal_noise_deg);
  const std::vector<int> inliers = scorer_.near(best_.T, 1);
  for (const int inlier : inliers) {
    graph.look_around(inlier);
    const std::vector<int> clique = graph.clique(kLargestClique);
    const bool known = std::ranges::all_of(clique, [&](int i) { return holds(inliers, i); });
    if (known || clique.size() < kInformative) continue;
    Eigen::Isometry3d T = scorer_.align(clique);
    if (scorer_.gain(T) < kWorthRefining * best_.gain) continue;
    const double gain = scorer_.descend(T);
    keep_if_best(T, gain);
  }
}

/// Least squares after each correspondence near the best pose has joined the inliers or left
/// them; where there are very few, also after each two.
/// @return whether one is better
bool CliqueSearch::exchange() {
  constexpr std::size_t kMaxNear = 64, kVeryFew = 7;
  const std::vector<int> inliers = scorer_.near(best_.T, 1);
  std::vector<int> near = scorer_.near(best_.T, kNear);
  near.resize(std::min(near.size(), kMaxNear));
  bool better = false;
  for (std::size_t a = 0; a < near.size(); ++a) {
    better |= refine({near[a]}, inliers);
    if (inliers.size() > kVeryFew) continue;
    for (std::size_t b = a + 1; b < near.size(); ++b) better |= refine({near[a], near[b]}, inliers);
  }
  return better;
}

/// Starts from the inliers without those of `exchanged` (ascending) among them and with the rest.
bool CliqueSearch::refine(const std::vector<int>& exchanged, const std::vector<int>& inliers) {
  std::vector<int> changed;
  std::ranges::set_symmetric_difference(inliers, exchanged, std::back_inserter(changed));
  if (changed.size() < 3) return false;
  Eigen::Isometry3d T = scorer_.align(changed);
  const double gain = scorer_.descend(T);
  return keep_if_best(T, gain);
}

/// Least squares where a clique's pairs agree, else GNC on them.
Eigen::Isometry3d CliqueSearch::pose_of(const std::vector<int>& clique) const {
  constexpr std::size_t kSmall = 6;
  const Eigen::Isometry3d T = scorer_.align(clique);
  if (!options_.turns.all() || clique.size() <= kSmall ||
      scorer_.gain(T) >= 0.5 * static_cast<double>(clique.size())) {
    return T;
  }
  const GncResult gnc =
      graduated_non_convexity(subset(all_, clique), {.noise_bound = options_.noise_bound});
  return scorer_.centred(gnc.T_target_source);
}

}  // namespace palpate::registration
