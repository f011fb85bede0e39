// SPDX-License-Identifier: Apache-2.0
#include "planning/sequential_prm.hpp"

#include <ompl/base/terminationconditions/IterationTerminationCondition.h>

namespace palpate::planning {

namespace ob = ompl::base;

void SequentialPrm::add_ends() {
  while (const ob::State* start = pis_.nextStart()) {
    startM_.push_back(addMilestone(si_->cloneState(start)));
  }
  while (const ob::State* goal = pis_.nextGoal()) {
    goalM_.push_back(addMilestone(si_->cloneState(goal)));
  }
}

ob::PlannerStatus SequentialPrm::solve(const ob::PlannerTerminationCondition& ended) {
  constexpr int kBatch = 20;  // tests of the condition between two looks for a path
  checkValidity();
  add_ends();
  if (startM_.empty()) return ob::PlannerStatus::INVALID_START;
  if (goalM_.empty()) return ob::PlannerStatus::INVALID_GOAL;
  ob::PathPtr path;
  while (!ended) {
    int left = kBatch;
    growRoadmap(ob::PlannerTerminationCondition([&] { return --left < 0 || ended(); }));
    if (!maybeConstructSolution(startM_, goalM_, path)) continue;
    pdef_->addSolutionPath(path, false, 0.0, getName());
    return ob::PlannerStatus::EXACT_SOLUTION;
  }
  return ob::PlannerStatus::TIMEOUT;
}

}  // namespace palpate::planning
