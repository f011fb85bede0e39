# SPDX-License-Identifier: Apache-2.0
# What find_package(palpate) needs. The wheels and assets stay where ./dev put them.
include(CMakePackageConfigHelpers)
set(destination lib/cmake/palpate)
install(EXPORT palpate NAMESPACE palpate:: FILE palpateTargets.cmake DESTINATION ${destination})
configure_package_config_file(cmake/palpateConfig.cmake.in palpateConfig.cmake
  INSTALL_DESTINATION ${destination} PATH_VARS PALPATE_DEPS)
write_basic_package_version_file(palpateConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/palpateConfig.cmake"
              "${PROJECT_BINARY_DIR}/palpateConfigVersion.cmake"
              cmake/FindMuJoCo.cmake cmake/FindCoACD.cmake cmake/FindOMPL.cmake
        DESTINATION ${destination})
