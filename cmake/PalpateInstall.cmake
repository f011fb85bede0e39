# SPDX-License-Identifier: Apache-2.0
# What is installed: the program with the wheels' libraries and the assets that it reads, and for
# find_package(palpate COMPONENTS ...) the libraries, each of them a component that requires the
# packages that it and the libraries it uses need.
include(CMakePackageConfigHelpers)
include(GNUInstallDirs)
set(destination ${CMAKE_INSTALL_LIBDIR}/cmake/palpate)
set(package_of_hdf5 HDF5)
set(PALPATE_COMPONENTS "")
foreach(library ${PALPATE_LIBRARIES})
  get_target_property(links palpate_${library} LINK_LIBRARIES)
  set(libraries "")
  set(packages "")
  foreach(link ${links})
    if(link MATCHES "^palpate_([a-z0-9]+)$")
      list(APPEND libraries ${CMAKE_MATCH_1})
    elseif(link MATCHES "^([A-Za-z0-9_]+)::")
      set(package ${CMAKE_MATCH_1})
      if(DEFINED package_of_${package})
        set(package ${package_of_${package}})
      endif()
      list(APPEND packages ${package})
    endif()
  endforeach()
  list(REMOVE_DUPLICATES packages)
  string(APPEND PALPATE_COMPONENTS "set(palpate_${library}_libraries \"${libraries}\")\nset(palpate_${library}_packages \"${packages}\")\n")
  install(EXPORT palpate-${library} NAMESPACE palpate:: DESTINATION ${destination}
          COMPONENT development)
endforeach()

configure_package_config_file(cmake/palpateConfig.cmake.in palpateConfig.cmake
  INSTALL_DESTINATION ${destination} PATH_VARS CMAKE_INSTALL_LIBDIR)
write_basic_package_version_file(palpateConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/palpateConfig.cmake"
              "${PROJECT_BINARY_DIR}/palpateConfigVersion.cmake"
              cmake/FindMuJoCo.cmake cmake/FindCoACD.cmake cmake/FindOMPL.cmake
        DESTINATION ${destination} COMPONENT development)

get_target_property(mujoco_headers MuJoCo::MuJoCo INTERFACE_INCLUDE_DIRECTORIES)
set(libraries ${CMAKE_INSTALL_LIBDIR}/palpate)
install(FILES "$<TARGET_FILE:MuJoCo::MuJoCo>" DESTINATION ${libraries} COMPONENT program)
# CoACD's wheel has what it needs in a folder beside its own.
install(FILES "$<TARGET_FILE:CoACD::CoACD>" DESTINATION ${libraries}/coacd COMPONENT program)
install(DIRECTORY "$<TARGET_FILE_DIR:CoACD::CoACD>/../coacd.libs" DESTINATION ${libraries}
        COMPONENT program OPTIONAL)
install(DIRECTORY "${mujoco_headers}/mujoco" DESTINATION ${libraries}/include
        COMPONENT development)
# The bunny is not for commercial use, so it is not passed on.
install(DIRECTORY "${PALPATE_DEPS}/assets" DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate
        COMPONENT program PATTERN "bunny.ply" EXCLUDE)
install(DIRECTORY ros2/palpate_ros2/launch DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate_ros2
        COMPONENT ros2)
install(FILES ros2/palpate_ros2/package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/palpate_ros2
        COMPONENT ros2)

# Every package has its licence, and the program's those of what the wheels and npm brought.
set(doc_of_program palpate)
set(doc_of_development libpalpate-dev)
set(doc_of_ros2 palpate-ros2)
foreach(component program development ros2)
  install(FILES LICENSE packaging/copyright
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${doc_of_${component}} COMPONENT ${component})
endforeach()
file(GLOB site "${PALPATE_DEPS}/venv/lib/python3*/site-packages")
set(licences ${CMAKE_INSTALL_DATADIR}/doc/palpate/licences)
function(install_licences name)
  file(GLOB files ${ARGN})
  install(FILES ${files} DESTINATION ${licences}/${name} COMPONENT program)
endfunction()
install_licences(mujoco "${site}/mujoco-*.dist-info/licenses/*")
install_licences(coacd "${site}/coacd-*.dist-info/LICENSE")
install_licences(shadow_hand "${PALPATE_DEPS}/assets/shadow_hand/LICENSE")
install_licences(adroit_hand "${site}/gymnasium_robotics/envs/assets/LICENSE.md"
                 "${site}/gymnasium_robotics-*.dist-info/licenses/LICENSE")
install_licences(three "${PALPATE_DEPS}/node_modules/three/LICENSE")
