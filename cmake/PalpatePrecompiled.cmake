# SPDX-License-Identifier: Apache-2.0
# Parsing the standard library, Eigen and fmt is most of what compiling a source costs, so they are
# parsed once. Sources still include what they use: -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON builds too.
add_library(palpate_precompiled OBJECT "${PROJECT_SOURCE_DIR}/cmake/precompiled.cpp")
target_link_libraries(palpate_precompiled PRIVATE Eigen3::Eigen fmt::fmt palpate_warnings)
set(PALPATE_PRECOMPILED_HEADERS
  <algorithm> <array> <cmath> <functional> <map> <memory> <numeric> <optional> <random> <span>
  <string> <string_view> <vector> <fmt/format.h>
  <Eigen/Cholesky> <Eigen/Core> <Eigen/Eigenvalues> <Eigen/Geometry> <Eigen/LU> <Eigen/QR> <Eigen/SVD>)
target_precompile_headers(palpate_precompiled PRIVATE ${PALPATE_PRECOMPILED_HEADERS})

# palpate_precompile(TARGET [FROM]): programs are compiled with -fPIC as the libraries are, not with
# -fPIE, for precompiled headers hold for one of them.
function(palpate_precompile target)
  set(from palpate_precompiled ${ARGN})
  list(GET from -1 from)
  target_precompile_headers(${target} REUSE_FROM ${from})
  get_target_property(type ${target} TYPE)
  if(type STREQUAL "EXECUTABLE")
    set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE OFF)
    target_compile_options(${target} PRIVATE -fPIC)
  endif()
endfunction()
