// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "core/temporary_folder.hpp"
#include "evaluation/quick_options.hpp"
#include "palpate/evaluation/recorder.hpp"
#include "palpate/evaluation/trial.hpp"
#include "palpate/recording/touch_log.hpp"
#include "palpate/recording/writer.hpp"

namespace palpate::evaluation {
namespace {

constexpr std::uint64_t kSeed = 7;

/// 50 g weigh less than the mount resists the motion upwards after a touch.
TEST(Trial, TouchesTheTableAgainWithALightObject) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "pick.h5";
  TrialOptions options = quick_options();
  options.pick.palpation.max = 0;
  options.pick.palpation.table_touches = 2;
  options.pick.palpation.tight = 1;  // however well its pose is known
  const auto known = geometry::load_known_object("box");
  const geometry::ObjectModel box(geometry::make_known_object("light box", known.mesh, 0.05));
  const simulation::World world(box.object(), options.world, kSeed);
  recording::Writer writer(path, {"1.2.3", kSeed, box.object(), world.hand_model(), ""});
  EXPECT_TRUE(run_trial(box, options, kSeed, &writer).metrics.lifted);
  writer.finish();
  const auto log = recording::event_log(recording::read_recording(path));
  EXPECT_EQ(log.all(estimation::TouchEvent::table_touched).size(), 2u);
}

}  // namespace
}  // namespace palpate::evaluation
