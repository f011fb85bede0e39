# SPDX-License-Identifier: Apache-2.0

# palpate_module(NAME DEPENDENCY...): the static library palpate::NAME from src/NAME/*.cpp,
# with its public headers in include/palpate/NAME.
function(palpate_module name)
  file(GLOB sources CONFIGURE_DEPENDS "${PROJECT_SOURCE_DIR}/src/${name}/*.cpp")
  add_library(palpate_${name} STATIC ${sources})
  add_library(palpate::${name} ALIAS palpate_${name})
  set_target_properties(palpate_${name} PROPERTIES EXPORT_NAME ${name})
  target_compile_features(palpate_${name} PUBLIC cxx_std_20)
  target_include_directories(palpate_${name}
    PUBLIC "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>" "$<INSTALL_INTERFACE:include>"
    PRIVATE "${PROJECT_SOURCE_DIR}/src/${name}")
  target_link_libraries(palpate_${name} PUBLIC ${ARGN} PRIVATE $<BUILD_INTERFACE:palpate_warnings>)
  install(TARGETS palpate_${name} EXPORT palpate)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/include/palpate/${name}" DESTINATION include/palpate)
endfunction()
