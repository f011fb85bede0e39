// SPDX-License-Identifier: Apache-2.0
#include "planning/search.hpp"

#include <ompl/base/ScopedState.h>
#include <ompl/base/spaces/RealVectorStateSpace.h>
#include <ompl/geometric/PathSimplifier.h>
#include <ompl/geometric/planners/fmt/FMT.h>
#include <ompl/geometric/planners/rrt/RRTConnect.h>
#include <ompl/geometric/planners/rrt/RRTstar.h>
#include <ompl/util/Console.h>
#include <ompl/util/RandomNumbers.h>

#include <algorithm>
#include <mutex>

#include "planning/sequential_prm.hpp"

namespace palpate::planning {
namespace {

namespace ob = ompl::base;
namespace og = ompl::geometric;

constexpr double kExtension = 0.15;      // m of path, that a tree grows by at once
constexpr int kImprovements = 500;       // iterations of RRT* after its first path
constexpr unsigned int kSamples = 1000;  // of FMT
// Of FMT: its number of neighbours grows with (2 radius)^dimensions; the default of 1.1 would make
// all samples neighbours of each other in the 26 dimensions of mount and Shadow hand, this makes it
// ten to forty.
constexpr double kFmtRadius = 0.58;
constexpr int kFmtTests = 10;  // of its end, an iteration: it also tests it while it samples

/// The moving coordinates as a real vector, in metres of path so that its norm is our distance.
class Chart {
 public:
  Chart(const Coordinates& fixed, const SearchSpace& space, const Coordinates& metric)
      : fixed_(fixed),
        metric_(metric),
        space_(space),
        states_(std::make_shared<ob::RealVectorStateSpace>(
            static_cast<unsigned int>(space.moving.size()))) {
    ob::RealVectorBounds bounds(static_cast<unsigned int>(space.moving.size()));
    for (std::size_t i = 0; i < space.moving.size(); ++i) {
      const int k = space.moving[i];
      bounds.low[i] = space.low[k] * metric_[k];
      bounds.high[i] = space.high[k] * metric_[k];
    }
    states_->setBounds(bounds);
  }

  [[nodiscard]] const std::shared_ptr<ob::RealVectorStateSpace>& states() const { return states_; }

  [[nodiscard]] Coordinates configuration(const ob::State* state) const {
    const double* values = state->as<ob::RealVectorStateSpace::StateType>()->values;
    Coordinates result = fixed_;
    for (std::size_t i = 0; i < space_.moving.size(); ++i) {
      const int k = space_.moving[i];
      result[k] = values[i] / metric_[k];
    }
    return result;
  }

  [[nodiscard]] ob::ScopedState<> state(const Coordinates& configuration) const {
    ob::ScopedState<> result(states_);
    for (std::size_t i = 0; i < space_.moving.size(); ++i) {
      const int k = space_.moving[i];
      result[static_cast<unsigned int>(i)] = configuration[k] * metric_[k];
    }
    states_->enforceBounds(result.get());  // a value at its limit may be over it by rounding
    return result;
  }

 private:
  Coordinates fixed_, metric_;
  const SearchSpace& space_;
  std::shared_ptr<ob::RealVectorStateSpace> states_;
};

ob::SpaceInformationPtr space_information(const Chart& chart, FreeSpace& free) {
  auto space = std::make_shared<ob::SpaceInformation>(chart.states());
  space->setStateValidityChecker(
      [&](const ob::State* state) { return free.holds(chart.configuration(state)); });
  chart.states()->setup();
  space->setStateValidityCheckingResolution(
      std::min(1.0, free.step() / std::max(space->getMaximumExtent(), free.step())));
  space->setup();
  return space;
}

ob::PlannerPtr make_planner(PlannerKind kind, const ob::SpaceInformationPtr& space) {
  switch (kind) {
    case PlannerKind::rrt_star: {
      auto planner = std::make_shared<og::RRTstar>(space);
      planner->setRange(kExtension);
      return planner;
    }
    case PlannerKind::prm:
      return std::make_shared<SequentialPrm>(space);
    case PlannerKind::fmt: {
      auto planner = std::make_shared<og::FMT>(space);
      planner->setNumSamples(kSamples);
      planner->setRadiusMultiplier(kFmtRadius);
      return planner;
    }
    case PlannerKind::rrt_connect:
      break;
  }
  auto planner = std::make_shared<og::RRTConnect>(space);
  planner->setRange(kExtension);
  return planner;
}

/// Ends a search after so many iterations; one that improves its path goes on for a while after
/// the first.
ob::PlannerTerminationCondition bounded(const ob::ProblemDefinitionPtr& problem, int iterations) {
  auto left = std::make_shared<int>(iterations);
  problem->setIntermediateSolutionCallback([left](const ob::Planner*, const auto&, ob::Cost) {
    *left = std::min(*left, kImprovements);
  });
  return ob::PlannerTerminationCondition([left] { return --*left < 0; });
}

std::vector<Coordinates> vertices(const Chart& chart, const Coordinates& metric,
                                  og::PathGeometric& path) {
  std::vector<Coordinates> result;
  for (const ob::State* state : path.getStates()) {
    const Coordinates vertex = chart.configuration(state);
    constexpr double kSamePath = 1e-9;  // m of path
    if (result.empty() || distance(result.back(), vertex, metric) > kSamePath)
      result.push_back(vertex);
  }
  return result;
}

}  // namespace

std::vector<Coordinates> search(const Coordinates& start, const Coordinates& goal, FreeSpace& free,
                                const SearchSpace& space, const PathSearchOptions& options,
                                std::uint64_t seed) {
  // All of OMPL's generators take their seeds from one, so only one search may run at a time; and
  // reseeding that one is reported as an error, although each search makes its generators again.
  static std::mutex one_at_a_time;
  const std::scoped_lock lock(one_at_a_time);
  ompl::msg::noOutputHandler();
  ompl::RNG::setSeed(static_cast<std::uint_fast32_t>((seed & 0x7fffffff) | 1));

  const Chart chart(start, space, free.metric());
  const auto information = space_information(chart, free);
  const auto problem = std::make_shared<ob::ProblemDefinition>(information);
  problem->setStartAndGoalStates(chart.state(start), chart.state(goal));
  const auto planner = make_planner(options.planner, information);
  planner->setProblemDefinition(problem);
  planner->setup();
  const int tests = options.iterations * (options.planner == PlannerKind::fmt ? kFmtTests : 1);
  if (planner->solve(bounded(problem, tests)) != ob::PlannerStatus::EXACT_SOLUTION) {
    return {};
  }
  auto& path = *problem->getSolutionPath()->as<og::PathGeometric>();
  if (options.shortenings > 0) {
    og::PathSimplifier simplifier(information);
    const auto trials = static_cast<unsigned int>(options.shortenings);
    simplifier.reduceVertices(path, trials, trials);
    simplifier.shortcutPath(path, trials, trials);
  }
  return vertices(chart, free.metric(), path);
}

}  // namespace palpate::planning
