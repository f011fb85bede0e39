# SPDX-License-Identifier: Apache-2.0
# OMPL::OMPL (motion planning) from Debian's libompl-dev, whose own configuration exports no target
# and asks for more than the planners need.
file(GLOB _folders /usr/include/ompl-* /usr/local/include/ompl-*)
find_path(OMPL_INCLUDE_DIR ompl/geometric/SimpleSetup.h HINTS ${OMPL_ROOT} ${_folders})
find_library(OMPL_LIBRARY NAMES ompl HINTS ${OMPL_ROOT})
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OMPL REQUIRED_VARS OMPL_LIBRARY OMPL_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "run ./dev build, which installs libompl-dev, or set OMPL_ROOT")
if(OMPL_FOUND AND NOT TARGET OMPL::OMPL)
  add_library(OMPL::OMPL UNKNOWN IMPORTED)
  set_target_properties(OMPL::OMPL PROPERTIES IMPORTED_LOCATION "${OMPL_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${OMPL_INCLUDE_DIR}")
endif()
