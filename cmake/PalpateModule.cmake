# SPDX-License-Identifier: Apache-2.0

# palpate_module(NAME [FOLDER folder] DEPENDENCY...): the static library palpate::NAME from
# src/FOLDER, with its public headers in include/palpate/FOLDER. The folder is the name unless given.
# Private headers are included by their path below src.
function(palpate_module name)
  cmake_parse_arguments(module "" "FOLDER" "" ${ARGN})
  if(NOT module_FOLDER)
    set(module_FOLDER ${name})
  endif()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/${module_FOLDER}/*.cpp")
  add_library(palpate_${name} STATIC ${sources})
  add_library(palpate::${name} ALIAS palpate_${name})
  set_target_properties(palpate_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(palpate_${name} PUBLIC cxx_std_20)
  target_include_directories(palpate_${name}
    PUBLIC "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>" "$<INSTALL_INTERFACE:include>"
    PRIVATE "${PROJECT_SOURCE_DIR}/src")
  target_link_libraries(palpate_${name} PUBLIC ${module_UNPARSED_ARGUMENTS}
                        PRIVATE $<BUILD_INTERFACE:palpate_warnings>)
  palpate_precompile(palpate_${name})
  install(TARGETS palpate_${name} EXPORT palpate-${name} COMPONENT development)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/palpate/${module_FOLDER}"
          DESTINATION include/palpate COMPONENT development)
  set(PALPATE_LIBRARIES ${PALPATE_LIBRARIES} ${name} PARENT_SCOPE)
endfunction()
