#include "common/ros2/messages/message_codec.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "common/ros2/messages/action_messages.h"
#include "common/ros2/messages/common_messages.h"
#include "common/ros2/messages/geometry_messages.h"
#include "common/ros2/messages/nav_messages.h"
#include "common/ros2/messages/sensor_messages.h"

namespace treeline::messages {
namespace {

using ::testing::HasSubstr;

// "00 01 'map' ..." as bytes: hexadecimal numbers, and letters in quotes.
std::vector<uint8_t> Bytes(const std::string& text) {
  std::vector<uint8_t> bytes;
  for (size_t i = 0; i < text.size();) {
    if (text[i] == ' ') {
      ++i;
    } else if (text[i] == '\'') {
      for (++i; text[i] != '\''; ++i) {
        bytes.push_back(static_cast<uint8_t>(text[i]));
      }
      ++i;
    } else {
      bytes.push_back(
          static_cast<uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16)));
      i += 2;
    }
  }
  return bytes;
}

template <typename M>
void ExpectBytes(const M& message, const std::string& text) {
  const std::vector<uint8_t> bytes = Bytes(text);
  EXPECT_EQ(Encode(message), bytes);
  const absl::StatusOr<M> decoded = Decode<M>(bytes);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(*decoded, message);
}

// Computed by hand from the definitions: each line a field, padding first.
// Floats: 1 is 3f800000, 2 is 40000000, -0.5 is bf000000.

TEST(MessageCodecTest, BatteryState) {
  ExpectBytes(BatteryState{.header = {.stamp = {.sec = 258, .nanosec = 3},
                                      .frame_id = "b"},
                           .voltage = 0.5f,
                           .percentage = 0.25f,
                           .power_supply_status = BatteryState::kDischarging,
                           .power_supply_health = 1,
                           .power_supply_technology = 3,
                           .present = true,
                           .cell_voltage = {2},
                           .location = "aft"},
              "00 01 00 00"
              "02 01 00 00"           // header.stamp.sec
              "03 00 00 00"           // header.stamp.nanosec
              "02 00 00 00 'b' 00"    // header.frame_id
              "00 00"                 // padding to 16
              "00 00 00 3f"           // voltage
              "00 00 00 00"           // temperature
              "00 00 00 00"           // current
              "00 00 00 00"           // charge
              "00 00 00 00"           // capacity
              "00 00 00 00"           // design_capacity
              "00 00 80 3e"           // percentage
              "02 01 03"              // status, health, technology
              "01"                    // present
              "01 00 00 00"           // cell_voltage
              "00 00 00 40"           //
              "00 00 00 00"           // cell_temperature
              "04 00 00 00 'aft' 00"  // location
              "01 00 00 00 00");      // serial_number
}

// An id of a goal: 16 bytes, and no padding before or after.
constexpr Uuid kGoalId = {
    {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16}};
constexpr char kGoalIdBytes[] =
    "01 02 03 04 05 06 07 08 09 0a 0b 0c 0d 0e 0f 10";

TEST(MessageCodecTest, GoalsOfActionsAndTheirAnswers) {
  ExpectBytes(
      NavigateToPoseSendGoalRequest{
          .goal_id = kGoalId,
          .goal = {.pose = {.header = {.stamp = {.sec = 258, .nanosec = 3},
                                       .frame_id = "map"},
                            .pose = {.position = {1, 2, -0.5},
                                     .orientation = {0, 0, 0, 1}}},
                   .behavior_tree = ""}},
      std::string("00 01 00 00") + kGoalIdBytes +
          "02 01 00 00 03 00 00 00"  // stamp; 24 so far
          "04 00 00 00 'map' 00"     // frame_id; 32: aligned to 8
          "00 00 00 00 00 00 f0 3f"  // position
          "00 00 00 00 00 00 00 40"
          "00 00 00 00 00 00 e0 bf"
          "00 00 00 00 00 00 00 00"  // orientation
          "00 00 00 00 00 00 00 00"
          "00 00 00 00 00 00 00 00"
          "00 00 00 00 00 00 f0 3f"
          "01 00 00 00 00");  // behavior_tree
  ExpectBytes(
      NavigateToPoseSendGoalResponse{.accepted = true,
                                     .stamp = {.sec = 258, .nanosec = 3}},
      "00 01 00 00"
      "01 00 00 00"  // accepted, padding to 4
      "02 01 00 00 03 00 00 00");
  ExpectBytes(NavigateToPoseGetResultRequest{.goal_id = kGoalId},
              std::string("00 01 00 00") + kGoalIdBytes);
}

// Humble reads the first two bytes, Iron four, Jazzy all.
TEST(MessageCodecTest, ResultsBeginAsOlderDistributionsReadThem) {
  ExpectBytes(
      NavigateToPoseGetResultResponse{
          .status = GoalStatus::kAborted,
          .result = {.error_code = 208, .error_msg = "no way"}},
      "00 01 00 00"
      "06"     // status
      "00"     // Humble: std_msgs/Empty; later: padding to 2
      "d0 00"  // error_code
      "07 00 00 00 'no way' 00");
}

TEST(MessageCodecTest, FeedbackAndStatesOfGoals) {
  ExpectBytes(
      NavigateToPoseFeedbackMessage{
          .goal_id = kGoalId,
          .feedback = {.current_pose = {.header = {.stamp = {1, 2},
                                                   .frame_id = "map"},
                                        .pose = {}},
                       .navigation_time = {.sec = 3, .nanosec = 4},
                       .estimated_time_remaining = {.sec = 5, .nanosec = 6},
                       .number_of_recoveries = 7,
                       .distance_remaining = 2}},
      std::string("00 01 00 00") + kGoalIdBytes +
          "01 00 00 00 02 00 00 00"
          "04 00 00 00 'map' 00"
          "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 "
          "00 00"                                             // position
          "00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 00 "  // orientation
          "00 00 00 00 00 00 00 00 00 00 00 00 00 00 f0 3f"
          "03 00 00 00 04 00 00 00"  // navigation_time
          "05 00 00 00 06 00 00 00"  // estimated_time_remaining
          "07 00"                    // number_of_recoveries
          "00 00"                    // padding to 4
          "00 00 00 40");            // distance_remaining
  const GoalInfo info = {.goal_id = kGoalId,
                         .stamp = {.sec = 258, .nanosec = 3}};
  ExpectBytes(
      GoalStatusArray{
          .status_list = {{.goal_info = info, .status = GoalStatus::kExecuting},
                          {.goal_info = info,
                           .status = GoalStatus::kCanceled}}},
      std::string("00 01 00 00 02 00 00 00") + kGoalIdBytes +
          "02 01 00 00 03 00 00 00 02" + kGoalIdBytes +
          "00 00 00"  // padding to 4: ids have no alignment, stamps have
          "02 01 00 00 03 00 00 00 05");
  ExpectBytes(
      CancelGoalRequest{.goal_info = info},
      std::string("00 01 00 00") + kGoalIdBytes + "02 01 00 00 03 00 00 00");
  ExpectBytes(CancelGoalResponse{.return_code = CancelGoalResponse::kRejected,
                                 .goals_canceling = {info}},
              std::string("00 01 00 00 01 00 00 00 01 00 00 00") +
                  kGoalIdBytes + "02 01 00 00 03 00 00 00");
}

TEST(MessageCodecTest, LaserScan) {
  ExpectBytes(LaserScan{.header = {.stamp = {.sec = 258, .nanosec = 3},
                                   .frame_id = "laser"},
                        .angle_min = -0.5,
                        .angle_max = 1,
                        .angle_increment = 0.5,
                        .time_increment = 0,
                        .scan_time = 2,
                        .range_min = 0.25,
                        .range_max = 4,
                        .ranges = {1, 2},
                        .intensities = {}},
              "00 01 00 00"
              "02 01 00 00"              // header.stamp.sec
              "03 00 00 00"              // header.stamp.nanosec
              "06 00 00 00 'laser' 00"   // header.frame_id
              "00 00"                    // padding to 20
              "00 00 00 bf 00 00 80 3f"  // angle_min, angle_max
              "00 00 00 3f 00 00 00 00"  // increments
              "00 00 00 40"              // scan_time
              "00 00 80 3e 00 00 80 40"  // range_min, range_max
              "02 00 00 00"              // ranges
              "00 00 80 3f 00 00 00 40"  //
              "00 00 00 00");            // intensities
}

TEST(MessageCodecTest, TransformsAreAlignedToEight) {
  ExpectBytes(
      TFMessage{.transforms = {{.header = {.stamp = {1, 2}, .frame_id = "odom"},
                                .child_frame_id = "base",
                                .transform = {.translation = {1, 2, -0.5},
                                              .rotation = {0, 0, 0, 1}}}}},
      "00 01 00 00"
      "01 00 00 00"              // one transform
      "01 00 00 00 02 00 00 00"  // stamp; 12 bytes so far
      "05 00 00 00 'odom' 00"    // to 21
      "00 00 00"                 // padding to 24
      "05 00 00 00 'base' 00"    // to 33
      "00 00 00 00 00 00 00"     // padding to 40
      "00 00 00 00 00 00 f0 3f"  // translation
      "00 00 00 00 00 00 00 40"  //
      "00 00 00 00 00 00 e0 bf"  //
      "00 00 00 00 00 00 00 00"  // rotation: x, y, z, w
      "00 00 00 00 00 00 00 00"  //
      "00 00 00 00 00 00 00 00"  //
      "00 00 00 00 00 00 f0 3f");
}

TEST(MessageCodecTest, DiagnosticsHoldSequencesOfStructs) {
  ExpectBytes(
      DiagnosticArray{.header = {.stamp = {0, 0}, .frame_id = ""},
                      .status = {{.level = DiagnosticStatus::kError,
                                  .name = "a",
                                  .message = "",
                                  .hardware_id = "h",
                                  .values = {{.key = "k", .value = "v"}}}}},
      "00 01 00 00"
      "00 00 00 00 00 00 00 00"   // stamp
      "01 00 00 00 00"            // frame_id ""; to 13
      "00 00 00 01 00 00 00"      // padding to 16; one status
      "02"                        // level; to 21
      "00 00 00"                  // padding to 24
      "02 00 00 00 'a' 00"        // to 30
      "00 00"                     //
      "01 00 00 00 00"            // to 37
      "00 00 00"                  //
      "02 00 00 00 'h' 00"        // to 46
      "00 00"                     //
      "01 00 00 00"               // one value
      "02 00 00 00 'k' 00 00 00"  //
      "02 00 00 00 'v' 00");
}

TEST(MessageCodecTest, PointCloud) {
  ExpectBytes(PointCloud2{.header = {.stamp = {0, 0}, .frame_id = "cam"},
                          .height = 1,
                          .width = 2,
                          .fields = {{.name = "x",
                                      .offset = 0,
                                      .datatype = PointField::kFloat32,
                                      .count = 1}},
                          .is_bigendian = false,
                          .point_step = 4,
                          .row_step = 8,
                          .data = {9, 8, 7, 6, 5, 4, 3, 2},
                          .is_dense = true},
              "00 01 00 00"
              "00 00 00 00 00 00 00 00"
              "04 00 00 00 'cam' 00"
              "01 00 00 00 02 00 00 00"  // height, width
              "01 00 00 00"              // one field
              "02 00 00 00 'x' 00 00 00"
              "00 00 00 00"              // offset
              "07 00 00 00"              // datatype, padding
              "01 00 00 00"              // count
              "00 00 00 00"              // is_bigendian, padding
              "04 00 00 00 08 00 00 00"  // steps
              "08 00 00 00 09 08 07 06 05 04 03 02"
              "01");
}

TEST(MessageCodecTest, OccupancyGridHasItsOriginAlignedToEight) {
  OccupancyGrid grid;
  grid.header.frame_id = "map";
  grid.info.resolution = 2;
  grid.info.width = 1;
  grid.info.height = 2;
  grid.info.origin.position.x = 1;
  grid.data = {100, -1};
  ExpectBytes(grid,
              "00 01 00 00"
              "00 00 00 00 00 00 00 00"
              "04 00 00 00 'map' 00"
              "00 00 00 00 00 00 00 00"  // map_load_time; to 24
              "00 00 00 40"              // resolution
              "01 00 00 00 02 00 00 00"  // to 36
              "00 00 00 00"              // padding to 40
              "00 00 00 00 00 00 f0 3f"
              "00 00 00 00 00 00 00 00"
              "00 00 00 00 00 00 00 00"
              "00 00 00 00 00 00 00 00"
              "00 00 00 00 00 00 00 00"
              "00 00 00 00 00 00 00 00"
              "00 00 00 00 00 00 f0 3f"
              "02 00 00 00 64 ff");
}

TEST(MessageCodecTest, SizesOfMessagesOfFixedLength) {
  EXPECT_EQ(Encode(Empty{}).size(), 4U + 1);
  EXPECT_EQ(Encode(Clock{}).size(), 4U + 8);
  EXPECT_EQ(Encode(Twist{}).size(), 4U + 48);
  // 8 of the stamp, 5 of "", padding to 16, 7 doubles, 36 doubles.
  EXPECT_EQ(Encode(PoseWithCovarianceStamped{}).size(), 4U + 16 + 8 * 43);
}

TEST(MessageCodecTest, CameraInfoComesBack) {
  CameraInfo info;
  info.header = {.stamp = {5, 6}, .frame_id = "camera_color_optical_frame"};
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.d = {0.1, -0.2, 0.001, 0.002, 0.05};
  info.k = {525, 0, 319.5, 0, 526, 239.5, 0, 0, 1};
  info.p[11] = 3;
  info.roi.do_rectify = true;
  const auto decoded = Decode<CameraInfo>(Encode(info));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(*decoded, info);
}

TEST(MessageCodecTest, ErrorsNameTheMessage) {
  std::vector<uint8_t> bytes = Encode(Twist{});
  bytes.pop_back();
  const absl::Status status = Decode<Twist>(bytes).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()),
              HasSubstr("geometry_msgs/msg/Twist"));
}

TEST(MessageCodecTest, ManyElementsThatAreNotThereAreRefusedBeforehand) {
  // 2^28 transforms in 16 bytes.
  EXPECT_FALSE(Decode<TFMessage>(
                   Bytes("00 01 00 00 00 00 00 10 00 00 00 00 00 00 00 00"))
                   .ok());
}

TEST(MessageTimeTest, NanosecondsComeBackBelowZeroToo) {
  for (const int64_t ns : {int64_t{0}, int64_t{1'500'000'001}, int64_t{-1},
                           int64_t{-2'000'000'000}}) {
    EXPECT_EQ(Nanoseconds(TimeOf(ns)), ns);
    EXPECT_LT(TimeOf(ns).nanosec, 1'000'000'000U);
  }
}

}  // namespace
}  // namespace treeline::messages
