#include "nav_agent/app/bridge/ros_parameters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "nav_agent/app/bridge/bridge_config.h"

namespace treeline::bridge_app {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class RosParametersTest : public testing::Test {
 protected:
  void SetUp() override {
    path_ = (std::filesystem::path(testing::TempDir()) /
             testing::UnitTest::GetInstance()->current_test_info()->name())
                .string();
  }
  void TearDown() override { std::filesystem::remove(path_); }

  absl::StatusOr<RosParameters> Read(absl::string_view text) const {
    EXPECT_TRUE(base::WriteFileAtomically(path_, text).ok());
    return ReadRosParameters(path_, "/robot1/treeline",
                             BridgeConfigTable().settings());
  }
  std::string Error(absl::string_view text) const {
    return std::string(Read(text).status().message());
  }

  std::string path_;
};

TEST(IsMeantBy, NamesAndWildcardsAreThoseOfRos) {
  const auto meant = [](absl::string_view pattern) {
    return IsMeantBy(pattern, "/robot1/treeline");
  };
  for (const char* pattern :
       {"/**", "/robot1/treeline", "robot1/treeline", "/*/treeline",
        "/**/treeline", "/robot1/**", "/robot1/*", "/**/robot1/**/treeline"}) {
    EXPECT_TRUE(meant(pattern)) << pattern;
  }
  for (const char* pattern : {"", "/*", "treeline", "/robot1", "/robot2/*",
                              "/*/*/treeline", "/robot1/treeline/*"}) {
    EXPECT_FALSE(meant(pattern)) << pattern;
  }
  std::string many;
  for (int i = 0; i < 200'000; ++i) many += "/**";
  EXPECT_FALSE(meant(many + "/other"));
  EXPECT_TRUE(meant(many));
}

TEST_F(RosParametersTest, TheLastSectionOfThisNodeCounts) {
  const auto read = Read(R"(
/**:
  ros__parameters:
    use_sim_time: True
    base_frame: base_link
robot1:
  treeline:
    ros__parameters:
      base_frame: base_footprint
      rectified: off
      domain_id: 42
      map_from_world: [1.5, -2, 0, 0.5]
amcl:
  ros__parameters:
    alpha1: 0.2
)");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_THAT(read->notes, IsEmpty());
  const auto text = [&read](const char* name) {
    return read->values.at(name).text;
  };
  EXPECT_EQ(read->values.size(), 5U);
  EXPECT_EQ(text("use_sim_time"), "true");
  EXPECT_EQ(text("base_frame"), "base_footprint");
  EXPECT_EQ(text("rectified"), "false");
  EXPECT_EQ(text("domain_id"), "42");
  EXPECT_EQ(text("map_from_world"), "1.5,-2,0,0.5");
  EXPECT_EQ(read->values.at("base_frame").origin, path_ + ":9");
}

TEST_F(RosParametersTest, WhatIsUnknownIsSaid) {
  const auto read =
      Read("/**:\n  ros__parameters:\n    scna: x\n    a: {b: 1}\n");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_THAT(
      read->notes,
      ElementsAre(HasSubstr(":3: there is no parameter 'scna'; did you mean"),
                  HasSubstr(":4: there is no parameter 'a.b'")));
  // One that is for this node alone was meant for it.
  EXPECT_THAT(Error("/robot1/treeline:\n  ros__parameters:\n    scna: x\n"),
              HasSubstr(":3: there is no parameter 'scna'"));
}

TEST_F(RosParametersTest, WhatEveryNodeHasIsLeftOut) {
  const auto read = Read(
      "/robot1/treeline:\n  ros__parameters:\n    scene: house\n"
      "    start_type_description_service: true\n"
      "    qos_overrides: {/tf: {publisher: {depth: 1}}}\n");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(read->values.at("scene").text, "house");
  EXPECT_EQ(read->notes.size(), 2U);
}

TEST_F(RosParametersTest, AFileForOthersIsNoted) {
  const auto read = Read(
      "treeline:\n  ros__parameters: {scan: a}\n"
      "/amcl:\n  ros__parameters: {x: 1}\n");
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_THAT(read->values, IsEmpty());
  EXPECT_THAT(read->notes,
              ElementsAre(HasSubstr(":2: /treeline is not this node, "
                                    "/robot1/treeline: left out"),
                          HasSubstr("nothing in it is for /robot1/treeline; "
                                    "there is /treeline, /amcl")));
}

TEST_F(RosParametersTest, WhatIsNoSuchFileIsRefused) {
  EXPECT_THAT(Error("scan: scan\n"),
              HasSubstr(":1: this is no parameter file of ROS 2: NODE"));
  EXPECT_THAT(Error("/**:\n  ros__parameters: 3\n"),
              HasSubstr("NAME: VALUE below it"));
  EXPECT_THAT(Error("/**:\n  ros__parameters:\n    domain_id: many\n"),
              HasSubstr(":3: domain_id: 'many' is not a whole number"));
  EXPECT_THAT(Error("/**:\n  ros__parameters:\n    scan: [[1]]\n"),
              HasSubstr("must be one value"));
  std::string deep = "x: 1";
  for (int i = 0; i < 100; ++i) deep = absl::StrCat("a: {", deep, "}");
  EXPECT_THAT(Error(deep), HasSubstr("no parameter file of ROS 2"));
  EXPECT_EQ(ReadRosParameters("/nowhere.yaml", "/treeline",
                              BridgeConfigTable().settings())
                .status()
                .code(),
            absl::StatusCode::kNotFound);
}

}  // namespace
}  // namespace treeline::bridge_app
