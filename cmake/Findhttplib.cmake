# SPDX-License-Identifier: Apache-2.0
# httplib::httplib from Debian's package, which has no CMake config.
find_path(httplib_INCLUDE_DIR httplib.h)
find_library(httplib_LIBRARY NAMES cpp-httplib)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(httplib REQUIRED_VARS httplib_LIBRARY httplib_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "install cpp-httplib (Debian: libcpp-httplib-dev)")
if(httplib_FOUND AND NOT TARGET httplib::httplib)
  add_library(httplib::httplib UNKNOWN IMPORTED)
  set_target_properties(httplib::httplib PROPERTIES IMPORTED_LOCATION "${httplib_LIBRARY}"
    INTERFACE_INCLUDE_DIRECTORIES "${httplib_INCLUDE_DIR}" INTERFACE_LINK_LIBRARIES Threads::Threads)
endif()
