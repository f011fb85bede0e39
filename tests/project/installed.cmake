# SPDX-License-Identifier: Apache-2.0
# Installs, builds the example against what was installed, without what its component must not ask
# for, and runs both, the program from where it does not find the checkout.
set(work "${BUILD}/installed")
file(REMOVE_RECURSE "${work}")

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${work}/prefix")
foreach(package MuJoCo CoACD OMPL NLopt HDF5 PNG nlohmann_json Boost)
  list(APPEND without -DCMAKE_DISABLE_FIND_PACKAGE_${package}=ON)
endforeach()
run("${CMAKE_COMMAND}" -S "${SOURCE}/examples/library" -B "${work}/example" -G "${GENERATOR}"
    "-DCMAKE_PREFIX_PATH=${work}/prefix" -DCMAKE_BUILD_TYPE=Release ${without})
run("${CMAKE_COMMAND}" --build "${work}/example")
run("${work}/example/locate_by_touch")

# The readme's lines of C++.
file(READ "${SOURCE}/README.md" readme)
string(FIND "${readme}" "```cpp\n" begin)
string(SUBSTRING "${readme}" ${begin} -1 readme)
string(SUBSTRING "${readme}" 7 -1 readme)
string(FIND "${readme}" "```" end)
string(SUBSTRING "${readme}" 0 ${end} snippet)
string(FIND "${snippet}" "\n\n" body)
string(SUBSTRING "${snippet}" 0 ${body} head)
string(SUBSTRING "${snippet}" ${body} -1 body)
file(WRITE "${work}/readme/main.cpp" "${head}\nint main() {${body}}\n")
file(WRITE "${work}/readme/CMakeLists.txt"
     "cmake_minimum_required(VERSION 3.25)\nproject(readme LANGUAGES CXX)\n"
     "find_package(palpate REQUIRED COMPONENTS localization)\n"
     "add_executable(readme main.cpp)\n"
     "target_link_libraries(readme PRIVATE palpate::localization)\n")
run("${CMAKE_COMMAND}" -S "${work}/readme" -B "${work}/readme/build" -G "${GENERATOR}"
    "-DCMAKE_PREFIX_PATH=${work}/prefix" -DCMAKE_BUILD_TYPE=Release ${without})
run("${CMAKE_COMMAND}" --build "${work}/readme/build")
run("${work}/readme/build/readme" WORKING_DIRECTORY "${SOURCE}")

# Each of these is a product of its own, and runs without a trace of the simulator.
foreach(component registration tactile localization)
  set(build "${work}/component-${component}")
  run("${CMAKE_COMMAND}" -S "${SOURCE}/tests/project/component" -B "${build}" -G "${GENERATOR}"
      "-DCMAKE_PREFIX_PATH=${work}/prefix" "-DCOMPONENT=${component}" ${without})
  run("${CMAKE_COMMAND}" --build "${build}")
  run("${build}/component")
  execute_process(COMMAND ldd "${build}/component" OUTPUT_VARIABLE libraries
                  COMMAND_ERROR_IS_FATAL ANY)
  if(libraries MATCHES "mujoco|coacd|ompl|nlopt|hdf5")
    message(FATAL_ERROR "a program on ${component} needs more than it should:\n${libraries}")
  endif()
endforeach()

set(program "${work}/prefix/bin/palpate")
execute_process(COMMAND ldd "${program}" OUTPUT_VARIABLE libraries COMMAND_ERROR_IS_FATAL ANY)
string(REPLACE "${work}" "" libraries "${libraries}")
if(libraries MATCHES "not found" OR libraries MATCHES "${SOURCE}")
  message(FATAL_ERROR "the installed program needs libraries of the checkout:\n${libraries}")
endif()
execute_process(COMMAND "${program}" doctor --json OUTPUT_VARIABLE doctor COMMAND_ERROR_IS_FATAL ANY)
string(FIND "${doctor}" "${work}/prefix/share/palpate/assets" found)
if(found EQUAL -1)
  message(FATAL_ERROR "the installed program does not read its own assets:\n${doctor}")
endif()
