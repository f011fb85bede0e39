// SPDX-License-Identifier: Apache-2.0
#include "palpate/pipeline/place_course.hpp"

#include <gtest/gtest.h>

#include "palpate/core/error.hpp"

namespace palpate::pipeline {
namespace {

TEST(PlaceMeans, AreWhatTheirNamesSay) {
  for (const PlaceMeans means :
       {PlaceMeans::automatic, PlaceMeans::wrist, PlaceMeans::fingers, PlaceMeans::regrasp}) {
    PlaceOptions options;
    options.means = to_string(means);
    EXPECT_EQ(place_means(options), means) << options.means;
  }
  EXPECT_EQ(place_means({}), PlaceMeans::automatic);
}

TEST(PlaceMeans, OtherWordsAreNamed) {
  PlaceOptions options;
  options.means = "teleport";
  try {
    place_means(options);
    FAIL();
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("teleport"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace palpate::pipeline
