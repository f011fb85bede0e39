// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/minari_io.hpp"

#include <H5Cpp.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/error_message.hpp"
#include "core/temporary_folder.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/random.hpp"

namespace palpate::relocate {
namespace {

MinariDataset random_dataset() {
  RandomStream random(8);
  MinariDataset dataset{"palpate/test-v0", {}};
  for (const Eigen::Index steps : {1, 5, 130}) {
    MinariEpisode e{Eigen::MatrixXd(39, steps + 1), Eigen::MatrixXd(30, steps),
                    Eigen::VectorXd(steps), steps == 5, static_cast<std::uint64_t>(steps)};
    for (double& value : e.observations.reshaped()) value = random.normal();
    for (double& value : e.actions.reshaped()) value = random.uniform(-1, 1);
    for (double& value : e.rewards) value = random.normal();
    dataset.episodes.push_back(e);
  }
  return dataset;
}

TEST(Minari, IsReadBackAsItWasWritten) {
  const TemporaryFolder folder;
  const auto written = random_dataset();
  write_minari(folder.path(), written);
  const auto read = read_minari(folder.path());
  EXPECT_EQ(read.id, written.id);
  ASSERT_EQ(read.episodes.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(read.episodes[i].observations, written.episodes[i].observations);
    EXPECT_EQ(read.episodes[i].actions, written.episodes[i].actions);
    EXPECT_EQ(read.episodes[i].rewards, written.episodes[i].rewards);
    EXPECT_EQ(read.episodes[i].terminated, written.episodes[i].terminated);
    EXPECT_EQ(read.episodes[i].seed, written.episodes[i].seed);
  }
  const auto frames = frames_of(read);
  EXPECT_EQ(frames.actions.cols(), 136);
  EXPECT_EQ(frames.observations.col(1), written.episodes[1].observations.col(0));
}

TEST(Minari, KeepsInfosAndTheEnvironment) {
  const TemporaryFolder folder;
  auto dataset = random_dataset();
  dataset.episodes[1].infos["target"] = Eigen::MatrixXd::Constant(3, 6, 0.25);
  dataset.env_spec = environment_spec({}, {});
  write_minari(folder.path(), dataset);
  const H5::H5File file((folder.path() / "data/main_data.hdf5").string(), H5F_ACC_RDONLY);
  const auto target = file.openGroup("episode_1/infos").openDataSet("target");
  hsize_t size[2] = {};
  target.getSpace().getSimpleExtentDims(size);
  EXPECT_EQ(size[0], 6U);
  EXPECT_EQ(size[1], 3U);
  const auto head = nlohmann::json::parse(read_file(folder.path() / "data/metadata.json"));
  const auto spec = nlohmann::json::parse(head["env_spec"].get<std::string>());
  EXPECT_EQ(spec["id"], "Palpate/Relocate-v2");
  EXPECT_EQ(spec["kwargs"]["object"], "mug");
  EXPECT_EQ(spec["kwargs"]["horizon"], 99);
  dataset.episodes[1].infos["target"] = Eigen::MatrixXd::Zero(3, 5);
  EXPECT_NE(error_message([&] {
              write_minari(folder.path(), dataset);
            }).find("episode_1: info 'target' is not 6 columns"),
            std::string::npos);
}

TEST(Minari, FramesHaveTheIntendedActionsWhereThereAreAny) {
  const TemporaryFolder folder;
  auto dataset = random_dataset();
  const Eigen::MatrixXd intended = Eigen::MatrixXd::Constant(30, 6, 0.25);
  dataset.episodes[1].infos["intended"] = intended;
  write_minari(folder.path(), dataset);
  const auto read = read_minari(folder.path());
  const auto frames = frames_of(read);
  EXPECT_EQ(frames.actions.col(0), dataset.episodes[0].actions.col(0));
  EXPECT_EQ(frames.actions.middleCols(1, 5), intended.leftCols(5));
  dataset.episodes[1].infos["intended"] = Eigen::MatrixXd::Constant(29, 6, 0.25);
  write_minari(folder.path(), dataset);
  EXPECT_NE(error_message([&] { frames_of(read_minari(folder.path())); }).find("29 values"),
            std::string::npos);
}

/// The layout of Minari 0.5, as that library's own files have it.
TEST(Minari, HasTheLayoutThatMinariReads) {
  const TemporaryFolder folder;
  write_minari(folder.path(), random_dataset());
  const H5::H5File file((folder.path() / "data/main_data.hdf5").string(), H5F_ACC_RDONLY);
  const H5::Group episode = file.openGroup("episode_1");
  EXPECT_TRUE(episode.nameExists("infos"));
  for (const char* name : {"id", "total_steps", "seed"}) EXPECT_TRUE(episode.attrExists(name));
  hsize_t size[2] = {}, most[2] = {};
  const auto observations = episode.openDataSet("observations");
  observations.getSpace().getSimpleExtentDims(size, most);
  EXPECT_EQ(size[0], 6U);
  EXPECT_EQ(size[1], 39U);
  EXPECT_EQ(most[0], H5S_UNLIMITED);
  EXPECT_EQ(observations.getCreatePlist().getLayout(), H5D_CHUNKED);
  const auto ended = episode.openDataSet("terminations");
  ASSERT_EQ(ended.getTypeClass(), H5T_ENUM);
  const H5::EnumType boolean = ended.getEnumType();
  EXPECT_EQ(boolean.getSize(), 1U);
  std::int8_t value = 1;
  EXPECT_EQ(boolean.nameOf(&value, 10), "TRUE");
  const auto head = nlohmann::json::parse(read_file(folder.path() / "data/metadata.json"));
  EXPECT_EQ(head["total_episodes"], 3);
  EXPECT_EQ(head["total_steps"], 136);
  EXPECT_EQ(head["data_format"], "hdf5");
  EXPECT_NE(head["observation_space"].get<std::string>().find("-Infinity"), std::string::npos);
}

TEST(Minari, RefusesToWriteWhatNobodyCouldUse) {
  const TemporaryFolder folder;
  const auto refused = [&](const std::function<void(MinariDataset&)>& spoil) {
    auto dataset = random_dataset();
    spoil(dataset);
    return error_message([&] { write_minari(folder.path(), dataset); });
  };
  EXPECT_NE(refused([](auto& d) { d.episodes.clear(); }).find("without episodes"),
            std::string::npos);
  EXPECT_NE(refused([](auto& d) {
              d.episodes[1] = {Eigen::MatrixXd(39, 1), {}, {}};
            }).find("episode_1 has no steps"),
            std::string::npos);
  EXPECT_NE(refused([](auto& d) { d.episodes[1].rewards[2] = NAN; }).find("episode_1: reward 2"),
            std::string::npos);
  EXPECT_NE(refused([](auto& d) { d.episodes[0].actions(0, 0) = INFINITY; }).find("not finite"),
            std::string::npos);
  EXPECT_NE(refused([](auto& d) {
              d.episodes[2].observations.conservativeResize(38, 131);
            }).find("episode_2 has 38"),
            std::string::npos);
  EXPECT_NE(refused([](auto& d) { d.episodes[2].rewards.conservativeResize(3); }).find("3 rewards"),
            std::string::npos);
}

TEST(Minari, RefusesCorruptAndForeignFiles) {
  const TemporaryFolder folder;
  const auto message = [&] { return error_message([&] { read_minari(folder.path()); }); };
  EXPECT_NE(message().find("metadata.json"), std::string::npos);
  write_minari(folder.path(), random_dataset());
  const auto path = folder.path() / "data/main_data.hdf5";
  const std::string whole = read_file(path);
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, whole.size() / 2}) {
    write_file_atomically(path, whole.substr(0, size));
    EXPECT_NE(message().find("main_data.hdf5"), std::string::npos) << size;
  }
  write_file_atomically(path, "not HDF5 at all");
  EXPECT_NE(message().find("main_data.hdf5"), std::string::npos);
  std::filesystem::remove(path);
  EXPECT_NE(message().find("no such file"), std::string::npos);
  write_file_atomically(folder.path() / "data/metadata.json", "{\"data_format\": \"arrow\"}");
  EXPECT_NE(message().find("metadata.json"), std::string::npos);
}

TEST(Minari, RefusesMetadataOfAnyDepth) {
  const TemporaryFolder folder;
  write_minari(folder.path(), random_dataset());
  std::string deep = "{\"data_format\": \"hdf5\", \"total_episodes\": 1, \"dataset_id\": ";
  deep += std::string(100000, '[') + std::string(100000, ']') + "}";
  write_file_atomically(folder.path() / "data/metadata.json", deep);
  const std::string message = error_message([&] { read_minari(folder.path()); });
  EXPECT_NE(message.find("metadata.json"), std::string::npos);
  EXPECT_LT(message.size(), 500u);
}

TEST(Minari, RefusesMetadataOfForeignTypes) {
  const TemporaryFolder folder;
  write_minari(folder.path(), random_dataset());
  const auto path = folder.path() / "data/metadata.json";
  const auto whole = nlohmann::json::parse(read_file(path));
  for (const char* name : {"data_format", "dataset_id", "total_episodes"}) {
    for (const nlohmann::json& value : {nlohmann::json(7), nlohmann::json(nullptr),
                                        nlohmann::json::array({1}), nlohmann::json(-1)}) {
      if (std::string_view(name) == "total_episodes" && value == 7) continue;
      auto head = whole;
      head[name] = value;
      write_file_atomically(path, head.dump());
      EXPECT_NE(error_message([&] { read_minari(folder.path()); }).find("metadata.json"),
                std::string::npos)
          << head.dump();
    }
  }
}

TEST(Minari, RefusesATableWhoseSizeOverflows) {
  const TemporaryFolder folder;
  write_minari(folder.path(), random_dataset());
  {
    const H5::H5File file((folder.path() / "data/main_data.hdf5").string(), H5F_ACC_RDWR);
    const H5::Group episode = file.openGroup("episode_1");
    episode.unlink("observations");
    const hsize_t size[2] = {hsize_t{1} << 33, hsize_t{1} << 31};  // 2^64 values
    const hsize_t chunk[2] = {1, 64};
    H5::DSetCreatPropList properties;
    properties.setChunk(2, chunk);
    episode.createDataSet("observations", H5::PredType::NATIVE_DOUBLE, H5::DataSpace(2, size),
                          properties);
  }
  EXPECT_NE(error_message([&] { read_minari(folder.path()); }).find("more than the file holds"),
            std::string::npos);
}

/// No table claims more values than the file has bytes, but all of them together do.
TEST(Minari, RefusesTablesThatTogetherUnpackToTooMuch) {
  const TemporaryFolder folder;
  write_minari(folder.path(), random_dataset());
  const std::filesystem::path path = folder.path() / "data/main_data.hdf5";
  const hsize_t bytes = std::filesystem::file_size(path);
  {
    const H5::H5File file(path.string(), H5F_ACC_RDWR);
    for (const std::string episode : {"episode_0/", "episode_1/", "episode_2/"}) {
      for (const char* const name : {"observations", "actions", "rewards", "terminations"}) {
        const H5::DataSet table = file.openDataSet(episode + name);
        hsize_t size[2] = {0, 1};
        table.getSpace().getSimpleExtentDims(size);
        size[0] = bytes / size[1];
        table.extend(size);
      }
    }
  }
  EXPECT_NE(error_message([&] { read_minari(folder.path()); }).find("more than the file holds"),
            std::string::npos);
}

TEST(Minari, RefusesNanRewardsInAFile) {
  const TemporaryFolder folder;
  write_minari(folder.path(), random_dataset());
  {
    const H5::H5File file((folder.path() / "data/main_data.hdf5").string(), H5F_ACC_RDWR);
    const std::vector<double> rewards(5, std::numeric_limits<double>::quiet_NaN());
    file.openDataSet("episode_1/rewards").write(rewards.data(), H5::PredType::NATIVE_DOUBLE);
  }
  EXPECT_NE(error_message([&] { read_minari(folder.path()); }).find("episode_1: reward 0 is nan"),
            std::string::npos);
}

/// Minari's own files have one seed an episode; the attribute of a foreign one may be anything.
TEST(Minari, RefusesSeedsThatAreNoSingleInteger) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "data/main_data.hdf5";
  /// What reading says once episode_1 has that attribute; none is written without a type.
  const auto read_with = [&](const H5::DataType* type, const H5::DataSpace& space) {
    write_minari(folder.path(), random_dataset());
    {
      const H5::H5File file(path.string(), H5F_ACC_RDWR);
      H5::Group episode = file.openGroup("episode_1");
      episode.removeAttr("seed");
      if (type != nullptr) {
        const std::vector<std::uint8_t> value(512, 7);
        episode.createAttribute("seed", *type, space).write(*type, value.data());
      }
    }
    return read_minari(folder.path()).episodes[1].seed;
  };
  const auto refused = [&](const H5::DataType& type, const H5::DataSpace& space) {
    return error_message([&] { read_with(&type, space); });
  };
  const H5::DataType integer = H5::PredType::NATIVE_INT64, real = H5::PredType::NATIVE_DOUBLE,
                     text = H5::StrType(H5::PredType::C_S1, 4);
  const hsize_t three = 3, square[2] = {8, 8}, one = 1, none = 0;
  EXPECT_NE(refused(integer, {1, &three}).find("main_data.hdf5: the attribute 'seed' has 3 values"),
            std::string::npos);
  EXPECT_NE(refused(integer, {2, square}).find("'seed' has 64 values, not 1"), std::string::npos);
  EXPECT_NE(refused(integer, {1, &none}).find("'seed' has 0 values, not 1"), std::string::npos);
  EXPECT_NE(refused(integer, H5::DataSpace(H5S_NULL)).find("'seed' has 0 values, not 1"),
            std::string::npos);
  H5::IntType wide(H5::PredType::NATIVE_INT64);
  wide.setSize(64);
  EXPECT_NE(refused(wide, {}).find("'seed' has 64 bytes"), std::string::npos);
  EXPECT_EQ(read_with(&integer, {1, &one}), 0x0707070707070707U);
  // Without one, or with what is no integer, as "None", the episode has none.
  EXPECT_EQ(read_with(nullptr, {}), 0U);
  EXPECT_EQ(read_with(&real, {}), 0U);
  EXPECT_EQ(read_with(&text, {}), 0U);
}

TEST(Minari, AnotherTasksEpisodesTeachNothing) {
  auto dataset = random_dataset();
  for (auto& e : dataset.episodes) e.observations.conservativeResize(17, Eigen::NoChange);
  EXPECT_NE(error_message([&] { frames_of(dataset); }).find("17 observations"), std::string::npos);
}

}  // namespace
}  // namespace palpate::relocate
