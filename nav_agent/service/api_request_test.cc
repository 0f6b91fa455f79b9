#include "nav_agent/service/api_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace treeline::agent_service {
namespace {

using ::testing::HasSubstr;

TEST(ApiRequest, ReadsGoals) {
  const auto poses = ParseGoalRequest(
      R"({"poses":[{"x":1,"y":-2.5,"yaw":0.5,"level":1},{"x":0,"y":0}]})");
  ASSERT_TRUE(poses.ok()) << poses.status();
  ASSERT_EQ(poses->size(), 2U);
  EXPECT_EQ((*poses)[0].x_m, 1);
  EXPECT_EQ((*poses)[0].y_m, -2.5);
  EXPECT_EQ((*poses)[0].yaw_rad, 0.5);
  EXPECT_EQ((*poses)[0].level, 1);
  EXPECT_EQ((*poses)[1].yaw_rad, 0);
}

TEST(ApiRequest, SaysWhatIsWrongWithGoals) {
  struct Case {
    const char* body;
    const char* says;
  };
  const Case cases[] = {
      {"", "is not JSON"},
      {"{", "is not JSON"},
      {"[]", "is not an object"},
      {"{}", "poses: is missing"},
      {R"({"poses":3})", "poses: is not a list"},
      {R"({"poses":[]})", "poses: is empty"},
      {R"({"poses":[3]})", "poses[0]: is not an object"},
      {R"({"poses":[{"x":1}]})", "poses[0].y: is missing"},
      {R"({"poses":[{"x":"1","y":0}]})", "poses[0].x: is not a number"},
      {R"({"poses":[{"x":1e999,"y":0}]})", "is not JSON"},
      {R"({"poses":[{"x":1,"y":0,"z":0}]})", "there are x, y, yaw, level"},
      {R"({"poses":[{"x":1,"y":0,"level":0.5}]})", "is not a whole number"},
      {R"({"poses":[{"x":1,"y":0,"level":-1}]})", "is below 0"},
      {R"({"poses":[{"x":1,"y":0,"level":18446744073709551615}]})",
       "is above 1000"},
      {R"({"poses":[{"x":1,"y":0}],"go":true})", "there are poses"},
      {R"({"poses":[{"x":NaN,"y":0}]})", "is not JSON"},
  };
  for (const Case& one : cases) {
    const auto poses = ParseGoalRequest(one.body);
    EXPECT_TRUE(absl::IsInvalidArgument(poses.status())) << one.body;
    EXPECT_THAT(poses.status().message(), HasSubstr(one.says)) << one.body;
  }
  std::string many = R"({"poses":[)";
  for (int i = 0; i < 101; ++i) many += R"({"x":1,"y":0},)";
  many.back() = ']';
  EXPECT_THAT(ParseGoalRequest(many + "}").status().message(),
              HasSubstr("more than 100"));
}

TEST(ApiRequest, ReadsTheOthers) {
  EXPECT_TRUE(ParseEmptyRequest("").ok());
  EXPECT_TRUE(ParseEmptyRequest("{}").ok());
  EXPECT_FALSE(ParseEmptyRequest(R"({"a":1})").ok());
  const auto pose = ParseInitialPoseRequest(R"({"x":1,"y":2,"std_m":0.1})");
  ASSERT_TRUE(pose.ok());
  EXPECT_EQ(pose->std_m, 0.1);
  EXPECT_EQ(pose->std_rad, 0.2);
  EXPECT_TRUE(ParseKidnapRequest(R"({"place":"kitchen"})")->place.has_value());
  EXPECT_TRUE(ParseKidnapRequest(R"({"x":1,"y":2})")->pose.has_value());
  const auto anywhere = ParseKidnapRequest("{}");
  ASSERT_TRUE(anywhere.ok());
  EXPECT_FALSE(anywhere->place.has_value() || anywhere->pose.has_value());
  EXPECT_FALSE(ParseKidnapRequest(R"({"place":"a","x":1,"y":2})").ok());
  EXPECT_FALSE(ParseKidnapRequest(R"({"place":7})").ok());
  EXPECT_FALSE(ParseKidnapRequest(R"({"x":1})").ok());
  EXPECT_EQ(ParseObstacleRequest(R"({"x":1,"y":2,"size_m":0.3})")->size_m, 0.3);
  EXPECT_EQ(ParseNameRequest(R"({"name":"box"})").value(), "box");
  EXPECT_FALSE(ParseNameRequest("{}").ok());
  EXPECT_FALSE(
      ParseNameRequest(R"({"name":")" + std::string(300, 'a') + "\"}").ok());
  const auto fault =
      ParseFaultRequest(R"({"target":"laser","kind":"silent","duration_s":2})");
  ASSERT_TRUE(fault.ok());
  EXPECT_EQ(fault->duration_s, 2);
  EXPECT_EQ(fault->amount, 1);
  EXPECT_FALSE(
      ParseFaultRequest(R"({"target":"laser","kind":"silent","duration_s":-2})")
          .ok());
}

}  // namespace
}  // namespace treeline::agent_service
