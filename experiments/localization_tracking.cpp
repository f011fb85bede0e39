// SPDX-License-Identifier: Apache-2.0
// Tracking an object that moves with the fingertips, with a slip half way.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiment.hpp"
#include "moving_object.hpp"
#include "palpate/core/angle.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/localization/tracking/tracker.hpp"
#include "palpate/plotting/plot.hpp"

namespace {

using namespace palpate;
using namespace palpate::localization;
using experiment::kFrame;
using experiment::MovingObject;
using experiment::Subject;
using experiment::TouchSetting;

constexpr double kStartAngle = 3 * kDegree, kStartWay = 0.003;

struct Run {
  std::vector<PoseError> errors;
  std::vector<double> seconds;
  int slips_before = 0, slips_after = 0;  // found before and after the true one
};

Posterior rough_start(const Eigen::Isometry3d& truth, RandomStream& random) {
  Posterior start;
  Mode mode;
  mode.T_frame_object = truth;
  mode.T_frame_object.linear() =
      exp_so3(kStartAngle / std::sqrt(3.0) * random.normal3()) * truth.linear();
  mode.T_frame_object.translation() += kStartWay / std::sqrt(3.0) * random.normal3();
  mode.weight = 1;
  mode.covariance.diagonal() << Eigen::Vector3d::Constant(kStartAngle * kStartAngle / 3),
      Eigen::Vector3d::Constant(kStartWay * kStartWay / 3);
  start.modes.push_back(mode);
  return start;
}

Run run_one(const Subject& subject, const TouchSetting& setting, double seconds,
            RandomStream random) {
  MovingObject object(subject, setting, random.fork("object"));
  Tracker tracker(subject.model, rough_start(object.truth(), random));
  Run run;
  const int frames = static_cast<int>(seconds / kFrame);
  for (int k = 0; k < frames; ++k) {
    if (setting.slip && k == frames / 2) object.slip();
    if (k == frames / 2) run.slips_before = tracker.slips();
    const auto& posterior = tracker.update(object.next(k * kFrame));
    run.seconds.push_back(posterior.seconds);
    run.errors.push_back(pose_error(posterior.modes.front().T_frame_object, object.truth(),
                                    subject.model.object().symmetries));
  }
  run.slips_after = tracker.slips() - run.slips_before;
  return run;
}

double share_within(const std::vector<Run>& runs, std::size_t first, std::size_t last) {
  double count = 0, good = 0;
  for (const Run& run : runs) {
    for (std::size_t k = first; k < std::min(last, run.errors.size()); ++k) {
      ++count;
      good += within(run.errors[k]);
    }
  }
  return good / count;
}

plotting::LineSeries median_error(const std::string& name, const std::vector<Run>& runs) {
  plotting::LineSeries line{name, {}, {}};
  for (std::size_t k = 0; k < runs.front().errors.size(); k += 2) {
    std::vector<double> errors;
    for (const Run& run : runs) errors.push_back(run.errors[k].rotation / kDegree);
    line.x.push_back(static_cast<double>(k) * kFrame);
    line.y.push_back(median(errors));
  }
  return line;
}

void tracking(const experiment::Options& options) {
  const double seconds = options.quick ? 1.0 : 8.0;
  const std::size_t count = options.quick ? 1 : 100;
  const std::vector<TouchSetting> settings = {{"white noise, slide 1 mm/s", 0.001, false, false},
                                              {"correlated, slide 1 mm/s", 0.001, true, false},
                                              {"correlated, slide 5 mm/s", 0.005, true, false},
                                              {"correlated, slip 5 mm 10 deg", 0.001, true, true}};
  experiment::Table table({"object", "setting", "share within 5 deg, 10 mm", "at .2 s after",
                           "at 1 s after", "false alarms a second", "slips found",
                           "step us (median, p99)"});
  plotting::Plot plot;
  plot.title = "Rotation error, slip of 5 mm and 10 deg at 4 s";
  plot.x = {"time (s)", false, {}, {}};
  plot.y = {"median rotation error (deg)", false, 0.0, {}};
  const auto objects =
      options.quick ? std::vector<std::string>{"box"} : geometry::built_in_objects();
  for (const auto& name : objects) {
    const Subject subject(name);
    for (const TouchSetting& setting : settings) {
      std::vector<Run> runs(count);
      parallel_for(count, options.threads, [&](std::size_t i) {
        runs[i] = run_one(subject, setting, seconds,
                          RandomStream(options.seed + i, "tracking " + setting.name));
      });
      std::vector<double> steps;
      double alarms = 0, found = 0;
      for (const Run& run : runs) {
        alarms += run.slips_before + (setting.slip ? 0 : run.slips_after);
        found += setting.slip && run.slips_after > 0;
        steps.insert(steps.end(), run.seconds.begin(), run.seconds.end());
      }
      const auto frames = runs.front().errors.size(), half = frames / 2;
      const double watched = static_cast<double>(count) * seconds * (setting.slip ? 0.5 : 1.0);
      const auto runs_count = static_cast<double>(count);
      const auto at = [&](std::size_t k) {
        return setting.slip ? fmt::format("{:.2f}", share_within(runs, half + k, half + k + 1))
                            : std::string("-");
      };
      table.add_row(
          {name, setting.name, fmt::format("{:.2f}", share_within(runs, 0, frames)), at(20),
           at(std::min<std::size_t>(100, half - 1)), fmt::format("{:.2f}", alarms / watched),
           setting.slip ? fmt::format("{:.2f}", found / runs_count) : "-",
           fmt::format("{:.0f}, {:.0f}", 1e6 * median(steps), 1e6 * quantile(steps, 0.99))});
      if (setting.slip) plot.series.push_back(median_error(name, runs));
    }
    fmt::print(stderr, "{} done\n", name);
  }
  table.publish(options, "tracking", "Tracking at 100 Hz, 5 contacts, 2 cm/s and 20 deg/s rms");
  experiment::publish_figure(options, "tracking", plotting::to_svg(plot));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "localization_tracking",
                         "Tracking of an object that moves with the fingertips, with a slip",
                         tracking);
}
