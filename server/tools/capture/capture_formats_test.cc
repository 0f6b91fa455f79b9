// What readers make of files that are broken, or meant to break them.
#include <array>
#include <filesystem>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/capture/arkit_json.h"
#include "server/tools/capture/open_capture.h"
#include "server/tools/capture/recording_writer.h"
#include "server/tools/capture/scannet.h"
#include "server/tools/capture/stray_scanner.h"
#include "server/tools/capture/testing_captures.h"
#include "server/tools/capture/transforms_json.h"
#include "server/tools/capture/video_reader.h"

namespace treeline::capture {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kIdentity = "[[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]";

std::string FrameJson(const std::string& members) {
  return absl::StrCat(R"({"transform_matrix":)", kIdentity, ",", members, "}");
}

absl::StatusOr<TransformsJson> Parse(const std::string& frames,
                                     const std::string& members = "") {
  return ParseTransforms(
      absl::StrCat(R"({"fl_x":500,"w":640,"h":480,)", members, R"("frames":[)",
                   frames, "]}"),
      "transforms.json",
      [](const std::string& /*path*/) {
        return absl::StatusOr<image::ImageSize>(image::ImageSize{640, 480});
      },
      [](const std::string& path) {
        return path == "images/a.jpg" || path == "depth/a.png";
      });
}

std::string ErrorOf(const std::string& frames,
                    const std::string& members = "") {
  const auto parsed = Parse(frames, members);
  EXPECT_EQ(parsed.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(parsed.status().message());
}

TEST(TransformsTest, CamerasOfFileAndFrame) {
  const auto parsed =
      Parse(absl::StrCat(
                FrameJson(R"("file_path":".\\b_10.jpg","fl_x":600,"k1":0.1)"),
                ",", FrameJson(R"("file_path":"b_9.jpg")")),
            R"("cx":300,"fl_y":510,)");
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  ASSERT_EQ(parsed->frames.size(), 2u);
  EXPECT_EQ(parsed->frames[0].file_path, "b_9.jpg");
  EXPECT_EQ(parsed->frames[0].camera.ToString(), "PINHOLE,500,510,299.5,239.5");
  EXPECT_EQ(parsed->frames[1].file_path, "b_10.jpg");
  EXPECT_EQ(parsed->frames[1].camera.ToString(),
            "OPENCV,600,510,299.5,239.5,0.1,0,0,0");
}

TEST(TransformsTest, PicturesThatStandTwiceAreNamed) {
  const std::string a = FrameJson(R"("file_path":"a.jpg")");
  const std::string b = FrameJson(R"("file_path":"b.jpg")");
  const std::string c = FrameJson(R"("file_path":"c.jpg")");
  const auto parsed =
      Parse(absl::StrCat(a, ",", a, ",", b, ",", c, ",", c), "");
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  ASSERT_EQ(parsed->frames.size(), 3u);
  EXPECT_EQ(parsed->frames[1].file_path, "b.jpg");
  EXPECT_EQ(parsed->frames[2].file_path, "c.jpg");
  EXPECT_THAT(parsed->left_out.Lines(),
              testing::ElementsAre("2 frames: its file_path is that of another "
                                   "frame (the first: a.jpg)"));
}

TEST(TransformsTest, FisheyeAndFieldOfView) {
  const auto fisheye =
      Parse(FrameJson(R"("file_path":"a.jpg")"),
            R"("camera_model":"OPENCV_FISHEYE","k1":0.01,"k4":0.002,)");
  ASSERT_TRUE(fisheye.ok()) << fisheye.status();
  EXPECT_EQ(fisheye->frames[0].camera.ToString(),
            "OPENCV_FISHEYE,500,500,319.5,239.5,0.01,0,0,0.002");
  // tan(pi / 4) = 1: the focal length is half the width.
  const auto angle = ParseTransforms(
      absl::StrCat(R"({"camera_angle_x":1.5707963267948966,"frames":[)",
                   FrameJson(R"("file_path":"a")"), "]}"),
      "transforms.json",
      [](const std::string& /*path*/) {
        return absl::StatusOr<image::ImageSize>(image::ImageSize{800, 600});
      },
      nullptr);
  ASSERT_TRUE(angle.ok()) << angle.status();
  EXPECT_NEAR(angle->frames[0].camera.fx(), 400, 1e-9);
  EXPECT_EQ(angle->frames[0].camera.cx(), 399.5);
}

TEST(TransformsTest, ScaleOfLengthsAndUnitOfDepth) {
  const auto parsed = Parse(
      R"({"file_path":"a.jpg","transform_matrix":[[1,0,0,2],[0,1,0,4],[0,0,1,6]]})",
      R"("applied_scale":2,"integer_depth_scale":0.0002,)");
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_EQ(parsed->frames[0].world_from_camera.translation,
            (geometry::Vec3{1, 2, 3}));
  // Depth has the unit of the lengths before they were scaled.
  EXPECT_DOUBLE_EQ(parsed->depth_unit_m, 0.0002);
}

TEST(TransformsTest, PathsStayInTheFolder) {
  for (const char* path :
       {"../../etc/passwd", "/etc/passwd", "a/../../b.jpg", "..\\\\b.jpg",
        "C:\\\\b.jpg", "/images/../../a.jpg"}) {
    const auto parsed =
        Parse(FrameJson(absl::StrCat(R"("file_path":")", path, "\"")));
    ASSERT_TRUE(parsed.ok()) << parsed.status();
    EXPECT_TRUE(parsed->frames.empty()) << path;
    EXPECT_THAT(parsed->left_out.Lines()[0],
                HasSubstr("put the JSON file into the folder"))
        << path;
  }
  for (const char* path : {"", "./", "a\\u0000.jpg"}) {
    EXPECT_THAT(
        ErrorOf(FrameJson(absl::StrCat(R"("file_path":")", path, "\""))),
        HasSubstr("transforms.json: frames[0]"))
        << path;
  }
}

// Written on another machine, and copied here.
TEST(TransformsTest, PathsThatLeadOutAreFoundInTheFolderByTheirEnds) {
  for (const char* path :
       {"/home/ann/scan/images/a.jpg", "C:\\\\scan\\\\images\\\\a.jpg",
        "../images/a.jpg", "../x/../images/a.jpg"}) {
    const auto parsed = Parse(FrameJson(
        absl::StrCat(R"("file_path":")", path,
                     R"(","depth_file_path":"/home/ann/scan/depth/a.png")")));
    ASSERT_TRUE(parsed.ok()) << parsed.status();
    ASSERT_EQ(parsed->frames.size(), 1u) << path;
    EXPECT_EQ(parsed->frames[0].file_path, "images/a.jpg");
    EXPECT_EQ(parsed->frames[0].depth_path, "depth/a.png");
    EXPECT_THAT(parsed->notes, testing::Contains(HasSubstr("2 paths lead")));
  }
  const auto without_depth = Parse(
      FrameJson(R"("file_path":"images/a.jpg","depth_file_path":"/d/b.png")"));
  ASSERT_TRUE(without_depth.ok()) << without_depth.status();
  EXPECT_EQ(without_depth->frames[0].depth_path, "");
  EXPECT_EQ(without_depth->frames[0].missing_depth, "/d/b.png");
}

TEST(TransformsTest, SaysWhatIsWrongAndWhatToDo) {
  EXPECT_THAT(ErrorOf(""), HasSubstr("has no \"frames\""));
  EXPECT_THAT(ErrorOf("7"), HasSubstr("frames[0]: is no object"));
  EXPECT_THAT(ErrorOf(FrameJson(R"("x":1)")), HasSubstr("no \"file_path\""));
  const std::string frame = FrameJson(R"("file_path":"a.jpg")");
  EXPECT_THAT(ErrorOf(frame, R"("camera_model":"EQUIRECTANGULAR",)"),
              HasSubstr("undistort the pictures"));
  EXPECT_THAT(ErrorOf(frame, R"("k4":0.1,)"), HasSubstr("undistort"));
  EXPECT_THAT(ErrorOf(frame, R"("cx":-5,)"), HasSubstr("principal point"));
  EXPECT_THAT(ErrorOf(frame, R"("cx":"five",)"), HasSubstr("finite number"));
  EXPECT_THAT(ErrorOf(frame, R"("applied_scale":0,)"), HasSubstr("positive"));
  EXPECT_THAT(ErrorOf(frame, R"("depth_unit_scale_factor":-1,)"),
              HasSubstr("metres per unit"));
  EXPECT_THAT(ErrorOf(FrameJson(R"("file_path":"a.jpg","w":1e9,"h":1)")),
              HasSubstr("whole number from 1 to 16384"));
}

TEST(TransformsTest, NestingIsBounded) {
  const std::string deep(100000, '[');
  const auto parsed = ParseTransforms(absl::StrCat(R"({"frames":)", deep),
                                      "x.json", nullptr, nullptr);
  EXPECT_THAT(parsed.status().message(), HasSubstr("nested"));
}

TEST(TransformsTest, BadPosesAndRepeatedFramesAreLeftOut) {
  const auto parsed = Parse(absl::StrCat(
      FrameJson(R"("file_path":"a.jpg")"), ",",
      FrameJson(R"("file_path":"a.jpg")"),
      R"(,{"file_path":"nan.jpg","transform_matrix":[[null,0,0,0],[0,1,0,0],[0,0,1,0]]})",
      R"(,{"file_path":"flat.jpg","transform_matrix":[[2,0,0,0],[0,1,0,0],[0,0,1,0]]})",
      R"(,{"file_path":"mirror.jpg","transform_matrix":[[-1,0,0,0],[0,1,0,0],[0,0,1,0]]})"));
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  EXPECT_EQ(parsed->frames.size(), 1u);
  EXPECT_THAT(
      parsed->left_out.Lines(),
      ElementsAre("1 frame: transform_matrix is no matrix of 16 finite numbers "
                  "(the first: nan.jpg)",
                  "2 frames: transform_matrix is not rigid (the first: "
                  "flat.jpg)",
                  "1 frame: its file_path is that of another frame (the "
                  "first: a.jpg)"));
}

TEST(StrayTest, NewerVersionsHaveIntrinsicsAndTheOldestNoHeader) {
  const auto newer = ParseStrayOdometry(
      "timestamp, frame, x, y, z, qx, qy, qz, qw, fx, fy, cx, cy, a, b\n"
      "5.1, 000007, 1, 2, 3, 0, 0, 0, 1, 500, 501, 320, 240, ,\n",
      "odometry.csv");
  ASSERT_TRUE(newer.ok()) << newer.status();
  ASSERT_EQ(newer->rows.size(), 1u);
  EXPECT_EQ(newer->rows[0].frame, "000007");
  EXPECT_EQ(newer->rows[0].video_frame, 0);
  EXPECT_EQ(newer->rows[0].intrinsics,
            (std::array<double, 4>{500, 501, 320, 240}));
  const auto oldest = ParseStrayOdometry(
      "1, 2, 3, 0, 0, 0, 1\n4, 5, 6, 0, 0, 0, 1", "odometry.csv");
  ASSERT_TRUE(oldest.ok()) << oldest.status();
  ASSERT_EQ(oldest->rows.size(), 2u);
  EXPECT_EQ(oldest->rows[1].frame, "000001");
  EXPECT_EQ(oldest->rows[1].world_from_camera.translation,
            (geometry::Vec3{4, 5, 6}));
}

TEST(StrayTest, BadLinesAreLeftOutAndKeepTheirPlaceInTheVideo) {
  const auto parsed = ParseStrayOdometry(
      "timestamp, frame, x, y, z, qx, qy, qz, qw\n"
      "1, 000000, nan, 0, 0, 0, 0, 0, 1\n"
      "2, 000001, 0, 0, 0, 0, 0, 0, 2\n"
      "3, 000002, 0, 0, 0, 0, 0, 0, 1\n"
      "3, 000003, 0, 0, 0, 0, 0, 0, 1\n"
      "4, 000004, 0, 0\n"
      "5, 000005, 0, 0, 0, 0, 0, 0, 1\n",
      "odometry.csv");
  ASSERT_TRUE(parsed.ok()) << parsed.status();
  ASSERT_EQ(parsed->rows.size(), 2u);
  EXPECT_EQ(parsed->rows[0].video_frame, 2);
  EXPECT_EQ(parsed->rows[1].video_frame, 5);
  EXPECT_EQ(parsed->left_out.count(), 4);
}

TEST(StrayTest, ErrorsNameTheLine) {
  EXPECT_THAT(ParseStrayOdometry("a, b\n1, 2\n", "o.csv").status().message(),
              HasSubstr("o.csv:1: has no column 'x'"));
  EXPECT_THAT(ParseStrayOdometry("frame, x, y, z, qx, qy, qz, qw\n"
                                 "../../etc/passwd, 0, 0, 0, 0, 0, 0, 1\n",
                                 "o.csv")
                  .status()
                  .message(),
              HasSubstr("o.csv:2: frame '../../etc/passwd' is no number"));
  EXPECT_THAT(ParseStrayCameraMatrix("1, 2, 3\n", "m.csv").status().message(),
              HasSubstr("m.csv: has 1 lines, not 3"));
  EXPECT_THAT(ParseStrayCameraMatrix("1,0,2\n0,x,3\n0,0,1\n", "m.csv")
                  .status()
                  .message(),
              HasSubstr("m.csv:2"));
}

TEST(ArkitJsonTest, ErrorsNameTheFileAndTheField) {
  EXPECT_THAT(ParsePolycamCamera("{}", "1.json").status().message(),
              HasSubstr("1.json: has no \"t_00\""));
  EXPECT_THAT(ParsePolycamCamera("[1]", "1.json").status().message(),
              HasSubstr("no object"));
  EXPECT_THAT(ParseScannerAppCamera(R"({"cameraPoseARFrame":[1,2]})",
                                    {640, 480}, "f.json")
                  .status()
                  .message(),
              HasSubstr("\"cameraPoseARFrame\" must be an array of 16"));
}

TEST(ScanNetTest, IntrinsicsOfAnotherShapeAreRefused) {
  EXPECT_THAT(
      ParseScanNetIntrinsic("1 2 3\n", {640, 480}, "i.txt").status().message(),
      HasSubstr("i.txt:1: expected 4 lines of 4 numbers"));
  EXPECT_FALSE(ParseScanNetIntrinsic("0 0 0 0\n0 0 0 0\n0 0 1 0\n0 0 0 1\n",
                                     {640, 480}, "i.txt")
                   .ok());
}

// Whole captures with something wrong in them.
class BrokenCaptureTest : public testing::Test {
 protected:
  BrokenCaptureTest() : scene_(MakeTrueScene(6)) {}

  absl::StatusOr<WrittenRecording> Import(
      const WriteOptions& options, const std::stop_token& stop = {}) const {
    auto capture = OpenCapture(folder_.Path("capture"), "auto", {});
    if (!capture.ok()) return capture.status();
    return WriteRecording(*std::move(capture), options, {}, stop);
  }
  absl::StatusOr<WrittenRecording> Import() const {
    return Import({.folder = folder_.Path("out"), .source = "capture"});
  }
  // What there is beside the capture.
  int OtherFolders() const {
    int count = -1;
    for (const auto& entry :
         std::filesystem::directory_iterator(folder_.path())) {
      count += entry.is_directory() ? 1 : 0;
    }
    return count;
  }

  const base::TestingFolder folder_;
  const TrueScene scene_;
};

TEST_F(BrokenCaptureTest, BrokenFilesAreLeftOutAndCounted) {
  WritePolycam(scene_, folder_.Path("capture"));
  const std::string keyframes = "capture/keyframes/";
  folder_.Write(keyframes + "corrected_images/5412300000.jpg", "no picture");
  folder_.Write(keyframes + "depth/5412333333.png", "no depth");
  std::filesystem::remove(
      folder_.Path(keyframes + "corrected_images/5412366666.jpg"));
  folder_.Write(keyframes + "corrected_cameras/5412399999.json", "{");
  const auto written = Import();
  ASSERT_TRUE(written.ok()) << written.status();
  EXPECT_EQ(written->frames, 2);
  EXPECT_EQ(written->left_out.count(), 4);
  const auto text = base::ReadFile(folder_.Path("out/recording.txt"));
  ASSERT_TRUE(text.ok());
  EXPECT_THAT(*text, HasSubstr("# left out: 2 frames: its files cannot be"));
}

TEST_F(BrokenCaptureTest, NothingLeftIsAnErrorAndLeavesNoFolder) {
  WriteScannerApp(scene_, folder_.Path("capture"));
  for (int i = 0; i < 6; ++i) {
    folder_.Write(absl::StrCat("capture/frame_0000", i, ".json"), "{}");
  }
  const auto written = Import();
  EXPECT_EQ(written.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(written.status().message(), HasSubstr("6 frames: its camera"));
  EXPECT_EQ(OtherFolders(), 0);
}

TEST_F(BrokenCaptureTest, StoppingLeavesNoFolder) {
  WriteStray(scene_, folder_.Path("capture"));
  std::stop_source stop;
  stop.request_stop();
  const auto written =
      Import({.folder = folder_.Path("out"), .source = "x"}, stop.get_token());
  EXPECT_EQ(written.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(OtherFolders(), 0);
}

TEST_F(BrokenCaptureTest, AFolderThatIsThereIsNotTouched) {
  WriteStray(scene_, folder_.Path("capture"));
  folder_.Write("out/precious.txt", "x");
  EXPECT_EQ(Import().status().code(), absl::StatusCode::kAlreadyExists);
  EXPECT_TRUE(base::ReadFile(folder_.Path("out/precious.txt")).ok());
}

TEST_F(BrokenCaptureTest, APlaylistIsNoVideo) {
  WriteStray(scene_, folder_.Path("capture"));
  folder_.Write("capture/rgb.mp4",
                "#EXTM3U\n#EXT-X-MEDIA-SEQUENCE:0\n#EXTINF:10.0,\n"
                "file:///etc/passwd\n#EXT-X-ENDLIST\n");
  EXPECT_THAT(Import().status().message(), HasSubstr("is no video"));
}

TEST_F(BrokenCaptureTest, AnEmptyVideoIsNamed) {
  folder_.Write("walk.mp4", "");
  const absl::Status status =
      VideoReader::Open(folder_.Path("walk.mp4")).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
  EXPECT_THAT(std::string(status.message()), HasSubstr("walk.mp4"));
  EXPECT_THAT(std::string(status.message()), HasSubstr("it is empty"));
}

TEST_F(BrokenCaptureTest, AVideoThatEndsEarlyLosesTheRest) {
  TrueScene shorter = scene_;
  shorter.frames.resize(4);
  shorter.world_from_camera.resize(4);
  WriteStrayVideo(shorter, folder_.Path("capture"));
  const auto video = base::ReadFile(folder_.Path("capture/rgb.mp4"));
  WriteStray(scene_, folder_.Path("capture"));
  folder_.Write("capture/rgb.mp4", *video);
  const auto written = Import();
  ASSERT_TRUE(written.ok()) << written.status();
  EXPECT_EQ(written->frames, 4);
  EXPECT_EQ(written->left_out.count(), 2);
}

TEST_F(BrokenCaptureTest, DepthThatIsNotThereIsOneNote) {
  WriteNerfstudio(scene_, folder_.Path("capture"));
  std::filesystem::remove_all(folder_.Path("capture/depths"));
  const auto written = Import();
  ASSERT_TRUE(written.ok()) << written.status();
  EXPECT_EQ(written->frames, 6);
  EXPECT_EQ(written->with_depth, 0);
  EXPECT_THAT(written->notes,
              testing::Contains(HasSubstr("6 frames without their depth, the "
                                          "first depths/frame_1.png")));
}

TEST_F(BrokenCaptureTest, LostTrackingOfScanNetIsLeftOut) {
  WriteScanNet(scene_, folder_.Path("capture"));
  folder_.Write("capture/pose/2.txt",
                "-inf -inf -inf -inf\n-inf -inf -inf -inf\n"
                "-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  const auto written = Import();
  ASSERT_TRUE(written.ok()) << written.status();
  EXPECT_EQ(written->frames, 5);
  EXPECT_THAT(written->left_out.Lines().front(),
              HasSubstr("tracking was lost"));
}

TEST_F(BrokenCaptureTest, AnR3dFileIsReadLikeItsFolder) {
  WriteRecord3d(scene_, folder_.Path("unpacked"));
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(
           folder_.Path("unpacked"))) {
    if (!entry.is_regular_file()) continue;
    files.emplace_back(
        std::filesystem::relative(entry.path(), folder_.Path("unpacked")),
        base::ReadFile(entry.path()).value());
  }
  const std::string path = folder_.Write("scan.r3d", ZipOf(files));
  auto capture = OpenCapture(path, "auto", {});
  ASSERT_TRUE(capture.ok()) << capture.status();
  const auto written =
      WriteRecording(*std::move(capture),
                     {.folder = folder_.Path("out"), .source = path}, {}, {});
  ASSERT_TRUE(written.ok()) << written.status();
  EXPECT_EQ(written->frames, 6);
  EXPECT_EQ(written->with_depth, 6);
}

TEST_F(BrokenCaptureTest, WhatPeopleOftenHaveInsteadIsAdvisedOn) {
  const auto advice = [&](const std::string& path) {
    return std::string(
        OpenCapture(folder_.Path(path), "auto", {}).status().message());
  };
  folder_.Write("a.db", "x");
  EXPECT_THAT(advice("a.db"), HasSubstr("RTAB-Map"));
  folder_.Write("blender/transforms_train.json", "{}");
  EXPECT_THAT(advice("blender"), HasSubstr("blender/transforms_train.json"));
  folder_.Write("unzipped/2fd1a8b0c3/odometry.csv", "x");
  EXPECT_THAT(advice("unzipped"), HasSubstr("unzipped/2fd1a8b0c3"));
  folder_.Write("euroc/mav0/cam0/data/1.png", "x");
  EXPECT_THAT(advice("euroc"), HasSubstr("euroc/mav0/cam0/data"));
}

TEST_F(BrokenCaptureTest, UnknownFormatsAreToldWhatIsKnown) {
  folder_.Write("capture/holiday.jpg", "x");
  const auto written = Import();
  EXPECT_THAT(written.status().message(), HasSubstr("none of these formats"));
  EXPECT_THAT(written.status().message(), HasSubstr("structure from motion"));
  EXPECT_EQ(OpenCapture(folder_.Path("nowhere"), "auto", {}).status().code(),
            absl::StatusCode::kNotFound);
  EXPECT_THAT(
      OpenCapture(folder_.Path("capture"), "polycan", {}).status().message(),
      HasSubstr("none of auto, stray"));
}

}  // namespace
}  // namespace treeline::capture
