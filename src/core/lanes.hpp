// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace palpate {

/// Four numbers that the processor computes with at a time; of gcc and clang, on any machine.
using Floats4 = float __attribute__((vector_size(16)));
using Ints4 = std::int32_t __attribute__((vector_size(16)));

/// Each lane of `yes` where `where` is -1, of `no` where it is 0.
inline Ints4 chosen(Ints4 where, Ints4 yes, Ints4 no) { return (where & yes) | (~where & no); }

}  // namespace palpate
