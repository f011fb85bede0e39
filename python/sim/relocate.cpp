// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "bindings/arrays.hpp"
#include "bindings/without_gil.hpp"
#include "libraries.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/worker_pool.hpp"
#include "palpate/tasks/relocate/drawn_task.hpp"
#include "palpate/tasks/relocate/rollout.hpp"
#include "picture.hpp"
#include "sized_renderer.hpp"

namespace palpate::python {
namespace {

using namespace nb::literals;
using relocate::kRelocateJoints;
using relocate::kRelocateObservations;
using relocate::RelocateStep;

/// What can be set of the task and of how its episodes start.
struct RelocateOptions {
  relocate::TaskOptions task;
  relocate::EpisodeOptions episode;

  template <class Visitor>
  void visit(Visitor&& v) {
    task.visit(v);
    episode.visit(v);
  }
};

/// Copies of the relocate task that are stepped together, on several threads. Python's threads take
/// turns with them.
class RelocateTasks {
 public:
  RelocateTasks(std::size_t count, int threads, const RelocateOptions& options)
      : options_(options),
        model_(relocate::make_model(options.task)),
        pool_(threads),
        starts_(count),
        steps_(count),
        seconds_(count) {
    for (std::size_t i = 0; i < count; ++i) tasks_.emplace_back(model_);
    order_.resize(count);
    std::iota(order_.begin(), order_.end(), std::size_t{0});
  }
  RelocateTasks(const RelocateTasks&) = delete;
  RelocateTasks& operator=(const RelocateTasks&) = delete;

  void reset(std::size_t index, std::uint64_t seed) {
    const std::lock_guard lock(busy_);
    check_index(index);
    start(index, relocate::episode_start(options_.episode, seed));
  }

  void place(std::size_t index, const Eigen::Vector2d& object, const Eigen::Vector3d& target) {
    const std::lock_guard lock(busy_);
    check_index(index);
    relocate::RelocateStart placed = starts_[index];
    placed.object = object;
    placed.target = target;
    start(index, placed);
  }

  /// @param skipped  tasks that stay as they are
  ///
  /// What took longest in the step before is begun first, so that no thread has much left to do
  /// where the others have ended.
  void step(const Matrix& actions, const std::vector<bool>& skipped) {
    using Clock = std::chrono::steady_clock;
    const std::lock_guard lock(busy_);
    std::sort(order_.begin(), order_.end(),
              [&](std::size_t a, std::size_t b) { return seconds_[a] > seconds_[b]; });
    pool_.run(tasks_.size(), [&](std::size_t turn) {
      const std::size_t i = order_[turn];
      const Clock::time_point begin = Clock::now();
      if (skipped[i]) {
        steps_[i].reward = 0;
      } else {
        steps_[i] = tasks_[i].step(actions.row(static_cast<Eigen::Index>(i)));
      }
      seconds_[i] = std::chrono::duration<double>(Clock::now() - begin).count();
    });
  }

  simulation::Image render(std::size_t index, int width, int height) {
    const std::lock_guard lock(busy_);
    check_index(index);
    if (!drawn_) drawn_.emplace(options_.task, model_);
    auto& renderer = renderer_.of(width, height, drawn_->hand(), drawn_->object());
    return renderer.render(drawn_->at(tasks_[index].positions(), starts_[index].target),
                           relocate::task_camera());
  }

  /// One row a task of what `of` returns for it.
  template <class Of>
  Matrix rows_of(int width, const Of& of) const {
    const auto lock = turn();
    Matrix result(static_cast<Eigen::Index>(tasks_.size()), width);
    for (std::size_t i = 0; i < tasks_.size(); ++i) {
      result.row(static_cast<Eigen::Index>(i)) = of(i).transpose();
    }
    return result;
  }

  /// While it is held, no other thread steps the tasks.
  [[nodiscard]] std::unique_lock<std::mutex> turn() const { return std::unique_lock(busy_); }

  [[nodiscard]] const std::vector<relocate::RelocateTask>& tasks() const { return tasks_; }
  [[nodiscard]] const std::vector<relocate::RelocateStart>& starts() const { return starts_; }
  [[nodiscard]] const std::vector<RelocateStep>& steps() const { return steps_; }
  [[nodiscard]] const relocate::TaskOptions& task_options() const { return options_.task; }
  [[nodiscard]] int horizon() const { return options_.episode.horizon; }
  [[nodiscard]] int threads() const { return pool_.threads(); }

 private:
  void check_index(std::size_t index) const {
    if (index < tasks_.size()) return;
    throw std::out_of_range(fmt::format("there is no task {} of {}", index, tasks_.size()));
  }

  void start(std::size_t index, const relocate::RelocateStart& start) {
    tasks_[index].reset(start);
    starts_[index] = start;
    steps_[index] = {};
    const Eigen::Vector3d object = tasks_[index].positions().segment<3>(kRelocateJoints);
    steps_[index].distance = (object - start.target).norm();
  }

  RelocateOptions options_;
  relocate::RelocateModel model_;
  WorkerPool pool_;
  std::vector<relocate::RelocateTask> tasks_;
  std::vector<relocate::RelocateStart> starts_;
  std::vector<RelocateStep> steps_;
  std::vector<double> seconds_;     // that each took in its last step
  std::vector<std::size_t> order_;  // in which they are begun
  std::optional<relocate::DrawnTask> drawn_;
  SizedRenderer renderer_;
  mutable std::mutex busy_;
};

void make(RelocateTasks* self, int count, int threads, const nb::dict& settings) {
  if (count < 1) throw BadInput(fmt::format("count must be at least 1, not {}", count));
  if (threads < 1) throw BadInput(fmt::format("threads must be at least 1, not {}", threads));
  RelocateOptions options;
  apply_settings(settings, options);
  const WithoutGil release;
  new (self) RelocateTasks(static_cast<std::size_t>(count), threads, options);
}

void step(RelocateTasks& self, nb::object actions, nb::object skipped) {
  const Matrix rows = matrix_from(actions, "actions");
  const auto count = self.tasks().size();
  if (rows.rows() != static_cast<Eigen::Index>(count) || rows.cols() != kRelocateJoints) {
    throw BadInput(fmt::format("actions has shape ({}, {}), not ({}, {})", rows.rows(), rows.cols(),
                               count, kRelocateJoints));
  }
  std::vector<bool> idle(count, false);
  if (is_given(skipped)) {
    const auto values = numbers_from(skipped, count, "skipped");
    for (std::size_t i = 0; i < count; ++i) idle[i] = values[i] != 0;
  }
  const WithoutGil release;
  self.step(rows, idle);
}

/// A number of each task's last step.
template <class Number>
auto of_steps(Number RelocateStep::*member) {
  return [member](const RelocateTasks& self) {
    const auto lock = self.turn();
    Eigen::Vector<Number, Eigen::Dynamic> result(static_cast<Eigen::Index>(self.steps().size()));
    for (Eigen::Index i = 0; i < result.size(); ++i) {
      result[i] = self.steps()[static_cast<std::size_t>(i)].*member;
    }
    return result;
  };
}

void bind_states(nb::class_<RelocateTasks>& tasks) {
  tasks
      .def_prop_ro(
          "observations",
          [](const RelocateTasks& self) {
            return self.rows_of(kRelocateObservations,
                                [&](std::size_t i) { return self.tasks()[i].observation(); });
          },
          "(N, 39): 30 joint positions (m, rad); palm - object; palm - target; object - target, m, "
          "world axes. The object's place is off by object_bias, and late by observation_period.")
      .def_prop_ro(
          "velocities",
          [](const RelocateTasks& self) {
            return self.rows_of(kRelocateJoints, [&](std::size_t i) {
              return self.tasks()[i].proprioception().velocity;
            });
          },
          "Of the joints, (N, 30), m/s and rad/s.")
      .def_prop_ro(
          "positions",
          [](const RelocateTasks& self) {
            return self.rows_of(static_cast<int>(self.tasks()[0].positions().size()),
                                [&](std::size_t i) { return self.tasks()[i].positions(); });
          },
          "The truth, (N, 37): joints, then the object's place (m) and quaternion (w, x, y, z).")
      .def_prop_ro(
          "targets",
          [](const RelocateTasks& self) {
            return self.rows_of(3, [&](std::size_t i) { return self.starts()[i].target; });
          },
          "Where the objects are to go, (N, 3), m.")
      .def_prop_ro("rewards", of_steps(&RelocateStep::reward), "Of the last step, (N,).")
      .def_prop_ro("distances", of_steps(&RelocateStep::distance),
                   "Of the object from its target after the last step, (N,), m.")
      .def_prop_ro("contacts", of_steps(&RelocateStep::contact),
                   "Whether hand and object touched in the last step, (N,).")
      .def_prop_ro("diverged", of_steps(&RelocateStep::diverged),
                   "Whether the physics failed in the last step, (N,).");
}

}  // namespace

void bind_relocate(nb::module_& module) {
  nb::class_<RelocateTasks> tasks(
      module, "RelocateTasks",
      "Copies of the relocate task, stepped together on several threads without the GIL: the "
      "Adroit hand brings an object from a table to a target in the air (Rajeswaran et al. "
      "2018).");
  tasks
      .def("__init__", &make, "count"_a = 1, nb::kw_only(), "threads"_a = 1,
           "options"_a = nb::dict(),
           nb::sig("def __init__(self, count: int = 1, *, threads: int = 1, options: dict[str, "
                   "typing.Any] = {}) -> None"),
           "options: those of `palpate options rollout` about the task and its episodes, as "
           "{'object': 'box', 'solver': 'fast', 'scale_high': 1.0}.\n\nRaises ValueError for a "
           "count or threads below 1, for what there is not, and values out of their range.")
      .def("reset", &RelocateTasks::reset, "index"_a, "seed"_a, nb::call_guard<WithoutGil>(),
           "Starts a task as the episode seed % 2^20 of the rollouts' seed seed / 2^20.\n\nRaises "
           "IndexError for no task of that index.")
      .def(
          "place",
          [](RelocateTasks& self, std::size_t index, nb::object object, nb::object target) {
            const auto xy = numbers_from(object, 2, "object");
            self.place(index, {xy[0], xy[1]}, vector_from(target, "target"));
          },
          "index"_a, nb::kw_only(), "object"_a, "target"_a,
          nb::sig("def place(self, index: int, *, object: numpy.typing.ArrayLike, target: "
                  "numpy.typing.ArrayLike) -> None"),
          "Starts a task with the object's frame at (2,), m on the table, and its target at (3,), "
          "m.\n\nRaises ValueError for values that are not finite, IndexError for no such task.")
      .def("step", &step, "actions"_a, "skipped"_a = nb::none(),
           nb::sig("def step(self, actions: numpy.typing.ArrayLike, skipped: "
                   "numpy.typing.ArrayLike | None = None) -> None"),
           "One control step of 10 ms of each task: actions (N, 30), -1..1 over the actuators' "
           "ranges; skipped (N,): true where a task stays as it is.\n\nRaises ValueError for "
           "another shape. An action that is not finite makes its task diverge.")
      .def(
          "render",
          [](RelocateTasks& self, std::size_t index, int width, int height) {
            return array_of([&] {
              const WithoutGil release;
              return self.render(index, width, height);
            }());
          },
          "index"_a, "width"_a = 480, "height"_a = 360,
          nb::sig("def render(self, index: int, width: int = 480, height: int = 360) -> "
                  "numpy.typing.NDArray[numpy.uint8]"),
          "A picture of a task as it is, (height, width, 3), the object see-through at its target, "
          "too; the hand is drawn as the Shadow hand that the Adroit hand models.\n\nRaises "
          "ValueError for a size that is not within 16..4096 pixels, and where nothing here draws "
          "without a screen; IndexError for no task of that index.")
      .def_prop_ro("horizon", &RelocateTasks::horizon, "Steps of an episode.")
      .def("__len__", [](const RelocateTasks& self) { return self.tasks().size(); })
      .def("__repr__", [](const RelocateTasks& self) {
        return fmt::format("RelocateTasks({} of '{}', {} threads)", self.tasks().size(),
                           self.task_options().object, self.threads());
      });
  bind_states(tasks);
}

}  // namespace palpate::python
