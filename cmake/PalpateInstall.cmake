# SPDX-License-Identifier: Apache-2.0
# What is installed: the program with the wheels' libraries and the assets that it reads, and for
# find_package(palpate COMPONENTS room...) the libraries, each room a component that asks for the
# packages that it and the rooms below it need.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)
set(destination ${CMAKE_INSTALL_LIBDIR}/cmake/palpate)
set(package_of_hdf5 HDF5)
set(PALPATE_COMPONENTS "")
foreach(room ${PALPATE_ROOMS})
  get_target_property(links palpate_${room} LINK_LIBRARIES)
  set(rooms "")
  set(packages "")
  foreach(link ${links})
    if(link MATCHES "^palpate_([a-z0-9]+)$")
      list(APPEND rooms ${CMAKE_MATCH_1})
    elseif(link MATCHES "^([A-Za-z0-9_]+)::")
      set(package ${CMAKE_MATCH_1})
      if(DEFINED package_of_${package})
        set(package ${package_of_${package}})
      endif()
      list(APPEND packages ${package})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES packages)
  string(APPEND PALPATE_COMPONENTS "set(palpate_${room}_rooms \"${rooms}\")\nset(palpate_${room}_packages \"${packages}\")\n")
  install(EXPORT palpate-${room} NAMESPACE palpate:: DESTINATION ${destination})
endforeach()

configure_package_config_file(cmake/palpateConfig.cmake.in palpateConfig.cmake
  INSTALL_DESTINATION ${destination} PATH_VARS CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(palpateConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/palpateConfig.cmake"
              "${PROJECT_BINARY_DIR}/palpateConfigVersion.cmake"
              cmake/FindMuJoCo.cmake cmake/FindCoACD.cmake cmake/FindOMPL.cmake
        DESTINATION ${destination})

get_target_property(mujoco_headers MuJoCo::MuJoCo INTERFACE_INCLUDE_DIRECTORIES)
set(libraries ${CMAKE_INSTALL_LIBDIR}/palpate)
install(FILES "$<TARGET_FILE:MuJoCo::MuJoCo>" DESTINATION ${libraries})
# CoACD's wheel has what it needs in a folder beside its own.
install(FILES "$<TARGET_FILE:CoACD::CoACD>" DESTINATION ${libraries}/coacd)
install(DIRECTORY "$<TARGET_FILE_DIR:CoACD::CoACD>/../coacd.libs" DESTINATION ${libraries} OPTIONAL)
install(DIRECTORY "${mujoco_headers}/mujoco" DESTINATION ${libraries}/include)
# The bunny is not for commercial use, so it is not passed on.
install(DIRECTORY "${PALPATE_DEPS}/assets" DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate
        PATTERN "bunny.ply" EXCLUDE)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
