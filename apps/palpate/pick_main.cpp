// SPDX-License-Identifier: Apache-2.0
// The program with its main command alone, which ./dev demo builds in less time than the whole.
#include <array>

#include "program.hpp"

int main(int argc, char** argv) {
  using namespace palpate::app;
  return run_program(std::array{add_pick}, argc, argv);
}
