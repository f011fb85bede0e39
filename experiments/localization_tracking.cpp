// SPDX-License-Identifier: Apache-2.0
// Tracking an object that moves with the fingertips, with a slip half way.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "experiment.hpp"
#include "palpate/core/parallel.hpp"
#include "palpate/core/plot.hpp"
#include "palpate/core/statistics.hpp"
#include "palpate/geometry/mesh_query.hpp"
#include "palpate/localization/grasp_scene.hpp"
#include "palpate/localization/tracker.hpp"

namespace {

using namespace palpate;
using namespace palpate::localization;

constexpr double kDegree = M_PI / 180;
constexpr double kTick = 0.01;                                           // s
constexpr double kTurning = 20 * kDegree, kMoving = 0.02;                // rms a second
constexpr double kMotionTime = 1.0, kSlideTime = 0.5, kNoiseTime = 0.5;  // s, correlation
constexpr double kVelocityNoise = 0.002;                                 // m/s per axis
constexpr double kPointNoise = 0.001, kNormalNoise = 0.1745;
constexpr double kStartAngle = 3 * kDegree, kStartWay = 0.003;
constexpr double kSlipWay = 0.005, kSlipAngle = 10 * kDegree;

struct Setting {
  std::string name;
  double sliding;   // rms m/s of a fingertip on the surface
  bool correlated;  // half of the noise's variance keeps for .5 s, else all is white
  bool slip;
};

struct Subject {
  explicit Subject(const std::string& name)
      : model(geometry::load_known_object(name)), mesh(model.object().mesh) {}
  ObjectModel model;
  geometry::MeshQuery mesh;
};

/// A random vector that keeps for a while (Ornstein-Uhlenbeck), of unit variance per axis.
class Wandering {
 public:
  explicit Wandering(double time, RandomStream& random) : keep_(std::exp(-kTick / time)) {
    value_ = random.normal3();
  }
  const Eigen::Vector3d& next(RandomStream& random) {
    value_ = keep_ * value_ + std::sqrt(1 - keep_ * keep_) * random.normal3();
    return value_;
  }

 private:
  double keep_;
  Eigen::Vector3d value_;
};

/// A fingertip on the moving object.
struct Fingertip {
  Eigen::Vector3d p, n;  // in the object's frame
  Wandering slide, point_error, normal_error;
};

class MovingObject {
 public:
  MovingObject(const Subject& subject, const Setting& setting, RandomStream random)
      : subject_(subject),
        setting_(setting),
        random_(random),
        turning_(kMotionTime, random_),
        moving_(kMotionTime, random_) {
    T_.linear() = random_.rotation();
    place_fingertips();
  }

  TrackFrame next(double time) {
    const double axis = 1 / std::sqrt(3.0);
    const Eigen::Vector3d w = axis * kTurning * turning_.next(random_);
    const Eigen::Vector3d v = axis * kMoving * moving_.next(random_);
    T_.linear() = exp_so3(kTick * w) * T_.linear();
    T_.translation() += kTick * v;
    TrackFrame frame;
    frame.time = time;
    for (Fingertip& tip : tips_) {
      Eigen::Vector3d slide = setting_.sliding / std::sqrt(2.0) * tip.slide.next(random_);
      slide -= slide.dot(tip.n) * tip.n;
      settle(tip, tip.p + kTick * slide);
      const Eigen::Vector3d p = T_ * tip.p;
      frame.contacts.push_back(felt(tip));
      frame.velocities.push_back(v + w.cross(p - T_.translation()) + T_.linear() * slide +
                                 kVelocityNoise * random_.normal3());
    }
    return frame;
  }

  void slip() {
    std::vector<Eigen::Vector3d> held;
    for (const Fingertip& tip : tips_) held.push_back(T_ * tip.p);
    T_.linear() = exp_so3(kSlipAngle * random_.unit_vector()) * T_.linear();
    T_.translation() += kSlipWay * random_.unit_vector();
    for (std::size_t i = 0; i < tips_.size(); ++i) settle(tips_[i], T_.inverse() * held[i]);
  }

  const Eigen::Isometry3d& truth() const { return T_; }

 private:
  /// Five spread over the surface.
  void place_fingertips() {
    const auto& surface = subject_.model.surface();
    std::vector<Eigen::Vector3d> chosen;
    for (int i = 0; i < 5; ++i) {
      Eigen::Vector3d best = surface[random_.index(surface.size())].p.cast<double>();
      double most = -1;
      for (int attempt = 0; attempt < 8; ++attempt) {
        const Eigen::Vector3d p = surface[random_.index(surface.size())].p.cast<double>();
        double least = 1;
        for (const auto& other : chosen) least = std::min(least, (p - other).norm());
        if (least <= most) continue;
        most = least;
        best = p;
      }
      chosen.push_back(best);
      Fingertip tip{best,
                    {},
                    Wandering(kSlideTime, random_),
                    Wandering(kNoiseTime, random_),
                    Wandering(kNoiseTime, random_)};
      settle(tip, best);
      tips_.push_back(tip);
    }
  }

  void settle(Fingertip& tip, const Eigen::Vector3d& near) const {
    const auto closest = subject_.mesh.closest_point(near);
    tip.p = closest.point;
    tip.n = closest.normal;
  }

  touch::Contact felt(Fingertip& tip) {
    touch::Contact contact;
    const double share = setting_.correlated ? std::sqrt(0.5) : 1.0;
    const double kept = setting_.correlated ? std::sqrt(0.5) : 0.0;
    contact.p = T_ * tip.p;
    contact.n = T_.linear() * tip.n;
    const Eigen::Vector3d tilt = kept * tip.normal_error.next(random_) + share * random_.normal3();
    const Eigen::Vector3d across = tilt - tilt.dot(contact.n) * contact.n;
    contact.n = (contact.n + kNormalNoise * across).normalized();
    contact.p += kPointNoise * (kept * tip.point_error.next(random_) + share * random_.normal3());
    return contact;
  }

  const Subject& subject_;
  Setting setting_;
  RandomStream random_;
  Wandering turning_, moving_;
  Eigen::Isometry3d T_ = Eigen::Isometry3d::Identity();
  std::vector<Fingertip> tips_;
};

struct Run {
  std::vector<PoseError> errors;
  std::vector<double> seconds;
  int slips_before = 0, slips_after = 0;  // found before and after the true one
};

bool within(const PoseError& error) {
  return error.rotation < 5 * kDegree && error.translation < 0.01;
}

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

Run run_one(const Subject& subject, const Setting& setting, double seconds, RandomStream random) {
  MovingObject object(subject, setting, random.fork("object"));
  Tracker tracker(subject.model, rough_start(object.truth(), random));
  Run run;
  const int frames = static_cast<int>(seconds / kTick);
  for (int k = 0; k < frames; ++k) {
    if (setting.slip && k == frames / 2) object.slip();
    if (k == frames / 2) run.slips_before = tracker.slips();
    const auto& posterior = tracker.update(object.next(k * kTick));
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

LineSeries median_error(const std::string& name, const std::vector<Run>& runs) {
  LineSeries line{name, {}, {}};
  for (std::size_t k = 0; k < runs.front().errors.size(); k += 2) {
    std::vector<double> errors;
    for (const Run& run : runs) errors.push_back(run.errors[k].rotation / kDegree);
    line.x.push_back(static_cast<double>(k) * kTick);
    line.y.push_back(median(errors));
  }
  return line;
}

void tracking(const experiment::Options& options) {
  const double seconds = options.quick ? 1.0 : 8.0;
  const std::size_t count = options.quick ? 1 : 20;
  const std::vector<Setting> settings = {{"white noise, slide 1 mm/s", 0.001, false, false},
                                         {"correlated, slide 1 mm/s", 0.001, true, false},
                                         {"correlated, slide 5 mm/s", 0.005, true, false},
                                         {"correlated, slip 5 mm 10 deg", 0.001, true, true}};
  experiment::Table table({"object", "setting", "share within 5 deg, 10 mm", "at .2 s after",
                           "at 1 s after", "false alarms a second", "slips found",
                           "step us (median, p99)"});
  Plot plot;
  plot.title = "Rotation error, slip of 5 mm and 10 deg at 4 s";
  plot.x = {"time (s)", false, {}, {}};
  plot.y = {"median rotation error (deg)", false, 0.0, {}};
  const auto objects =
      options.quick ? std::vector<std::string>{"box"} : geometry::built_in_objects();
  for (const auto& name : objects) {
    const Subject subject(name);
    for (const Setting& setting : settings) {
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
  experiment::publish_figure(options, "tracking", to_svg(plot));
}

}  // namespace

int main(int argc, char** argv) {
  return experiment::run(argc, argv, "localization_tracking",
                         "Tracking of an object that moves with the fingertips, with a slip",
                         tracking);
}
