# SPDX-License-Identifier: Apache-2.0
# Debian packages by CPack: palpate (the program), libpalpate-dev (the libraries and their headers)
# and palpate-ros2 (the launch file). ./dev deb makes them; packaging/try_packages.py tries them.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "tactile-only 6-DoF pose estimation and manipulation")
set(CPACK_PACKAGE_CONTACT "The Palpate authors <palpate@example.org>")
set(CPACK_COMPONENTS_ALL program development ros2)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_PROJECT_CONFIG_FILE "${PROJECT_SOURCE_DIR}/packaging/cpack.cmake")

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME palpate)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS "libegl1, libgl1-mesa-dri, libopengl0")
foreach(library MuJoCo CoACD)  # of wheels, and part of the package
  get_target_property(file ${library}::${library} IMPORTED_LOCATION)
  cmake_path(GET file PARENT_PATH folder)
  list(APPEND CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${folder}" "${folder}.libs")
endforeach()
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION
    "Simulated hands find, grasp, lift and place an object by touch alone, and
report a posterior over its pose. MuJoCo and CoACD are included.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libpalpate-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libeigen3-dev, libfmt-dev, libtomlplusplus-dev, libqhull-dev")
# A component beyond estimation asks for more, and links what the program's package brings.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "palpate (= ${PROJECT_VERSION}), libhdf5-dev, \
nlohmann-json3-dev, libompl-dev, libnlopt-dev, libpng-dev, cyclonedds-dev, libzstd-dev, liblz4-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
    "Static libraries, headers and find_package(palpate COMPONENTS ...) for
registration, localization, tactile sensing and what is built upon them.")

set(CPACK_DEBIAN_ROS2_PACKAGE_NAME palpate-ros2)
set(CPACK_DEBIAN_ROS2_PACKAGE_SECTION science)
set(CPACK_DEBIAN_ROS2_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_ROS2_PACKAGE_DEPENDS "palpate (= ${PROJECT_VERSION})")
set(CPACK_COMPONENT_ROS2_DESCRIPTION
    "The package palpate_ros2 with its launch file, below /usr/share. The program
speaks with ROS 2 nodes by itself and needs no ROS to be installed.")
include(CPack)
