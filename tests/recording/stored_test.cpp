// SPDX-License-Identifier: Apache-2.0
#include <H5Cpp.h>
#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <vector>

#include "core/error_message.hpp"
#include "palpate/recording/writer.hpp"
#include "recording/seal.hpp"
#include "recording/toy_recording.hpp"

namespace palpate::recording {
namespace {

constexpr const char* kTime = "frames/time";

/// The message with which a recording is refused whose times are stored otherwise.
std::string refusal(const TestFolder& folder, const std::function<void(H5::H5File&)>& store) {
  const auto path = folder / "toy.h5";
  write_recording(path, toy_recording(9));
  {
    H5::H5File file(path.string(), H5F_ACC_RDWR);
    file.unlink(kTime);
    store(file);
  }
  write_closed_seal(path, kFormatVersion);
  return error_message([&] { read_recording(path); });
}

void store(H5::H5File& file, const H5::DSetCreatPropList& properties) {
  const std::array<hsize_t, 2> size = {9, 1};
  const std::array<double, 9> times{};
  file.createDataSet(kTime, H5::PredType::IEEE_F64LE, H5::DataSpace(2, size.data()), properties)
      .write(times.data(), H5::PredType::NATIVE_DOUBLE);
}

H5::DSetCreatPropList in_chunks() {
  const std::array<hsize_t, 2> chunk = {9, 1};
  H5::DSetCreatPropList properties;
  properties.setChunk(2, chunk.data());
  return properties;
}

TEST(StoredRecordingTest, ADatasetMustBeStoredAsTheWriterDoes) {
  const TestFolder folder;
  const auto usual = [](H5::H5File& file) {
    auto properties = in_chunks();
    properties.setFletcher32();
    store(file, properties);
  };
  EXPECT_EQ(refusal(folder, usual), "");
  const auto packed = [](H5::H5File& file) {
    auto properties = in_chunks();
    properties.setDeflate(9);
    store(file, properties);
  };
  const auto in_one_piece = [](H5::H5File& file) { store(file, {}); };
  const std::vector<std::function<void(H5::H5File&)>> others = {packed, in_one_piece};
  for (const auto& other : others) {
    const std::string reason = refusal(folder, other);
    EXPECT_NE(reason.find("frames/time is not stored as in a recording"), reason.npos) << reason;
  }
}

TEST(StoredRecordingTest, ADatasetOfAnotherFileIsNotRead) {
  const TestFolder folder;
  const auto other = folder / "other.h5";
  write_recording(other, toy_recording(9));
  const std::string reason = refusal(folder, [&](H5::H5File& file) {
    ASSERT_GE(
        H5Lcreate_external(other.c_str(), kTime, file.getId(), kTime, H5P_DEFAULT, H5P_DEFAULT), 0);
  });
  EXPECT_NE(reason.find("frames/time is not stored as in a recording"), reason.npos) << reason;
}

}  // namespace
}  // namespace palpate::recording
