# SPDX-License-Identifier: Apache-2.0
# CoACD::CoACD (convex decomposition) from the Python wheel that ./dev installs; it ships no header.
file(GLOB _wheels "${PALPATE_DEPS}/venv/lib/python3*/site-packages/coacd")
find_library(CoACD_LIBRARY NAMES lib_coacd.so _coacd HINTS ${COACD_ROOT} ${_wheels})
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(CoACD REQUIRED_VARS CoACD_LIBRARY
  REASON_FAILURE_MESSAGE "run ./dev build, which installs the pinned wheel, or set COACD_ROOT")
if(CoACD_FOUND AND NOT TARGET CoACD::CoACD)
  add_library(CoACD::CoACD SHARED IMPORTED)
  set_target_properties(CoACD::CoACD PROPERTIES IMPORTED_LOCATION "${CoACD_LIBRARY}")
  # It exports the C++ runtime that it was linked with. The system's has to be found before: with two
  # of them, an exception that leaves another shared library ends the program.
  set_target_properties(CoACD::CoACD PROPERTIES INTERFACE_LINK_OPTIONS
    "SHELL:-Wl,--push-state,--no-as-needed -lstdc++ -lgcc_s -Wl,--pop-state")
endif()
