# SPDX-License-Identifier: Apache-2.0
# Installs the libraries, builds the example against what was installed, and runs it.
set(work "${BUILD}/installed")
file(REMOVE_RECURSE "${work}")

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

run("${CMAKE_COMMAND}" --install "${BUILD}" --prefix "${work}/prefix")
run("${CMAKE_COMMAND}" -S "${SOURCE}/examples/library" -B "${work}/example" -G "${GENERATOR}"
    "-DCMAKE_PREFIX_PATH=${work}/prefix" -DCMAKE_BUILD_TYPE=Release)
run("${CMAKE_COMMAND}" --build "${work}/example")
run("${work}/example/locate_by_touch")
run("${work}/prefix/bin/palpate" --version)
