// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/array_file.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "core/error_message.hpp"

namespace palpate {
namespace {

std::string sample() {
  ArrayFile file("thing", 3);
  file.add("a", (Eigen::MatrixXf(2, 3) << 1, 2, 3, 4, 5, 6).finished());
  file.add("b", Eigen::MatrixXf::Constant(1, 1, -0.5f));
  return file.bytes();
}

std::string refusal(const std::string& bytes) {
  return error_message([&] { (void)ArrayFile::parse(bytes, "file", "thing", 3); });
}

TEST(ArrayFile, GivesBackWhatWasAdded) {
  const auto file = ArrayFile::parse(sample(), "file", "thing", 3);
  EXPECT_EQ(file.get("a", 2, 3)(1, 0), 4);
  EXPECT_EQ(file.get("b")(0, 0), -0.5f);
  EXPECT_EQ(file.bytes(), sample());
}

TEST(ArrayFile, RefusesEveryTruncation) {
  const std::string good = sample();
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_NE(refusal(good.substr(0, length)), "") << length;
  }
}

TEST(ArrayFile, RefusesOtherKindsVersionsAndLengths) {
  EXPECT_NE(refusal(ArrayFile("other", 3).bytes()).find("other"), std::string::npos);
  EXPECT_NE(refusal(ArrayFile("thing", 4).bytes()).find("version 4"), std::string::npos);
  EXPECT_NE(refusal(sample() + "z").find("1 bytes too many"), std::string::npos);
  EXPECT_NE(refusal("palpate thing 3\na 99999999 99999999\nend\n"), "");
  EXPECT_NE(refusal("palpate thing 3\na -2 3\nend\n").find("a -2 3"), std::string::npos);
}

TEST(ArrayFile, RefusesValuesThatAreNotFinite) {
  ArrayFile file("thing", 3);
  const auto infinite = Eigen::MatrixXf::Constant(1, 1, std::numeric_limits<float>::infinity());
  EXPECT_NE(error_message([&] { file.add("a", infinite); }).find("not finite"), std::string::npos);
}

TEST(ArrayFile, RefusesAMatrixOfAnotherSize) {
  const auto file = ArrayFile::parse(sample(), "file", "thing", 3);
  EXPECT_EQ(error_message([&] { (void)file.get("a", 3, 2); }),
            "file: matrix a is 2 x 3, not 3 x 2");
  EXPECT_EQ(error_message([&] { (void)file.get("c"); }), "file: there is no matrix c");
}

}  // namespace
}  // namespace palpate
