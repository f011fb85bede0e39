// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ompl/geometric/planners/prm/PRM.h>

namespace palpate::planning {

/// A probabilistic roadmap that looks for the path itself, every so many milestones. OMPL's own
/// looks from a second thread every millisecond, so that its answer depends on the machine.
class SequentialPrm : public ompl::geometric::PRM {
 public:
  using PRM::PRM;

  ompl::base::PlannerStatus solve(const ompl::base::PlannerTerminationCondition& ended) override;

 private:
  void add_ends();
};

}  // namespace palpate::planning
