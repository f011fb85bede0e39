// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/option_check.hpp"
#include "palpate/estimation/held_pose_follower.hpp"
#include "shared_model.hpp"
#include "without_gil.hpp"

namespace palpate::python {
namespace {

using namespace nanobind::literals;
namespace nb = nanobind;
using estimation::HeldPoseOptions;
using hand::HandReading;

void check_count(const char* what, std::size_t read, int has) {
  if (read == static_cast<std::size_t>(has)) return;
  throw BadInput(fmt::format("{} {} in the reading, the hand has {}", read, what, has));
}

bool is_finite(const hand::TipContact& contact) {
  return contact.p.allFinite() && contact.n.allFinite() && contact.f.allFinite();
}

void check_values(const HandReading& reading) {
  bool finite = std::isfinite(reading.time) && reading.joints.allFinite() &&
                reading.torques.allFinite() && reading.mount.xyz.allFinite() &&
                reading.mount.ypr.allFinite() && reading.mount_force.allFinite();
  for (const auto& finger : reading.contacts) {
    for (const auto& contact : finger) finite = finite && is_finite(contact);
  }
  if (!finite) throw BadInput(fmt::format("the reading at {} s is not finite", reading.time));
}

/// The follower with what its posteriors show; one thread may update it while another estimates.
class Follower {
 public:
  Follower(SharedModel model, const hand::Description& hand, const HeldPoseOptions& options,
           std::uint64_t seed)
      : model_(std::move(model)), hand_(hand), follower_(*model_, hand, options, seed) {}

  void update(const HandReading& reading) {
    check_count("joints", static_cast<std::size_t>(reading.joints.size()), hand_.joint_count());
    check_count("torques", static_cast<std::size_t>(reading.torques.size()),
                hand_.actuator_count());
    check_count("fingers", reading.contacts.size(), hand_.finger_count());
    check_values(reading);
    const std::lock_guard lock(busy_);
    if (last_ && !(reading.time > *last_)) {
      throw BadInput(
          fmt::format("the reading at {} s is not later than {} s", reading.time, *last_));
    }
    follower_.update(reading);
    last_ = reading.time;
  }

  void begin(const Posterior& posterior) {
    if (posterior.found.modes.empty()) throw BadInput("the posterior has no modes");
    require_same_object(posterior, *model_);
    const std::lock_guard lock(busy_);
    require_reading();
    follower_.begin(posterior.found);
  }

  Posterior estimate() {
    std::unique_lock lock(busy_);
    require_reading();
    const auto task = follower_.task();
    lock.unlock();
    auto found = follower_.estimate(task);
    Posterior result{found.posterior, model_};
    lock.lock();
    follower_.accept(task, std::move(found));
    return result;
  }

  bool due() {
    const std::lock_guard lock(busy_);
    return follower_.due();
  }

  Posterior posterior() {
    const std::lock_guard lock(busy_);
    return {follower_.posterior(), model_};
  }

  void forget() {
    const std::lock_guard lock(busy_);
    follower_.forget();
  }

  [[nodiscard]] std::string repr() const {
    return fmt::format("HeldPoseFollower('{}' in '{}')", model_->object().name, hand_.name);
  }

 private:
  void require_reading() const {
    if (!last_) throw BadInput("no reading yet: update() comes first");
  }

  SharedModel model_;
  hand::Description hand_;
  estimation::HeldPoseFollower follower_;
  std::mutex busy_;
  std::optional<double> last_;  ///< s, of the last reading
};

void make(Follower* self, nb::object model, const hand::Description& hand, double period,
          int fingers, double lost_after, std::uint64_t seed) {
  HeldPoseOptions options;
  options.period = period;
  options.fingers = fingers;
  options.lost_after = lost_after;
  new (self) Follower(model_from(std::move(model)), hand, checked(options), seed);
}

}  // namespace

void bind_estimation(nb::module_& module) {
  const HeldPoseOptions options;
  nb::class_<Follower>(module, "HeldPoseFollower",
                       "The pose of what a hand holds, from its readings alone. Between estimates "
                       "the object goes with the palm while fingers touch it. One thread may "
                       "update it while another estimates.")
      .def("__init__", &make, "model"_a, "hand"_a, nb::kw_only(), "period"_a = options.period,
           "fingers"_a = options.fingers, "lost_after"_a = options.lost_after, "seed"_a = 0,
           nb::sig("def __init__(self, model: ObjectModel, hand: HandDescription, *, period: float "
                   "= 0.1, fingers: int = 2, lost_after: float = 0.5, seed: int = 0) -> None"),
           "Nothing is known yet.\n\nperiod: s from one estimate to the next; fingers: that must "
           "touch for one; lost_after: s with fewer, after which nothing is known any "
           "more.\n\nRaises ValueError for numbers out of range.")
      .def("update", &Follower::update, "reading"_a, nb::call_guard<WithoutGil>(),
           "Takes a reading, one a tick, which takes microseconds.\n\nRaises ValueError for a "
           "reading of another hand, one that is not finite, and one that is not later than the "
           "one before.")
      .def_prop_ro("due", &Follower::due,
                   "Whether enough fingers touch, and the last estimate is a period old.")
      .def("estimate", &Follower::estimate, nb::call_guard<WithoutGil>(),
           "Estimates the pose at the last reading, in the world, and goes on from it, unless no "
           "pose explains the contacts; a fraction of a second where the pose is known, else a "
           "search.\n\nRaises ValueError before the first reading.")
      .def("begin", &Follower::begin, "posterior"_a, nb::call_guard<WithoutGil>(),
           "The pose is known at the last reading, in the world: that of localize() in that frame, "
           "say.\n\nRaises ValueError for a posterior without modes or of another object, and "
           "before the first reading.")
      .def_prop_ro("posterior", &Follower::posterior,
                   "At the last reading, in the world; 'no_pose' where nothing is known.")
      .def("forget", &Follower::forget, "Nothing is known any more.")
      .def("__repr__", &Follower::repr);
}

}  // namespace palpate::python
