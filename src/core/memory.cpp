// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/memory.hpp"

#include <cstdlib>  // which tells whether it is glibc
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace palpate {

void return_free_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace palpate
