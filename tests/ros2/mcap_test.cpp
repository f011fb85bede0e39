// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <fstream>

#include "core/error_message.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"
#include "palpate/core/random.hpp"
#include "palpate/ros2/mcap_writer.hpp"
#include "palpate/ros2/messages/sensor_msgs.hpp"
#include "recording/toy_recording.hpp"
#include "ros2/mcap_reader.hpp"
#include "ros2/mcap_records.hpp"

namespace palpate::ros2 {
namespace {

namespace fs = std::filesystem;

constexpr int kMessages = 50;

JointState joint_state(int i) {
  JointState state;
  state.header = {{i, 0}, "f"};
  state.name = {"j"};
  state.position = {0.5 * i};
  return state;
}

/// Two topics, in chunks of so many bytes.
void write_sample(const fs::path& path, std::size_t chunk_size) {
  McapWriter writer(path, chunk_size);
  writer.metadata("palpate", {{"object", "mug"}});
  for (int i = 0; i < kMessages; ++i) {
    const auto time = static_cast<std::uint64_t>(1000 * i);
    writer.write("/a", time, String{fmt::format("text {}", i)});
    writer.write("/b", time, joint_state(i));
  }
  writer.finish();
}

class Mcap : public testing::Test {
 protected:
  recording::TestFolder folder_;
  fs::path path_ = folder_ / "sample.mcap";
  std::vector<std::string> texts_;
  std::vector<double> positions_;

  McapContents read(const fs::path& path) {
    texts_.clear();
    positions_.clear();
    return read_mcap(path, [this](const McapMessage& message) {
      EXPECT_EQ(message.encoding, "cdr");
      if (message.topic == "/a") {
        EXPECT_EQ(message.type, String::kType);
        EXPECT_EQ(message.log_time, 1000 * texts_.size());
        EXPECT_EQ(message.sequence, texts_.size());
        texts_.push_back(deserialize<String>(message.data).data);
      } else {
        positions_.push_back(deserialize<JointState>(message.data).position.at(0));
      }
    });
  }
};

TEST_F(Mcap, ComesBackInChunksAndWithout) {
  for (const std::size_t chunk_size : {std::size_t{0}, std::size_t{300}, std::size_t{1} << 20}) {
    write_sample(path_, chunk_size);
    const McapContents contents = read(path_);
    EXPECT_EQ(contents.messages, 2U * kMessages);
    EXPECT_TRUE(contents.complete);
    EXPECT_EQ(contents.metadata.at("palpate").at("object"), "mug");
    ASSERT_EQ(texts_.size(), std::size_t{kMessages});
    EXPECT_EQ(texts_.back(), "text 49");
    EXPECT_EQ(positions_.at(3), 1.5);
  }
}

TEST_F(Mcap, IsThereWholeOrNotAtAll) {
  {
    McapWriter writer(path_);
    writer.write("/a", 0, String{"x"});
  }
  EXPECT_FALSE(fs::exists(path_));
}

TEST_F(Mcap, ATopicHasOneType) {
  McapWriter writer(path_);
  writer.write("/a", 0, String{"x"});
  EXPECT_THROW(writer.write("/a", 1, JointState{}), BadInput);
}

TEST_F(Mcap, OfAFileWithoutItsEndAllIsReadThatIsThere) {
  write_sample(path_, 300);
  const std::string whole = read_file(path_);
  const fs::path cut = folder_ / "cut.mcap";
  std::ofstream(cut, std::ios::binary) << whole.substr(0, whole.size() / 3);
  const McapContents contents = read(cut);
  EXPECT_FALSE(contents.complete);
  EXPECT_GT(contents.messages, 10U);
  EXPECT_LT(contents.messages, 2U * kMessages);
}

TEST_F(Mcap, DamageIsNamedWithItsPlace) {
  write_sample(path_, 1 << 20);
  std::string bytes = read_file(path_);
  const auto plain = bytes.find("text 17");  // in a chunk, if it is not compressed
  const auto packed = bytes.find("zstd") + 200;
  bytes[plain != std::string::npos ? plain + 5 : packed] ^= 0x10;
  const fs::path damaged = folder_ / "damaged.mcap";
  std::ofstream(damaged, std::ios::binary) << bytes;
  try {
    read(damaged);
    FAIL();
  } catch (const BadInput& error) {
    const std::string reason = error.what();
    EXPECT_TRUE(reason.find("CRC") != reason.npos || reason.find("zstd") != reason.npos) << reason;
    EXPECT_NE(reason.find("damaged.mcap"), std::string::npos);
  }
  EXPECT_THROW(read(folder_ / "none.mcap"), BadInput);
  std::ofstream(damaged, std::ios::binary) << "x,y,z\n1,2,3\n";
  EXPECT_THROW(read(damaged), BadInput);
}

TEST_F(Mcap, AChunkHoldsNeitherChunksNorMetadata) {
  const std::string empty = McapFields().text("").text("").record(McapOp::metadata);
  std::string inner = empty;
  for (const char* const reason : {"metadata in a chunk", "a chunk in a chunk"}) {
    McapFields fields;
    fields.number(std::uint64_t{0}).number(std::uint64_t{0}).number(std::uint64_t{inner.size()});
    fields.number(std::uint32_t{0}).text("").number(std::uint64_t{inner.size()}).raw(inner);
    inner = fields.record(McapOp::chunk);
    std::ofstream(path_, std::ios::binary) << kMcapMagic << inner;
    EXPECT_NE(error_message([&] { read(path_); }).find(reason), std::string::npos) << reason;
  }
}

TEST_F(Mcap, ChangedBytesAreReadOrRefused) {
  write_sample(path_, 0);  // without chunks, where no CRC stands before the records
  const std::string whole = read_file(path_);
  const fs::path changed = folder_ / "changed.mcap";
  RandomStream random(4, "mcap");
  int accepted = 0, refused = 0;
  for (int i = 0; i < 400; ++i) {
    std::string bytes = whole;
    for (int k = 0; k < 3; ++k) {
      bytes[8 + random.index(bytes.size() - 8)] = static_cast<char>(random.index(256));
    }
    std::ofstream(changed, std::ios::binary) << bytes;
    try {
      read_mcap(changed, [](const McapMessage&) {});
      ++accepted;
    } catch (const BadInput&) {
      ++refused;
    }
  }
  EXPECT_GT(accepted, 0);
  EXPECT_GT(refused, 0);
}

}  // namespace
}  // namespace palpate::ros2
