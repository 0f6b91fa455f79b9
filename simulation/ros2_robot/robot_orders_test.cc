#include "simulation/ros2_robot/robot_orders.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>

namespace treeline::ros2_robot {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(RobotOrdersTest, AnOrderSaysWhatAndWhere) {
  EXPECT_EQ(ParseOrder("tour")->kind, RobotOrder::Kind::kTour);
  const auto kidnap = ParseOrder("kidnap 1.5 -2 0.25");
  ASSERT_TRUE(kidnap.ok()) << kidnap.status();
  EXPECT_EQ(kidnap->kind, RobotOrder::Kind::kKidnap);
  EXPECT_EQ(kidnap->x_m, 1.5);
  EXPECT_EQ(kidnap->y_m, -2);
  EXPECT_EQ(kidnap->yaw_rad, 0.25);
  const auto silence = ParseOrder("silence odom 3");
  ASSERT_TRUE(silence.ok()) << silence.status();
  EXPECT_EQ(silence->topic, "odom");
  EXPECT_EQ(silence->seconds, 3);
  EXPECT_EQ(ParseOrder("jump -100")->seconds, -100);
}

TEST(RobotOrdersTest, WhatIsNoneIsToldWhatThereIs) {
  for (const char* line : {"dance", "kidnap 1 2", "goal 1 2 x", "tour now",
                           "silence cmd_vel 3", "silence odom", "jump", " "}) {
    EXPECT_THAT(ParseOrder(line).status().message(),
                HasSubstr("is no order; orders are: tour | kidnap X Y YAW"))
        << line;
  }
}

TEST(RobotOrdersTest, LinesAreTakenWholeAndNobodyIsWaitedFor) {
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const int before = dup(STDIN_FILENO);
  ASSERT_EQ(dup2(ends[0], STDIN_FILENO), STDIN_FILENO);
  const auto write_all = [&ends](const std::string& text) {
    ASSERT_EQ(write(ends[1], text.data(), text.size()),
              static_cast<ssize_t>(text.size()));
  };
  OrderReader reader;
  EXPECT_THAT(reader.TakeLines(), IsEmpty());
  write_all("tour\n\ngoal 1");
  EXPECT_THAT(reader.TakeLines(), ElementsAre("tour"));
  write_all(" 2 3\n");
  EXPECT_THAT(reader.TakeLines(), ElementsAre("goal 1 2 3"));
  close(ends[1]);
  EXPECT_THAT(reader.TakeLines(), IsEmpty());
  EXPECT_THAT(reader.TakeLines(), IsEmpty());
  dup2(before, STDIN_FILENO);
  close(before);
  close(ends[0]);
}

}  // namespace
}  // namespace treeline::ros2_robot
