// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/csv.hpp"

#include <gtest/gtest.h>

#include "core/csv_table.hpp"
#include "core/error_message.hpp"
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

TEST(Csv, AMessageShowsNoMoreThanTheBeginOfACell) {
  const std::string text = "x\n" + std::string(100'000, 'a') + "\n";
  CsvTable table(text, "long.csv");
  ASSERT_TRUE(table.next());
  EXPECT_LT(error_message([&] { (void)table.finite(0); }).size(), 200u);
  EXPECT_LT(error_message([&] { (void)table.number(0); }).size(), 200u);
}

std::string refusal_of_header(const std::string& text) {
  try {
    (void)CsvTable(text, "c.csv").require_xyz("");
  } catch (const BadInput& error) {
    return error.what();
  }
  return "";
}

TEST(Csv, AHeaderThatIsNoneOrNearlyRightIsNamed) {
  EXPECT_EQ(refusal_of_header("x,y,z\n"), "");
  EXPECT_EQ(refusal_of_header("a,b,c\n"), "c.csv:1: no columns x, y, z in the header");
  for (const std::string wrong : {"x;y;z", "x y z", "0.1,0.2,0.3", "-1,0,nx"}) {
    EXPECT_EQ(refusal_of_header(wrong + "\n1,2,3\n"),
              "c.csv:1: expected a comma-separated header with x,y,z; found '" + wrong + "'");
  }
  EXPECT_EQ(refusal_of_header("X, Y,z,t\n"),
            "c.csv:1: no columns x, y, z in the header X, Y,z,t; did you mean x,y,z?");
}

}  // namespace
}  // namespace palpate
