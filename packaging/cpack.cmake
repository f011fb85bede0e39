# SPDX-License-Identifier: Apache-2.0
# Read by cpack for every generator: what is installed is what was built, without another build.
set(CPACK_CMAKE_GENERATOR_PREINSTALL OFF)
