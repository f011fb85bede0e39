# SPDX-License-Identifier: Apache-2.0
add_library(palpate_warnings INTERFACE)
target_compile_options(palpate_warnings INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror)
