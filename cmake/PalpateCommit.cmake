# SPDX-License-Identifier: Apache-2.0
# cmake -DSOURCE=folder -DOUT=file -P PalpateCommit.cmake: a source file that tells the commit of the
# folder, "-dirty" where it has been changed since, or "unknown" where git knows nothing of it.
execute_process(COMMAND git -C "${SOURCE}" describe --always --dirty --abbrev=12 --exclude=*
                OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT commit)
  set(commit unknown)
endif()
file(CONFIGURE OUTPUT "${OUT}" CONTENT [[
// Made by cmake/PalpateCommit.cmake.
#include "manifest.hpp"

namespace palpate::app {

std::string_view commit() { return "@commit@"; }

}  // namespace palpate::app
]] @ONLY)
