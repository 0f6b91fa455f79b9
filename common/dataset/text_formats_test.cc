#include "common/dataset/text_formats.h"

#include <cmath>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

template <typename T>
std::string ErrorOf(const absl::StatusOr<T>& result) {
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(result.status().message());
}

TEST(ParseTimeTest, KeepsEveryDigit) {
  EXPECT_EQ(*ParseTime_ns("1305031241.529758"), 1305031241529758000);
  EXPECT_EQ(*ParseTime_ns("1305031241.123456789"), 1305031241123456789);
  EXPECT_EQ(*ParseTime_ns("1305031241.1234567899"), 1305031241123456789);
  EXPECT_EQ(*ParseTime_ns("7"), 7000000000);
  EXPECT_EQ(*ParseTime_ns("7."), 7000000000);
  EXPECT_EQ(*ParseTime_ns("0.5"), 500000000);
}

// A double is 64 ns off here.
TEST(ParseTimeTest, TakesAnExponentAsNumPyWritesIt) {
  EXPECT_EQ(*ParseTime_ns("1.305031102175303936e+09"), 1305031102175304000);
  EXPECT_EQ(*ParseTime_ns("5.000000000000000000e-01"), 500000000);
  EXPECT_EQ(*ParseTime_ns("0.000000000000000000e+00"), 0);
}

TEST(ParseTimeTest, RefusesWhatIsNotATime) {
  for (const char* text :
       {"", ".", ".5", "-1", "1e9", "nan", "1.2.3", "1,5", " 1", "99999999999",
        "123456789012345678901234567890", "1.5s", "1.4e+18", "-1.4e+09",
        "nane+01", "1.5.2e+01", "infe+00"}) {
    EXPECT_FALSE(ParseTime_ns(text).ok()) << text;
  }
}

TEST(ParseTimeTest, AsksWhetherLargeNumbersAreOfAnotherUnit) {
  for (const char* stamp :
       {"1305031102175304000", "1305031102175", "99999999999"}) {
    EXPECT_THAT(std::string(ParseTime_ns(stamp).status().message()),
                HasSubstr("milliseconds or nanoseconds?"))
        << stamp;
  }
  EXPECT_THAT(std::string(ParseTime_ns("noon").status().message()),
              testing::Not(HasSubstr("nanoseconds")));
}

// As Notepad and spreadsheets write UTF-8.
TEST(TextFormatsTest, AByteOrderMarkIsPassedOver) {
  const auto files = ParseTimedFiles(
      "\xef\xbb\xbf"
      "0.5 a.png\n",
      "rgb.txt");
  ASSERT_TRUE(files.ok()) << files.status();
  EXPECT_EQ((*files)[0].stem, "0.5");
  const auto stems = ParseFrameList(
      "\xef\xbb\xbf"
      "seq-01/a\n",
      "x");
  ASSERT_TRUE(stems.ok()) << stems.status();
  EXPECT_EQ((*stems)[0].stem, "seq-01/a");
}

TEST(ParseFrameListTest, KeepsOrderAndLinesPastCommentsAndCarriageReturns) {
  const auto stems = ParseFrameList(
      "# header\r\nseq-01/frame-000002\r\n\n  seq-01/frame-000001 # why\n",
      "list.txt");
  ASSERT_TRUE(stems.ok()) << stems.status();
  ASSERT_EQ(stems->size(), 2u);
  EXPECT_EQ((*stems)[0].stem, "seq-01/frame-000002");
  EXPECT_EQ((*stems)[0].line, 2);
  EXPECT_EQ((*stems)[1].stem, "seq-01/frame-000001");
  EXPECT_EQ((*stems)[1].line, 4);
}

TEST(ParseFrameListTest, NamesOfPicturesMayHaveBlanksAndHashes) {
  const auto stems =
      ParseFrameList("Photo (1).jpg\n flat #3.jpg\nflat#4.jpg # b\r\n", "l");
  ASSERT_TRUE(stems.ok()) << stems.status();
  ASSERT_EQ(stems->size(), 3u);
  EXPECT_EQ((*stems)[0].stem, "Photo (1).jpg");
  EXPECT_EQ((*stems)[1].stem, "flat");
  EXPECT_EQ((*stems)[2].stem, "flat#4.jpg");
}

TEST(ParseFrameListTest, ErrorsNameFileAndLine) {
  EXPECT_THAT(ErrorOf(ParseFrameList("", "l")), HasSubstr("l: the frame list"));
  EXPECT_THAT(ErrorOf(ParseFrameList("# only\n\n", "l")),
              HasSubstr("no frame"));
  EXPECT_THAT(ErrorOf(ParseFrameList("a\nb\na\n", "l")),
              StartsWith("l:3: 'a' was already in line 1"));
  EXPECT_THAT(ErrorOf(ParseFrameList("../a\n", "l")), StartsWith("l:1: "));
  EXPECT_THAT(ErrorOf(ParseFrameList("a\n/etc/passwd\n", "l")),
              StartsWith("l:2: "));
  EXPECT_THAT(ErrorOf(ParseFrameList("a/../../b\n", "l")), StartsWith("l:1: "));
}

TEST(ParseStemPosesTest, InvertsCameraFromWorld) {
  // A quarter turn about z: the camera's x axis is the world's y axis.
  const auto poses = ParseStemPoses(
      "a 0.70710678 0 0 0.70710678 1 2 3 525.5\n"
      "b.color.png 1 0 0 0 -1 0 0\n",
      "p");
  ASSERT_TRUE(poses.ok()) << poses.status();
  ASSERT_EQ(poses->size(), 2u);
  const geometry::Rigid3& pose = (*poses)[0].world_from_camera;
  // camera = R world + t with R (x, y, z) = (-y, x, z); the centre is -R't.
  EXPECT_NEAR(pose.translation.x, -2, 1e-7);
  EXPECT_NEAR(pose.translation.y, 1, 1e-7);
  EXPECT_NEAR(pose.translation.z, -3, 1e-7);
  EXPECT_EQ((*poses)[0].focal_length_px, 525.5);
  EXPECT_EQ((*poses)[1].stem, "b");
  EXPECT_EQ((*poses)[1].world_from_camera.translation.x, 1);
  EXPECT_EQ((*poses)[1].focal_length_px, std::nullopt);
}

TEST(ParseStemPosesTest, ErrorsNameFileAndLine) {
  const auto error = [](const char* text) {
    return ErrorOf(ParseStemPoses(text, "p"));
  };
  EXPECT_THAT(error("a 1 0 0 0 0 0 0\nb 1 0 0 0 0 0\n"),
              StartsWith("p:2: expected 'stem qw"));
  EXPECT_THAT(error("a 1 0 0 0 0 0 0 525 1\n"), StartsWith("p:1: "));
  EXPECT_THAT(error("a 1 0 0 nan 0 0 0\n"), HasSubstr("'nan' is not a finite"));
  EXPECT_THAT(error("a 1 0 0 0 inf 0 0\n"), HasSubstr("'inf'"));
  EXPECT_THAT(error("a 1 0 0 0 zero 0 0\n"), HasSubstr("'zero'"));
  EXPECT_THAT(error("\na 0.9 0 0 0 0 0 0\n"), StartsWith("p:2: "));
  EXPECT_THAT(error("a 1 0 0 0 0 0 0 0\n"), HasSubstr("focal length"));
  EXPECT_THAT(error("a 1 0 0 0 0 0 0\na.color.jpg 1 0 0 0 0 0 0\n"),
              HasSubstr("already in line 1"));
}

TEST(ParsePoseMatrixTest, ReadsWorldFromCamera) {
  const auto pose =
      ParsePoseMatrix("0 -1 0 4\t\r\n1 0 0 5\n0 0 1 6\n\n0 0 0 1\n", "m");
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_EQ(pose->translation, (geometry::Vec3{4, 5, 6}));
  const geometry::Vec3 x = pose->rotation * geometry::Vec3{1, 0, 0};
  EXPECT_NEAR(x.y, 1, 1e-12);
}

TEST(ParsePoseMatrixTest, ASlightlyScaledRotationIsMadeOne) {
  const auto pose =
      ParsePoseMatrix("1.01 0 0 0\n0 1.01 0 0\n0 0 1.01 0\n0 0 0 1\n", "m");
  ASSERT_TRUE(pose.ok()) << pose.status();
  const geometry::Rotation3& q = pose->rotation;
  EXPECT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1, 1e-12);
}

TEST(ParsePoseMatrixTest, ErrorsNameFileAndLine) {
  const auto error = [](const char* text) {
    return ErrorOf(ParsePoseMatrix(text, "m"));
  };
  EXPECT_THAT(error("1 0 0 0\n0 1 0 0\n0 0 1 0\n"), HasSubstr("found 3"));
  EXPECT_THAT(error("1 0 0 0\n0 1 0\n0 0 1 0\n0 0 0 1\n"), StartsWith("m:2: "));
  EXPECT_THAT(error("1 0 0 0\n0 1 0 0\n0 0 1 nan\n0 0 0 1\n"),
              StartsWith("m:3: 'nan'"));
  EXPECT_THAT(error("1 0 0 0\n0 2 0 0\n0 0 1 0\n0 0 0 1\n"), StartsWith("m: "));
  EXPECT_THAT(error("1 0 0 0\n0 1 0 0\n0 0 -1 0\n0 0 0 1\n"),
              StartsWith("m: "));
  EXPECT_THAT(error(""), HasSubstr("found 0"));
}

TEST(ParseTimedFilesTest, SortsByTimeAndKeepsTheStampAsWritten) {
  const auto files =
      ParseTimedFiles("# t f\n2.50 rgb/b.png\n1.5 rgb/a.png\n", "r");
  ASSERT_TRUE(files.ok()) << files.status();
  ASSERT_EQ(files->size(), 2u);
  EXPECT_EQ((*files)[0].path, "rgb/a.png");
  EXPECT_EQ((*files)[1].stem, "2.50");
  EXPECT_EQ((*files)[1].time, 2500000000);
  EXPECT_EQ((*files)[1].line, 2);
}

TEST(ParseTimedFilesTest, ErrorsNameFileAndLine) {
  const auto error = [](const char* text) {
    return ErrorOf(ParseTimedFiles(text, "r"));
  };
  EXPECT_THAT(error("1.0 a\n2.0\n"), StartsWith("r:2: "));
  EXPECT_THAT(error("one a\n"), HasSubstr("'one' is not a time stamp"));
  EXPECT_THAT(error("1.0 a\n2 b\n1 c\n"), StartsWith("r:3: the time 1 was"));
  EXPECT_THAT(error("1.0 ../../a\n"), HasSubstr("leads out"));
}

TEST(ParseTimedPosesTest, ReadsTranslationThenQuaternionWithWLast) {
  const auto poses =
      ParseTimedPoses("1.5 1 2 3 0 0 0.70710678 0.70710678\n", "g");
  ASSERT_TRUE(poses.ok()) << poses.status();
  const geometry::Rigid3& pose = (*poses)[0].world_from_camera;
  EXPECT_EQ(pose.translation, (geometry::Vec3{1, 2, 3}));
  EXPECT_NEAR((pose.rotation * geometry::Vec3{1, 0, 0}).y, 1, 1e-7);
}

TEST(ParseTimedPosesTest, ErrorsNameFileAndLine) {
  const auto error = [](const char* text) {
    return ErrorOf(ParseTimedPoses(text, "g"));
  };
  EXPECT_THAT(error("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0\n"), StartsWith("g:2: "));
  EXPECT_THAT(error("1 nan 0 0 0 0 0 1\n"), HasSubstr("'nan'"));
  EXPECT_THAT(error("1 0 0 0 0 0 0 2\n"), StartsWith("g:1: "));
  EXPECT_THAT(error("x 0 0 0 0 0 0 1\n"), HasSubstr("time stamp"));
}

TEST(FormatPoseMatrixTest, IsReadBackAsItWas) {
  const geometry::Rigid3 pose{
      geometry::Rotation3::FromAxisAngle({0.3, -0.2, 0.1}), {1, -2, 3.5}};
  const auto matrix = ParsePoseMatrix(FormatPoseMatrix(pose), "pose.txt");
  ASSERT_TRUE(matrix.ok()) << matrix.status();
  EXPECT_LT(geometry::AngleBetween_rad(matrix->rotation, pose.rotation), 1e-9);
  EXPECT_LT(geometry::Norm(matrix->translation - pose.translation), 1e-9);
}

TEST(FormatTimedPosesTest, IsReadBackAsItWas) {
  const std::vector<TimedPose> poses = {
      {.time = 1305031241529758123,
       .world_from_camera = {.rotation = geometry::Rotation3::FromAxisAngle(
                                 {0.1, -2, 1}),
                             .translation = {1.25, -2.5, 3}}},
      {.time = 1305031242000000007, .world_from_camera = {}}};
  const auto read = ParseTimedPoses(FormatTimedPoses(poses), "g");
  ASSERT_TRUE(read.ok()) << read.status();
  ASSERT_EQ(read->size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ((*read)[i].time, poses[i].time);
    const geometry::PoseError error = geometry::ErrorBetween(
        (*read)[i].world_from_camera, poses[i].world_from_camera);
    EXPECT_LT(error.translation_m, 2e-9);
    EXPECT_LT(error.rotation_rad, 1e-8);
  }
}

}  // namespace
}  // namespace treeline::dataset
