// SPDX-License-Identifier: Apache-2.0
#include "palpate/core/option_check.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <string>

namespace palpate {
namespace {

struct Inner {
  double share = 0.5;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("share", share, 0.0, 1.0, "of all");
  }
};

struct Outer {
  int count = 3;
  bool loud = false;
  std::string name = "x";
  Inner inner;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("count", count, 1, 10, "of things");
    v("loud", loud, "whether to be heard");
    v("name", name, "of it");
    v.section("inner", inner);
  }
};

TEST(OptionCheck, PassesWhatIsInRange) {
  Outer options;
  options.count = 10;
  options.inner.share = 0;
  EXPECT_EQ(checked(options).count, 10);
}

TEST(OptionCheck, NamesWhatIsNot) {
  const auto message = [](const Outer& options) {
    try {
      checked(options);
    } catch (const BadInput& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  Outer options;
  options.count = 0;
  EXPECT_EQ(message(options), "count must be within 1..10, not 0");
  options = {};
  options.inner.share = 1.5;
  EXPECT_EQ(message(options), "share must be within 0..1, not 1.5");
  options.inner.share = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(message(options), "share must be within 0..1, not nan");
}

}  // namespace
}  // namespace palpate
