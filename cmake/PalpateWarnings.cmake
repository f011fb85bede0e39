# SPDX-License-Identifier: Apache-2.0
add_library(palpate_warnings INTERFACE)
target_compile_options(palpate_warnings INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror)
# gcc 12 sees overlaps and bounds in std::string's moves that cannot be (its bug 105651), and takes
# what the sources of a unity build define for their own for a header's.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(
    palpate_warnings INTERFACE -Wno-restrict -Wno-array-bounds -Wno-stringop-overread
                               "$<$<BOOL:${CMAKE_UNITY_BUILD}>:-Wno-subobject-linkage>")
else()
  # clang's -Wconversion warns of signs too, and of what libstdc++ 12 itself calls in stable_sort.
  target_compile_options(palpate_warnings INTERFACE -Wno-sign-conversion -Wno-deprecated-declarations)
endif()
