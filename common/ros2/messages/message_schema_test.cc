#include "common/ros2/messages/message_schema.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::messages {
namespace {

const std::string kLine = std::string(80, '=') + "\n";

TEST(MessageSchemaTest, FieldsThenTheMessagesInside) {
  EXPECT_EQ(SchemaText<LaserScan>(),
            "std_msgs/Header header\n"
            "float32 angle_min\n"
            "float32 angle_max\n"
            "float32 angle_increment\n"
            "float32 time_increment\n"
            "float32 scan_time\n"
            "float32 range_min\n"
            "float32 range_max\n"
            "float32[] ranges\n"
            "float32[] intensities\n" +
                kLine +
                "MSG: std_msgs/Header\n"
                "builtin_interfaces/Time stamp\n"
                "string frame_id\n" +
                kLine +
                "MSG: builtin_interfaces/Time\n"
                "int32 sec\n"
                "uint32 nanosec\n");
}

TEST(MessageSchemaTest, EachMessageInsideStandsOnce) {
  const std::string text = SchemaText<Odometry>();
  const std::string vector = "MSG: geometry_msgs/Vector3\n";
  const size_t first = text.find(vector);
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(text.find(vector, first + 1), std::string::npos);
  EXPECT_THAT(text, testing::HasSubstr("float64[36] covariance\n"));
}

TEST(MessageSchemaTest, AByteIsAByte) {
  EXPECT_THAT(SchemaText<DiagnosticArray>(),
              testing::HasSubstr("byte level\n"));
  EXPECT_THAT(SchemaText<OccupancyGrid>(), testing::HasSubstr("int8[] data\n"));
  EXPECT_THAT(SchemaText<Image>(), testing::HasSubstr("uint8[] data\n"));
  EXPECT_THAT(SchemaText<PointCloud2>(), testing::HasSubstr("bool is_dense\n"));
}

}  // namespace
}  // namespace treeline::messages
