// SPDX-License-Identifier: Apache-2.0
#include "simulation/hand/warnings.hpp"

#include <mujoco/mujoco.h>

#include <algorithm>
#include <mutex>

namespace palpate::simulation {
namespace {

thread_local std::vector<std::string>* collected = nullptr;

}  // namespace

void silence_warnings() {
  static std::once_flag silenced;
  std::call_once(silenced, [] {
    if (mju_user_warning) return;
    mju_user_warning = [](const char* text) {
      if (collected) collected->emplace_back(text);
    };
  });
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

Warnings::Warnings() : outer_(collected) {
  silence_warnings();
  collected = &texts_;
}

Warnings::~Warnings() { collected = outer_; }

}  // namespace palpate::simulation
