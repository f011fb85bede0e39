// SPDX-License-Identifier: Apache-2.0
#include "palpate/skills/phase.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <string>

#include "palpate/hand/tip_forces.hpp"

namespace palpate::skills {
namespace {

double peak_force_since(const estimation::EventLog& log, std::size_t first) {
  double peak = 0;
  for (std::size_t i = first; i < log.readings.size(); ++i) {
    for (int finger = 0; finger < std::ssize(log.readings[i].contacts); ++finger) {
      peak = std::max(peak, hand::tip_force(log.readings[i], finger));
    }
  }
  return peak;
}

/// Whatever a phase or the user's code throws, the hand is not left with its last command.
PhaseEnd run_safely(Phase& phase, Executor& robot, PickState& state) {
  try {
    return phase.run(robot, state);
  } catch (const SafetyStop& stop) {
    return {false, stop.what()};
  } catch (const Unreachable& error) {
    return {false, std::string("unreachable: ") + error.what(), true};
  } catch (const std::exception& error) {
    robot.make_safe(Fault::exception, error.what());
    throw;
  } catch (...) {
    robot.make_safe(Fault::exception, "an unknown exception");
    throw;
  }
}

}  // namespace

std::string_view to_string(PhaseStatus status) {
  switch (status) {
    case PhaseStatus::ok:
      return "ok";
    case PhaseStatus::failed:
      return "failed";
    case PhaseStatus::timed_out:
      return "timed out";
    case PhaseStatus::fault:
      return "fault";
  }
  return "";
}

PhaseReport run_phase(Phase& phase, Executor& robot, PickState& state) {
  const auto wall_start = std::chrono::steady_clock::now();
  const double start = robot.time();
  const std::size_t first = robot.log().readings.size();
  robot.set_deadline(start + phase.time_limit());
  const PhaseEnd end = run_safely(phase, robot, state);
  const bool late = robot.time() >= start + phase.time_limit();
  robot.set_deadline(std::numeric_limits<double>::infinity());

  PhaseReport report;
  report.name = phase.name();
  report.status = robot.fault() ? PhaseStatus::fault
                  : late        ? PhaseStatus::timed_out
                  : end.ok      ? PhaseStatus::ok
                                : PhaseStatus::failed;
  report.outcome = end.outcome;
  report.unreachable = end.unreachable;
  report.robot_seconds = robot.time() - start;
  report.wall_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - wall_start).count();
  report.contacts = hand::count_contacts(robot.reading());
  report.peak_force = peak_force_since(robot.log(), first);
  return report;
}

}  // namespace palpate::skills
