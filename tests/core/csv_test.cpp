// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/csv.hpp"

#include <gtest/gtest.h>

#include "core/csv_table.hpp"
#include "palpate/core/error.hpp"

namespace palpate {
namespace {

using Cells = std::vector<std::string_view>;

TEST(Csv, CellsAreTrimmedAndEmptyOnesKept) {
  EXPECT_EQ(csv_cells(" a,b\t, ,c\r"), (Cells{"a", "b", "", "c"}));
  EXPECT_EQ(csv_cells("a,"), (Cells{"a", ""}));
  EXPECT_EQ(csv_cells(""), Cells{""});
}

TEST(Csv, AColumnThatTheHeaderNamesTwiceIsRefusedWhereItIsAskedFor) {
  const CsvTable table("x,y,x\n1,2,3\n", "twice.csv");
  EXPECT_EQ(table.require("y"), 1u);
  EXPECT_EQ(table.find("z"), std::nullopt);
  try {
    (void)table.find("x");
    FAIL() << "it was taken";
  } catch (const BadInput& error) {
    EXPECT_STREQ(error.what(), "twice.csv: the header names column x twice");
  }
}

}  // namespace
}  // namespace palpate
