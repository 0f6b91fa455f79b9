#include "server/tools/learning/live_source.h"

#include <unistd.h>

#include <array>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::learning {
namespace {

using ::testing::HasSubstr;

constexpr const char* kFrame = "a.jpg b.png 1 2 3 0 0 0 1";

TEST(ParseLiveLine, ReadsFilesAndPose) {
  const auto frame =
      ParseLiveLine("  a.color.jpg\ta.depth.png  1 -2.5 3  0 0 0.6 0.8 ");
  ASSERT_TRUE(frame.ok()) << frame.status();
  ASSERT_TRUE(frame->has_value());
  const auto& read = std::get<LiveFrame>(**frame);
  EXPECT_EQ(read.color_path, "a.color.jpg");
  EXPECT_EQ(read.depth_path, "a.depth.png");
  EXPECT_DOUBLE_EQ(read.world_from_sensor.translation.y, -2.5);
  EXPECT_DOUBLE_EQ(read.world_from_sensor.rotation.w, 0.8);
  EXPECT_DOUBLE_EQ(read.world_from_sensor.rotation.z, 0.6);
}

TEST(ParseLiveLine, ReadsCorrectionsAndTheEndOfFrames) {
  const auto pose = ParseLiveLine("pose a.jpg 1 -2.5 3 0 0 0.6 0.8");
  ASSERT_TRUE(pose.ok()) << pose.status();
  const auto& correction = std::get<PoseCorrection>(pose->value());
  EXPECT_EQ(correction.color_path, "a.jpg");
  EXPECT_DOUBLE_EQ(correction.world_from_sensor.translation.y, -2.5);
  const auto end = ParseLiveLine(" end\r");
  ASSERT_TRUE(end.ok()) << end.status();
  EXPECT_TRUE(std::holds_alternative<EndOfFrames>(end->value()));
  EXPECT_FALSE(ParseLiveLine("pose a.jpg 1 2 3").ok());
}

TEST(ParseLiveLine, LeavesOutCommentsAndEmptyLines) {
  for (const char* line : {"", "   ", "# color depth pose"}) {
    const auto frame = ParseLiveLine(line);
    ASSERT_TRUE(frame.ok()) << line;
    EXPECT_FALSE(frame->has_value()) << line;
  }
}

TEST(ParseLiveLine, SaysWhatIsWrong) {
  EXPECT_THAT(ParseLiveLine("a.jpg 1 2 3").status().message(),
              HasSubstr("COLOR DEPTH tx ty tz qx qy qz qw"));
  EXPECT_THAT(ParseLiveLine("a.jpg b.png 1 2 x 0 0 0 1").status().message(),
              HasSubstr("\"x\" is no number"));
  // Neither nan nor what is no rotation becomes a pose.
  EXPECT_TRUE(absl::IsInvalidArgument(
      ParseLiveLine("a.jpg b.png nan 2 3 0 0 0 1").status()));
  EXPECT_TRUE(absl::IsInvalidArgument(
      ParseLiveLine("a.jpg b.png 1 2 3 0 0 0 0").status()));
  EXPECT_TRUE(ParseLiveLine("a.jpg b.png 4e5 5.8e6 3 0 0 0 1").ok());
  EXPECT_THAT(ParseLiveLine("a.jpg b.png 1e30 2 3 0 0 0 1").status().message(),
              HasSubstr("1e30 2 3, is no place on Earth"));
}

class FramesByLineTest : public testing::Test {
 protected:
  FramesByLineTest() { EXPECT_EQ(pipe(ends_.data()), 0); }
  ~FramesByLineTest() override {
    close(ends_[0]);
    Close();
  }
  void Write(const std::string& bytes) const {
    ASSERT_EQ(write(ends_[1], bytes.data(), bytes.size()),
              static_cast<ssize_t>(bytes.size()));
  }
  void Close() {
    if (ends_[1] >= 0) close(ends_[1]);
    ends_[1] = -1;
  }

  std::array<int, 2> ends_{-1, -1};
};

// A line may come in pieces, and the last one need not end.
TEST_F(FramesByLineTest, GivesLineByLine) {
  const auto source = FramesByLine(ends_[0]);
  const std::string line = kFrame;
  Write("# hello\n\n" + line.substr(0, 10));
  Write(line.substr(10) + "\n" + line);
  Close();
  for (int i = 0; i < 2; ++i) {
    const auto frame = source->Next({});
    ASSERT_TRUE(frame.ok()) << frame.status();
    ASSERT_TRUE(frame->has_value());
    EXPECT_EQ(std::get<LiveFrame>(**frame).color_path, "a.jpg");
  }
  EXPECT_FALSE(source->Next({}).value().has_value());
}

TEST_F(FramesByLineTest, GoesOnAfterAWrongLine) {
  const auto source = FramesByLine(ends_[0]);
  Write(std::string("no frame\n") + kFrame + "\n");
  const auto wrong = source->Next({});
  EXPECT_TRUE(absl::IsInvalidArgument(wrong.status()));
  EXPECT_THAT(wrong.status().message(), HasSubstr("line 1"));
  EXPECT_TRUE(source->Next({}).value().has_value());
}

TEST_F(FramesByLineTest, RefusesALineWithoutEnd) {
  const auto source = FramesByLine(ends_[0]);
  Write(std::string(30000, 'a'));
  EXPECT_TRUE(absl::IsInvalidArgument(source->Next({}).status()));
}

TEST_F(FramesByLineTest, EndsWhenItIsToStop) {
  const auto source = FramesByLine(ends_[0]);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_FALSE(source->Next(stop.get_token()).value().has_value());
}

}  // namespace
}  // namespace treeline::learning
