// SPDX-License-Identifier: Apache-2.0
#include "palpate/evaluation/belief_recorder.hpp"

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <utility>
#include <variant>

#include "palpate/core/error.hpp"
#include "palpate/evaluation/credible_poses.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/skills/explore/calibrate_phase.hpp"

namespace palpate::evaluation {
namespace {

using estimation::TouchEvent;

constexpr std::size_t kMaxPosesOfBelief = 60;  // of a belief
constexpr std::size_t kBefore = 20;            // readings of the grasp that is followed

/// What the thread is given: a reading, an event of the pick, or that nothing follows.
using Item = std::variant<hand::HandReading, TouchEvent, std::monostate>;

bool lets_go(TouchEvent event) {
  return event == TouchEvent::released || event == TouchEvent::opened ||
         event == TouchEvent::placed || event == TouchEvent::fallen;
}

/// Items from one thread to another.
class Queue {
 public:
  void push(Item item) {
    {
      const std::lock_guard lock(mutex_);
      items_.push_back(std::move(item));
    }
    changed_.notify_one();
  }
  Item pop() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !items_.empty(); });
    Item item = std::move(items_.front());
    items_.pop_front();
    return item;
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Item> items_;
};

}  // namespace

struct BeliefRecorder::Impl {
  const geometry::ObjectModel& object;
  hand::Description believed;  // before its calibration
  Options options;
  std::uint64_t seed;
  Observer observer;
  estimation::PoseEstimator estimator;
  estimation::EventLog log;
  std::optional<hand::Description> calibrated;
  std::optional<estimation::HeldPoseFollower> follower;
  std::vector<recording::BeliefRecord> beliefs;
  Queue queue;
  std::thread thread;

  Impl(const geometry::ObjectModel& known, const hand::Description& hand, const Options& chosen,
       std::uint64_t seeded, Observer given)
      : object(known),
        believed(hand),
        options(chosen),
        seed(seeded),
        observer(std::move(given)),
        estimator(known, chosen.pick.estimation, seeded) {}

  void run() {
    report(0, "prior", false, prior_poses(object.object(), options.pick.estimation));
    while (true) {
      const Item item = queue.pop();
      if (std::holds_alternative<std::monostate>(item)) return;
      if (const auto* reading = std::get_if<hand::HandReading>(&item)) update(*reading);
      if (const auto* event = std::get_if<TouchEvent>(&item)) note(*event);
    }
  }

  const hand::Description& hand() {
    if (!calibrated) {
      calibrated = skills::calibrated_hand(believed, log, options.pick.calibrate);
    }
    return *calibrated;
  }

  /// Where no pose is credible, what was believed before stays.
  void report(double time, const char* source, bool in_hand, std::vector<CrediblePose> poses) {
    if (poses.empty()) return;
    recording::BeliefRecord belief{.time = time, .source = source, .in_hand = in_hand, .poses = {}};
    for (const auto& pose : poses) {
      belief.poses.push_back({pose.probability, pose.T_frame_object});
    }
    beliefs.push_back(std::move(belief));
    if (observer) observer(beliefs.back());
  }

  void update(const hand::HandReading& reading) {
    log.readings.push_back(reading);
    if (!follower) return;
    follower->update(reading);
    if (!follower->due()) return;
    const auto task = follower->task();
    auto estimate = follower->estimate(task);
    const auto poses = credible_poses(estimate.posterior, kMaxPosesOfBelief);
    follower->accept(task, std::move(estimate));
    report(reading.time, "online", true, poses);
  }

  void note(TouchEvent event) {
    if (log.readings.empty()) return;
    const std::size_t present = log.readings.size() - 1;
    const double time = log.readings.back().time;
    log.moments.push_back({event, present});
    if (lets_go(event)) follower.reset();
    try {
      if (estimation::ends_guarded_move(event)) {
        report(time, "touch", false,
               credible_poses(estimator.resting(hand(), log), kMaxPosesOfBelief));
      } else if (is_grasp(event)) {
        const auto posterior = estimator.held(hand(), log, present).posterior;
        report(time, "grasp", true, credible_poses(posterior, kMaxPosesOfBelief));
        if (options.online) follow(posterior);
      }
    } catch (const BadInput&) {
      // What was sensed cannot be of this object; what was believed before stays.
    }
  }

  void follow(const localization::Posterior& posterior) {
    if (posterior.residual_mass() >= 1) return;
    follower.emplace(object, hand(), options.held, seed);
    const std::span<const hand::HandReading> readings(log.readings);
    for (const auto& reading : readings.last(std::min(readings.size(), kBefore))) {
      follower->update(reading);
    }
    follower->begin(posterior);
  }
};

BeliefRecorder::BeliefRecorder(const geometry::ObjectModel& object, const hand::Description& hand,
                               const Options& options, std::uint64_t seed, Observer observer)
    : impl_(new Impl(object, hand, options, seed, std::move(observer))) {
  impl_->thread = std::thread([impl = impl_.get()] { impl->run(); });
}

BeliefRecorder::~BeliefRecorder() {
  if (impl_->thread.joinable()) finish();
}

void BeliefRecorder::frame(const recording::Frame& frame) { impl_->queue.push(frame.reading); }

void BeliefRecorder::event(const recording::Event& event) {
  if (const auto touch = recording::touch_event_of(event)) impl_->queue.push(*touch);
}

std::vector<recording::BeliefRecord> BeliefRecorder::finish() {
  impl_->queue.push(std::monostate());
  impl_->thread.join();
  return std::move(impl_->beliefs);
}

}  // namespace palpate::evaluation
