// SPDX-License-Identifier: Apache-2.0
// The relocation policy fed with an estimated place of the object instead of the true one.
#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "experiment.hpp"
#include "palpate/core/assets.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/learning/policy_io.hpp"
#include "palpate/learning/rollout.hpp"

namespace {

using namespace palpate;
using namespace palpate::learning;
using Eigen::Vector3d;

constexpr int kHorizon = 99;
constexpr int kPalmFromObject = 30, kPalmFromTarget = 33, kObjectFromTarget = 36;  // in the 39
constexpr double kLifting = 0.005;  // m that the palm has risen since its lowest: it carries

/// How well the object's place is known, on the table and in the hand; standard deviations per
/// axis, m. The prior is uniform within +- `prior`, in x and y alone.
struct Knowledge {
  std::string name;
  double prior = 0;     ///< half width before the hand touches it
  double on_table = 0;  ///< deviation after exploring it there by touch; used where prior is 0
  double in_hand = -1;  ///< of the estimate made when the grasp lifts; negative: none is made
  bool knows = false;   ///< is told the truth
};

/// The object's place as a hand could know it: a prior, then an estimate in the grasp that goes
/// with the palm. The palm's place, the target and whether the hand touches are all it looks at;
/// the errors stand for those of the localizer.
class Belief {
 public:
  Belief(const Knowledge& knowledge, const Vector3d& object, RandomStream random)
      : knowledge_(knowledge), random_(random), place_(object) {
    place_.head<2>() += knowledge.on_table * random_.normal3().head<2>();
    place_.x() += random_.uniform(-knowledge.prior, knowledge.prior);
    place_.y() += random_.uniform(-knowledge.prior, knowledge.prior);
  }

  /// @param object  the truth, of which an estimate in the hand is made, with its error
  void update(const Vector3d& palm, bool touches, const Vector3d& object) {
    if (!palm_) palm_ = palm;
    lowest_ = std::min(lowest_, palm.z());
    const bool carries = touches && palm.z() > lowest_ + kLifting;
    if (carries && !carrying_ && knowledge_.in_hand >= 0) {
      place_ = object + knowledge_.in_hand * random_.normal3();
    } else if (carries) {
      place_ += palm - *palm_;
    }
    carrying_ = carrying_ || carries;
    palm_ = palm;
  }

  const Vector3d& place() const { return place_; }

 private:
  Knowledge knowledge_;
  RandomStream random_;
  Vector3d place_;
  std::optional<Vector3d> palm_;
  double lowest_ = 1;
  bool carrying_ = false;
};

struct Result {
  Episode episode;
  double place_error = 0;  // m, of the belief at the end
};

Result run_one(const simulation::RelocateModel& model, const Policy& policy,
               const Knowledge& knowledge, std::uint64_t seed, std::size_t index) {
  simulation::RelocateTask task(model);
  const auto start = episode_start({}, seed, index);
  task.reset(start);
  Result result;
  std::optional<Belief> belief;
  bool touches = false;
  for (int i = 0; i < kHorizon && !result.episode.diverged; ++i) {
    PolicyInput input{task.observation(), task.proprioception()};
    auto& o = input.observation;
    const Vector3d palm = o.segment<3>(kPalmFromTarget) + start.target;
    const Vector3d object = o.segment<3>(kObjectFromTarget) + start.target;
    if (!belief) {
      belief.emplace(knowledge, object, RandomStream(seed, "belief").fork("episode", index));
    }
    belief->update(palm, touches, object);
    result.place_error = (belief->place() - object).norm();
    if (!knowledge.knows) {
      o.segment<3>(kPalmFromObject) = palm - belief->place();
      o.segment<3>(kObjectFromTarget) = belief->place() - start.target;
    }
    const auto step = task.step(policy.act(input));
    touches = step.contact;
    ++result.episode.steps;
    result.episode.total += step.reward;
    result.episode.diverged = step.diverged;
    result.episode.distance = step.diverged ? 1.0 : step.distance;
    result.episode.steps_within_5cm += result.episode.distance < 0.05;
  }
  return result;
}

void relocate(const experiment::Options& options) {
  const std::vector<Knowledge> all = {
      {"true place", 0, 0, -1, true},
      {"felt on the table (2 mm), then carried by the palm", 0, 0.002, -1, false},
      {"felt on the table (2 mm), estimated in the grasp (4 mm)", 0, 0.002, 0.004, false},
      {"prior +-20 mm, estimated in the grasp (4 mm)", 0.02, 0, 0.004, false},
      {"prior +-20 mm, then carried by the palm", 0.02, 0, -1, false},
      {"prior +-20 mm, estimated in the grasp (10 mm)", 0.02, 0, 0.010, false}};
  const std::size_t count = options.quick ? 2 : 100;
  const auto model = make_model({});
  const auto policy = load_policy(asset("models/relocate-near.json"));
  experiment::Table table({"what the policy is told", "episodes", "return", "< 5 cm", "< 2 cm",
                           "final distance mm (median)", "error of what it is told mm (median)"});
  for (const Knowledge& knowledge : all) {
    std::vector<Result> results(count);
    parallel_for(count, options.threads, [&](std::size_t i) {
      results[i] = run_one(model, *policy, knowledge, options.seed, i);
    });
    std::vector<Episode> episodes;
    std::vector<double> errors;
    for (const Result& result : results) {
      episodes.push_back(result.episode);
      errors.push_back(1e3 * result.place_error);
    }
    const RolloutSummary summary = summarize(episodes);
    table.add_row({knowledge.name, fmt::format("{}", count),
                   fmt::format("{:.0f} +- {:.0f}", summary.mean, summary.sd),
                   fmt::format("{:.2f}", summary.success_5cm),
                   fmt::format("{:.2f}", summary.success_2cm),
                   fmt::format("{:.0f}", 1e3 * summary.median_distance),
                   fmt::format("{:.1f}", knowledge.knows ? 0.0 : median(errors))});
  }
  table.publish(options, "relocate_estimated",
                "Relocation with an estimated place of the object, relocate-near, faithful solver");
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "relocate_estimated",
                         "The relocation policy with an estimated place of the object", relocate);
}
