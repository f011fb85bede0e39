// SPDX-License-Identifier: Apache-2.0
#include "palpate/tactile/contacts/contact_log.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/temporary_folder.hpp"
#include "data.hpp"
#include "palpate/core/error.hpp"
#include "palpate/core/file.hpp"

namespace palpate::tactile {
namespace {

class ContactLogTest : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) {
    const auto path = folder_.path() / "log.csv";
    write_file_atomically(path, text);
    return path;
  }
  std::string error(const std::string& text) {
    try {
      read_contact_log(write(text));
    } catch (const BadInput& bad) {
      return bad.what();
    }
    return "";
  }
  TemporaryFolder folder_;
};

TEST_F(ContactLogTest, GroupsRowsIntoFramesOfFingers) {
  const auto logs =
      read_contact_log(write("x,y,z,nx,ny,nz,finger,t,fx,fy,fz\n"
                             "0,0,0,0,0,2,FF,0.00,0,0,-1\n"
                             "0.002,0,0,0,0,1,FF,0.00,0,0,-3\n"
                             "1,0,0,1,0,0,MF,0.00,-1,0,0\n"
                             "0.004,0,0,0,0,1,FF,0.01,0,0,-3\n"));
  ASSERT_EQ(logs.size(), 2u);
  EXPECT_EQ(logs[0].finger, "FF");
  ASSERT_EQ(logs[0].frames.size(), 2u);
  EXPECT_EQ(logs[0].frames[0].contacts.size(), 2u);
  EXPECT_TRUE(logs[0].normals[0]->isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_NEAR(logs[0].period, 0.01, 1e-12);
  EXPECT_EQ(logs[1].frames[0].contacts[0].f.x(), -1);
}

TEST_F(ContactLogTest, TheTipsOwnNormalIsReadWhereThereIsOne) {
  const auto contacts =
      read_contact_log(write("finger,t,px,py,pz,fx,fy,fz,tnx,tny,tnz\n"
                             "FF,0.0,0,0,0,0,0,-1,0,0,3\n"
                             "FF,0.0,1,0,0,0,0,-1,0,0,0\n"
                             "FF,0.0,2,0,0,0,0,-1,nan,0,1\n"))[0]
          .frames[0]
          .contacts;
  ASSERT_EQ(contacts.size(), 3u);
  EXPECT_TRUE(contacts[0].tip_normal->isApprox(Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(contacts[1].tip_normal || contacts[2].tip_normal);
  EXPECT_NE(error("finger,t,px,py,pz,fx,fy,fz,tnx,tny\n").find("tnz"), std::string::npos);
}

TEST_F(ContactLogTest, WholeTimesAreTicks) {
  const std::string text =
      ",finger,t,px,py,pz,fx,fy,fz\n0,FF,0,0,0,0,0,0,-1\n1,FF,1,0,0,0,0,0,-1\n";
  EXPECT_NEAR(read_contact_log(write(text))[0].frames[1].time, 0.1, 1e-12);
  EXPECT_NEAR(read_contact_log(write(text), 0.02)[0].period, 0.02, 1e-12);
  EXPECT_FALSE(read_contact_log(write(text))[0].normals[0]);
  EXPECT_THROW(read_contact_log(write(text), 0), BadInput);
  const auto lost = read_contact_log(write(text + "2,FF,nan,0,0,0,0,0,-1\n"));
  EXPECT_NEAR(lost[0].frames[1].time, 0.1, 1e-12);
}

TEST_F(ContactLogTest, ARowThatIsThereTwiceIsOneContact) {
  const auto logs =
      read_contact_log(write("finger,t,px,py,pz,fx,fy,fz,nx,ny,nz\n"
                             "FF,0.00,0,0,0,0,0,-1,0,0,1\n"
                             "FF,0.00,0,0,0,0,0,-1,0,0,1\n"
                             "FF,0.00,0,0,0,0,0,-2,0,0,1\n"
                             "FF,0.01,0,0,0,0,0,-1,0,0,1\n"));
  ASSERT_EQ(logs[0].frames.size(), 2u);
  EXPECT_EQ(logs[0].frames[0].contacts.size(), 2u);
  EXPECT_EQ(logs[0].frames[1].contacts.size(), 1u);
}

/// A log of one finger at these times.
std::string log_at(const std::vector<std::string>& times) {
  std::string text = "finger,t,px,py,pz,fx,fy,fz\n";
  for (const auto& t : times) text += "FF," + t + ",0,0,0,0,0,-1\n";
  return text;
}

TEST_F(ContactLogTest, ATickIsRefusedWhereTimesAreInSeconds) {
  const auto path = write(log_at({"0", "0.01", "0.02"}));
  EXPECT_NEAR(read_contact_log(path)[0].period, 0.01, 1e-12);
  EXPECT_THROW(read_contact_log(path, 0.1), BadInput);
}

TEST_F(ContactLogTest, WholeTimesInStepsOtherThanOneAreRefusedUnlessTheirUnitIsStated) {
  const std::string ms = log_at({"0", "10", "20", "30"});
  EXPECT_NE(error(ms).find("by 10: is it in ms or ns?"), std::string::npos) << error(ms);
  EXPECT_NEAR(read_contact_log(write(ms), 0.001)[0].period, 0.01, 1e-12);
  EXPECT_EQ(error(log_at({"0", "1", "2", "50", "51"})), "");  // ticks, and a gap
  const std::string ns = log_at({"1700000000000000000", "1700000000010000000"});
  EXPECT_NE(error(ns).find("is it in ms or ns?"), std::string::npos) << error(ns);
}

TEST_F(ContactLogTest, TimesBeyondAnyClockAreRefused) {
  EXPECT_EQ(error(log_at({"1700000000.005", "1700000000.015"})), "");
  EXPECT_NE(error(log_at({"1700000000000.5", "1700000000010.5"})).find("a time"),
            std::string::npos);
  EXPECT_NE(error(log_at({"0.5", "inf"})).find("a time"), std::string::npos);
  EXPECT_EQ(error(log_at({"0.5", "nan"})), "");
}

TEST_F(ContactLogTest, NamesWhatIsWrongAndWhere) {
  const std::string header = "finger,t,px,py,pz,fx,fy,fz\n";
  EXPECT_NE(error("").find("is empty"), std::string::npos);
  EXPECT_NE(error(header).find("no rows"), std::string::npos);
  EXPECT_NE(error("finger,t,px,py,pz,fx,fy\n").find("no columns fx, fy, fz"), std::string::npos);
  EXPECT_NE(error(header + "FF,0,0,0,0,0,0\n").find(":2: 7 values for 8 columns"),
            std::string::npos);
  EXPECT_NE(error(header + "\nFF,0,0,0,0,0,0,x1\n").find(":3: 'x1' in column fz"),
            std::string::npos);
  EXPECT_THROW(read_contact_log(folder_.path() / "none.csv"), BadInput);
}

TEST_F(ContactLogTest, FingersAndContactsAtOneTimeHaveALimit) {
  const std::string header = "finger,t,px,py,pz,fx,fy,fz\n";
  std::string at_once = header, fingers = header;
  for (int i = 0; i <= 10000; ++i) at_once += fmt::format("FF,0.5,0,0,{},0,0,-1\n", 1e-6 * i);
  for (int i = 0; i <= 1000; ++i) fingers += fmt::format("f{},0.5,0,0,0,0,0,-1\n", i);
  EXPECT_NE(error(at_once).find(":10002: more than 10000 contacts of FF"), std::string::npos);
  EXPECT_NE(error(fingers).find(":1002: 'f1000' is one finger more than 1000"), std::string::npos);
}

TEST_F(ContactLogTest, AFingersNameCanBeAFiles) {
  const auto error_of = [this](const std::string& name) {
    return error("finger,t,px,py,pz,fx,fy,fz\n" + name + ",0,0,0,0,0,0,-1\n");
  };
  for (const std::string good : {"FF", "left index", "a.b", "..."}) {
    EXPECT_EQ(error_of(good).empty(), good.front() != '.') << good;
  }
  EXPECT_EQ(error_of("\xC3\xBC"), "");  // UTF-8
  EXPECT_EQ(error_of(std::string(200, 'x')), "");
  EXPECT_NE(error_of(std::string(201, 'x')).find(":2: a finger's name has 201"), std::string::npos);
  EXPECT_NE(error_of(" ").find(":2: a finger has no name"), std::string::npos);
  for (const std::string& bad : {std::string("../evil"), std::string("a/b"), std::string(".hidden"),
                                 std::string("a\tb"), std::string("a\0b", 3)}) {
    EXPECT_NE(error_of(bad).find(":2: '"), std::string::npos) << bad;
  }
  EXPECT_THROW(check_finger_name("a,b", "recording.h5"), BadInput);
}

TEST_F(ContactLogTest, NanIsReadAndFlaggedLater) {
  const auto logs = read_contact_log(write("finger,t,px,py,pz,fx,fy,fz\nFF,0,0,0,0,nan,0,0\n"));
  EXPECT_EQ(SampleMaker().next(logs[0].frames[0]).flags.names(), "not_finite");
}

/// Placeholders before the first touch, and a finger that repeats its readings.
void expect_traps(const std::vector<FingerLog>& logs) {
  ASSERT_EQ(logs.size(), 4u);
  for (const FingerLog& log : logs) {
    EXPECT_EQ(log.frames.size(), 157u);
    EXPECT_NEAR(log.period, 0.1, 1e-9);
    SampleMaker maker({.period = log.period});
    int usable = 0, placeholders = 0;
    for (const FingerFrame& frame : log.frames) {
      const auto sample = maker.next(frame);
      usable += sample.flags.usable();
      placeholders += sample.flags.has(SampleFlag::placeholder);
    }
    EXPECT_GT(placeholders, 0) << log.finger;
    if (log.finger == "FF") {
      EXPECT_LE(usable, 10);  // it moves in 9 ticks only; all others repeat the last
    } else {
      EXPECT_GT(usable, 50) << log.finger;
    }
  }
}

TEST(ContactLog, PlaceholdersAndRepeatedReadingsAreNotUsed) {
  for (const auto& file : made_up_and_real("contacts.csv", "rls_vel_data.csv")) {
    SCOPED_TRACE(file);
    expect_traps(read_contact_log(file));
  }
}

}  // namespace
}  // namespace palpate::tactile
