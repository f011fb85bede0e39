// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace palpate::simulation {

/// The simulator prints its warnings and logs them to a file, MUJOCO_LOG.TXT in the working folder,
/// unless the process has a handler: from the first call on it has one that passes them to the
/// thread's Warnings, if any.
void silence_warnings();

/// What the simulator says, which may be several lines, in one.
std::string one_line(std::string text);

/// Collects the simulator's warnings of this thread while it lives.
class Warnings {
 public:
  Warnings();
  ~Warnings();
  Warnings(const Warnings&) = delete;
  Warnings& operator=(const Warnings&) = delete;

  const std::vector<std::string>& texts() const { return texts_; }

 private:
  std::vector<std::string> texts_;
  std::vector<std::string>* outer_;
};

}  // namespace palpate::simulation
