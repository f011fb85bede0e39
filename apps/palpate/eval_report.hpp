// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "palpate/evaluation/evaluation.hpp"
#include "trial_records.hpp"

namespace palpate::app {

/// What to do with the command that repeats the first trial.
std::string repetition_text(const std::string& command);

/// What an evaluation prints: a table, a row as each object ends, or one JSON object at the end.
class EvalReport {
 public:
  EvalReport(const EvalPlan& plan, bool json);

  /// One more trial of the object that is next.
  void add(const evaluation::Trial& trial);
  /// The next object has ended.
  void end_object(evaluation::ObjectSummary summary);
  /// Prints what is left. @return what the file eval.json holds
  nlohmann::json finish();

 private:
  EvalPlan plan_;
  bool json_;
  std::size_t name_width_ = 10;
  nlohmann::json report_;
  std::vector<evaluation::ObjectSummary> summaries_;
  evaluation::ObjectSummary all_;
};

}  // namespace palpate::app
