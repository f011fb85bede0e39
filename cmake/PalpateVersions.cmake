# SPDX-License-Identifier: Apache-2.0
# The least versions of Debian's packages: those of Debian 12, with which all was tested. Older ones
# lack functions that are used or bounds that the loaders rely on (docs/loaders.md).
function(palpate_require name version least)
  if(NOT version)
    message(STATUS "the version of ${name} is not known; ${least} or newer is needed")
  elseif(version VERSION_LESS least)
    message(FATAL_ERROR "${name} ${version} is too old: ${least} or newer is needed")
  endif()
endfunction()

palpate_require(Eigen3 "${Eigen3_VERSION}" 3.4.0)
palpate_require(fmt "${fmt_VERSION}" 9.1.0)
palpate_require(nlohmann_json "${nlohmann_json_VERSION}" 3.11.2)
palpate_require(toml++ "${tomlplusplus_VERSION}" 3.3.0)
palpate_require(HDF5 "${HDF5_VERSION}" 1.10.8)
palpate_require(Boost "${Boost_VERSION_STRING}" 1.74.0)
palpate_require(PNG "${PNG_VERSION_STRING}" 1.6.39)
palpate_require(NLopt "${NLOPT_VERSION_STRING}" 2.7.1)
