# SPDX-License-Identifier: Apache-2.0
# MuJoCo::MuJoCo from the Python wheel that ./dev installs, or from MUJOCO_ROOT.
file(GLOB _wheels "${PALPATE_DEPS}/venv/lib/python3*/site-packages/mujoco")
find_path(MuJoCo_INCLUDE_DIR mujoco/mujoco.h HINTS ${MUJOCO_ROOT} ${_wheels} PATH_SUFFIXES include)
file(GLOB _libraries ${MUJOCO_ROOT}/libmujoco.so.* ${_wheels}/libmujoco.so.*)
find_library(MuJoCo_LIBRARY NAMES mujoco HINTS ${MUJOCO_ROOT} PATH_SUFFIXES lib)
if(NOT MuJoCo_LIBRARY AND _libraries)
  list(GET _libraries 0 MuJoCo_LIBRARY)
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(MuJoCo REQUIRED_VARS MuJoCo_LIBRARY MuJoCo_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "run ./dev build, which installs the pinned wheel, or set MUJOCO_ROOT")
if(MuJoCo_FOUND AND NOT TARGET MuJoCo::MuJoCo)
  add_library(MuJoCo::MuJoCo SHARED IMPORTED)
  set_target_properties(MuJoCo::MuJoCo PROPERTIES IMPORTED_LOCATION "${MuJoCo_LIBRARY}"
    INTERFACE_SYSTEM_INCLUDE_DIRECTORIES "${MuJoCo_INCLUDE_DIR}"
    INTERFACE_INCLUDE_DIRECTORIES "${MuJoCo_INCLUDE_DIR}")
endif()
