// SPDX-License-Identifier: Apache-2.0
#include "palpate/recording/sink.hpp"

#include <gtest/gtest.h>

#include <string>

namespace palpate::recording {
namespace {

/// Writes down, under its name, what it is given.
class Listener : public Sink {
 public:
  Listener(std::string name, std::string& heard) : name_(std::move(name)), heard_(heard) {}
  void frame(const Frame&) override { heard_ += name_ + " frame, "; }
  void event(const Event& event) override { heard_ += name_ + " " + event.phase + ", "; }
  void estimate(const EstimateRecord&) override { heard_ += name_ + " estimate, "; }
  void belief(const BeliefRecord& belief) override { heard_ += name_ + " " + belief.source + ", "; }

 private:
  std::string name_;
  std::string& heard_;
};

TEST(Tee, PassesEverythingOnInOrder) {
  std::string heard;
  Listener file("file", heard), page("page", heard);
  Tee tee({&file, &page});
  tee.frame({});
  tee.event({.time = 0, .kind = EventKind::begin, .phase = "lift", .text = ""});
  tee.estimate({});
  tee.belief({.time = 0, .source = "prior", .in_hand = false, .poses = {}});
  EXPECT_EQ(heard,
            "file frame, page frame, file lift, page lift, file estimate, page estimate, "
            "file prior, page prior, ");
}

}  // namespace
}  // namespace palpate::recording
