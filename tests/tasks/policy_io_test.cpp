// SPDX-License-Identifier: Apache-2.0
#include "palpate/tasks/relocate/policies/policy_io.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/error_message.hpp"
#include "data.hpp"
#include "palpate/core/file.hpp"
#include "tasks/policies.hpp"

namespace palpate::relocate {
namespace {

class PolicyIo : public testing::Test {
 protected:
  std::filesystem::path path =
      std::filesystem::path(testing::TempDir()) /
      fmt::format("{}.json", testing::UnitTest::GetInstance()->current_test_info()->name());

  std::string error_of(const std::string& text) {
    write_file_atomically(path, text);
    return error_message([this] { load_policy(path); });
  }

  /// The saved policy with a part of its text exchanged.
  std::string error_with(const std::string& from, const std::string& to) {
    save_policy(path, small_network(1).record());
    const std::string text = read_file(path);
    const auto at = text.find(from);
    return error_of(fmt::format("{}{}{}", text.substr(0, at), to, text.substr(at + from.size())));
  }
};

TEST_F(PolicyIo, ReadsANetworkBackExactly) {
  const MlpPolicy policy = small_network(3);
  auto record = policy.record();
  record.notes.emplace("seed", "3");
  save_policy(path, record);
  EXPECT_EQ(read_policy(path).notes.at("seed"), "3");
  const auto read = load_policy(path);
  RandomStream random(1);
  for (int i = 0; i < 20; ++i) {
    const PolicyInput input = random_input(random);
    EXPECT_EQ(read->act(input), policy.act(input));
  }
}

TEST_F(PolicyIo, ReadsAStructuredPolicyBackExactly) {
  for (const bool observed : {false, true}) {
    const StructuredPolicy policy = structured(observed);
    save_policy(path, policy.record());
    const auto read = load_policy(path);
    RandomStream random(2);
    for (int i = 0; i < 20; ++i) {
      const PolicyInput input = random_input(random);
      EXPECT_EQ(read->act(input), policy.act(input));
    }
  }
}

TEST_F(PolicyIo, ReadsAPolicyOfTheFormerTask) {
  const MlpPolicy policy = small_network(3);
  EXPECT_EQ(error_with("relocate-v2", "relocate-1"), "");
  RandomStream random(1);
  const PolicyInput input = random_input(random);
  EXPECT_EQ(load_policy(path)->act(input), small_network(1).act(input));
}

TEST_F(PolicyIo, RejectsWhatIsNoPolicy) {
  EXPECT_NE(error_message([] { load_policy("/nowhere/policy.json"); }), "");
  EXPECT_NE(error_of("").find("not JSON"), std::string::npos);
  EXPECT_NE(error_of("[]").find("not a JSON object"), std::string::npos);
  EXPECT_NE(error_of("{\"format\":\"other\"}").find("other"), std::string::npos);
  EXPECT_NE(error_of("{\"W0\":[[1,2],[3]]}").find("rows of 2 and 1"), std::string::npos);
}

TEST_F(PolicyIo, RejectsJsonOfAnyDepthWithAShortMessage) {
  const std::string deep(100000, '['), closed = deep + std::string(100000, ']');
  for (const std::string& text : {deep, closed, "{\"sizes\": " + closed + "}"}) {
    const std::string message = error_of(text);
    EXPECT_NE(message.find("deeper"), std::string::npos);
    EXPECT_LT(message.size(), 500u);
  }
  EXPECT_LT(error_with("\"mlp\"", fmt::format("[\"{}\"]", std::string(100000, 'x'))).size(), 500u);
}

TEST_F(PolicyIo, RejectsADamagedOrForeignPolicy) {
  EXPECT_NE(error_with("\"version\":1", "\"version\":2").find("version 2"), std::string::npos);
  EXPECT_NE(error_with("relocate-v2", "relocate-0").find("relocate-0"), std::string::npos);
  EXPECT_NE(error_with("\"kind\":\"mlp\"", "\"kind\":\"tree\"").find("tree"), std::string::npos);
  EXPECT_NE(error_with("log_std", "log_stt").find("log_std"), std::string::npos);
  EXPECT_NE(error_with("\"notes\"", "\"remarks\"").find("remarks"), std::string::npos);
  EXPECT_NE(error_with("\"sizes\":[39,", "\"sizes\":[38,").find("parameters"), std::string::npos);
  EXPECT_NE(error_with("\"input_scale\":[", "\"input_scale\":[null,").find("null"),
            std::string::npos);
  EXPECT_NE(error_with("\"input_scale\":[", "\"input_scale\":[1,").find("40 values"),
            std::string::npos);
}

TEST_F(PolicyIo, RejectsLayersThatAreNoNumberOfUnits) {
  for (const char* units : {"39.5", "1e300", "-39", "0", "2000000"}) {
    EXPECT_NE(error_with("\"sizes\":[39,", fmt::format("\"sizes\":[{},", units)).find("layer of"),
              std::string::npos)
        << units;
  }
}

TEST_F(PolicyIo, AnyTruncationIsAnError) {
  save_policy(path, small_network(1).record());
  const std::string text = read_file(path);
  for (std::size_t length = 0; length + 2 < text.size(); length += text.size() / 37) {
    EXPECT_NE(error_of(text.substr(0, length)), "") << length;
  }
}

TEST_F(PolicyIo, NamesTheLayerOfThePublishedFormatThatDoesNotFit) {
  const std::string first = R"("W0":[[1,2,3],[4,5,6]],"b0":[1,2])";
  EXPECT_NE(error_of("{" + first + R"(,"W1":[[1,2,3]],"b1":[1]})").find("'W1' is 1 x 3, behind"),
            std::string::npos);
  EXPECT_NE(error_of("{" + first + R"(,"W1":[[1,2]],"b1":[1,2]})").find("'W1' is 1 x 2, with 2"),
            std::string::npos);
  EXPECT_NE(error_of(R"({"W0":[[1,2,3]],"b0":[]})").find("'W0' is 1 x 3, with 0 biases"),
            std::string::npos);
}

TEST_F(PolicyIo, ReadsThePublishedFormat) {
  for (const auto& file : made_up_and_real("policy.json", "relocate_mug_published_policy.json")) {
    EXPECT_EQ(read_policy(file).sizes, (std::vector<int>{39, 32, 32, 30})) << file;
  }
}

}  // namespace
}  // namespace palpate::relocate
