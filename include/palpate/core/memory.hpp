// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace palpate {

/// Gives freed memory back to the system where the C library can (glibc), so that a process that
/// works for hours stays as small as what it uses.
void return_free_memory();

}  // namespace palpate
