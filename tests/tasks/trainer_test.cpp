// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/training/trainer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>

#include "core/error_message.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/learning/training/checkpoint.hpp"
#include "tasks/policies.hpp"

namespace palpate::relocate {
namespace {

TrainingContext context() {
  TaskOptions options;
  options.solver = "fast";
  return {make_model(options), 5, 1};
}

std::filesystem::path checkpoint_path() {
  return std::filesystem::path(testing::TempDir()) /
         (std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) +
          ".checkpoint");
}

using MakeTrainer = std::function<std::unique_ptr<Trainer>()>;

/// Trains in one go, and again with a new trainer from a checkpoint on disk before each iteration.
void expect_resumable(const MakeTrainer& make, int iterations) {
  const auto whole = make();
  for (int i = 0; i < iterations; ++i) whole->iterate();
  const auto keep = [](const Trainer& trainer) {
    learning::Checkpoint checkpoint;
    checkpoint.iteration = trainer.iteration();
    trainer.save(checkpoint);
    learning::save_checkpoint(checkpoint_path(), checkpoint);
  };
  keep(*make());
  for (int i = 0; i < iterations; ++i) {
    const auto part = make();
    part->restore(learning::load_checkpoint(checkpoint_path()));
    part->iterate();
    keep(*part);
  }
  const auto last = make();
  last->restore(learning::load_checkpoint(checkpoint_path()));
  EXPECT_EQ(last->iteration(), iterations);
  EXPECT_EQ(last->policy().arrays, whole->policy().arrays);
}

CemTrainingOptions small_search() {
  CemTrainingOptions options;
  options.search.cem.population = 4;
  options.search.cem.elite = 2;
  options.search.screening = options.search.episodes = 1;
  options.search.episode.horizon = 6;
  options.memoryless = true;
  options.settle = 1;
  options.refit = 2;
  options.observer.hidden = 4;
  options.observer.rounds = 2;
  options.observer.episodes = 3;
  options.observer.samples = 200;
  return options;
}

TEST(Trainer, CemGoesOnAfterAnInterruption) {
  expect_resumable([&] { return make_cem_trainer(context(), small_search()); }, 3);
}

TEST(Trainer, RolloutsThatOthersRunGiveTheSameSearch) {
  auto options = small_search();
  options.search.episodes = 3;  // two rounds a generation
  const auto whole = make_cem_trainer(context(), options);
  Metrics figures;
  for (int i = 0; i < 3; ++i) figures = whole->iterate();

  std::optional<learning::Checkpoint> kept;
  const auto resumed = [&] {  // as another process finds it
    auto trainer = make_cem_trainer(context(), options);
    if (kept) trainer->restore(*kept);
    return trainer;
  };
  const auto keep = [&](const Trainer& trainer) {
    kept.emplace();
    kept->iteration = trainer.iteration();
    trainer.save(*kept);
  };
  int rounds = 0;
  std::optional<Metrics> last;
  while (resumed()->iteration() < 3) {
    const auto asker = resumed();
    const auto requests = asker->ask();
    ASSERT_FALSE(requests.empty());
    keep(*asker);
    SearchEpisodes results;
    for (const auto& request : requests) {  // each elsewhere
      const auto runner = resumed();
      results.push_back(runner->run({request}, {asker->parameters(request.candidate)}).at(0));
    }
    const auto teller = resumed();
    EXPECT_EQ(teller->ask(), requests);
    SearchEpisodes few = results;
    few.back().pop_back();
    EXPECT_NE(error_message([&] { resumed()->tell(few); }).find("asked for"), std::string::npos);
    const auto figures_of_round = teller->tell(results);
    if (figures_of_round) last = figures_of_round;
    keep(*teller);
    ++rounds;
  }
  EXPECT_EQ(rounds, 6);
  EXPECT_EQ(last, figures);
  EXPECT_EQ(resumed()->policy().arrays, whole->policy().arrays);
  kept->arrays["under_way"] = Eigen::MatrixXd::Constant(6, 2, 4);
  EXPECT_THROW(make_cem_trainer(context(), options)->restore(*kept), BadInput);
}

TEST(Trainer, DaggerGoesOnAfterAnInterruption) {
  DaggerOptions options;
  options.hidden = 6;
  options.episodes = 3;
  options.samples = 100;
  options.episode.horizon = 6;
  const auto expert = structured(false);
  expect_resumable([&] { return make_dagger_trainer(context(), options, expert); }, 3);
}

TEST(Trainer, NpgGoesOnAfterAnInterruption) {
  NpgOptions options;
  options.trajectories = 3;
  options.evaluation = 2;
  options.episode.horizon = 6;
  expect_resumable([&] { return make_npg_trainer(context(), options, small_network(1), {}); }, 3);
}

TEST(Trainer, RefusesACheckpointOfImpossibleLayers) {
  NpgOptions npg;
  npg.trajectories = 2;
  npg.evaluation = 1;
  npg.episode.horizon = 3;
  const auto trainer = make_npg_trainer(context(), npg, small_network(1), {});
  trainer->iterate();
  learning::Checkpoint whole;
  trainer->save(whole);
  const auto cem = make_cem_trainer(context(), {});
  for (const double units : {39.5, 1e300, -1.0, std::nan("")}) {
    for (const char* name : {"policy_sizes", "value_sizes"}) {
      learning::Checkpoint checkpoint = whole;
      checkpoint.arrays.at(name)(0, 0) = units;
      EXPECT_NE(error_message([&] { trainer->restore(checkpoint); }).find("layer of"),
                std::string::npos)
          << name << units;
    }
    learning::Checkpoint checkpoint;
    cem->save(checkpoint);
    checkpoint.arrays["observer_sizes"] = Eigen::Vector3d(units, 4, 3);
    checkpoint.arrays["observer_parameters"] = Eigen::VectorXd::Zero(9);
    EXPECT_NE(error_message([&] { cem->restore(checkpoint); }).find("layer of"), std::string::npos)
        << units;
  }
}

TEST(Trainer, RefusesACheckpointOfArraysOfAnotherSize) {
  const auto refuses = [](Trainer& trainer, const char* name, const Eigen::MatrixXd& values) {
    learning::Checkpoint checkpoint;
    checkpoint.iteration = trainer.iteration();
    trainer.save(checkpoint);
    EXPECT_NO_THROW(trainer.restore(checkpoint)) << name;
    checkpoint.arrays.at(name) = values;
    EXPECT_THROW(trainer.restore(checkpoint), BadInput) << name;
  };
  NpgOptions npg;
  npg.trajectories = 2;
  npg.evaluation = 1;
  npg.episode.horizon = 3;
  const auto gradient = make_npg_trainer(context(), npg, small_network(1), {});
  gradient->iterate();
  refuses(*gradient, "value_range", Eigen::MatrixXd());
  refuses(*gradient, "value_range", Eigen::RowVector2d(0, 1));
  refuses(*gradient, "value_range", Eigen::Vector2d(0, std::nan("")));
  const auto search = make_cem_trainer(context(), small_search());
  learning::Checkpoint start;
  search->save(start);
  const Eigen::MatrixXd& mean = start.array("mean");
  refuses(*search, "mean", mean.topRows(mean.rows() - 1));
  refuses(*search, "spread", mean.replicate(1, 2));
}

TEST(Trainer, NpgReportsWhatTheMeanActionEarns) {
  NpgOptions options;
  options.trajectories = 2;
  options.evaluation = 3;
  options.episode.horizon = 6;
  const auto trainer = make_npg_trainer(context(), options, small_network(1), {});
  const auto metrics = trainer->iterate();
  EXPECT_EQ(metrics[0].first, "evaluation");
  const auto seed = RandomStream(context().seed, "evaluation").bits();
  const auto episodes =
      rollout(context().model, *policy_from(trainer->policy()), options.episode, seed, 3, 1);
  EXPECT_DOUBLE_EQ(metrics[0].second, summarize(episodes).mean);
}

TEST(Trainer, DaggerLearnsWhatTheExpertDoes) {
  DaggerOptions options;
  options.episodes = 6;
  options.samples = 20000;
  options.episode.horizon = 20;
  options.hidden = 16;
  const auto expert = small_network(7);
  const auto trainer = make_dagger_trainer(context(), options, expert);
  double first = 0, last = 0;
  for (int i = 0; i < 3; ++i) {
    last = trainer->iterate()[1].second;
    if (i == 0) first = last;
  }
  EXPECT_LT(last, 0.02);  // mean squared; the expert's actions are of size 1
  EXPECT_GT(first, 0);
}

TEST(Checkpoint, ReadsBackExactly) {
  learning::Checkpoint checkpoint;
  checkpoint.method = "cem";
  checkpoint.seed = 18446744073709551615ULL;
  checkpoint.iteration = 7;
  checkpoint.settings = "a = 1\n";
  checkpoint.arrays["x"] = Eigen::MatrixXd::Random(3, 5);
  checkpoint.arrays["empty"] = Eigen::MatrixXd(4, 0);
  learning::save_checkpoint(checkpoint_path(), checkpoint);
  const auto read = learning::load_checkpoint(checkpoint_path());
  EXPECT_EQ(read.method, checkpoint.method);
  EXPECT_EQ(read.seed, checkpoint.seed);
  EXPECT_EQ(read.iteration, checkpoint.iteration);
  EXPECT_EQ(read.settings, checkpoint.settings);
  EXPECT_EQ(read.array("x"), checkpoint.arrays["x"]);
  EXPECT_EQ(read.array("empty").cols(), 0);
  EXPECT_THROW(read.array("y"), BadInput);
}

TEST(Checkpoint, AnyTruncationOrAdditionIsAnError) {
  learning::Checkpoint checkpoint;
  checkpoint.arrays["x"] = Eigen::MatrixXd::Random(3, 5);
  learning::save_checkpoint(checkpoint_path(), checkpoint);
  const std::string bytes = read_file(checkpoint_path());
  const auto error_of = [](const std::string& text) {
    write_file_atomically(checkpoint_path(), text);
    return error_message([] { learning::load_checkpoint(checkpoint_path()); });
  };
  for (std::size_t length = 0; length < bytes.size(); length += 7) {
    EXPECT_NE(error_of(bytes.substr(0, length)), "") << length;
  }
  EXPECT_NE(error_of(bytes + "x"), "");
  EXPECT_NE(error_of("{}\n"), "");
  EXPECT_EQ(error_of(bytes), "");
}

}  // namespace
}  // namespace palpate::relocate
