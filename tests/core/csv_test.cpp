// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/csv.hpp"

#include <gtest/gtest.h>

namespace palpate {
namespace {

using Cells = std::vector<std::string_view>;

TEST(Csv, CellsAreTrimmedAndEmptyOnesKept) {
  EXPECT_EQ(csv_cells(" a,b\t, ,c\r"), (Cells{"a", "b", "", "c"}));
  EXPECT_EQ(csv_cells("a,"), (Cells{"a", ""}));
  EXPECT_EQ(csv_cells(""), Cells{""});
}

}  // namespace
}  // namespace palpate
