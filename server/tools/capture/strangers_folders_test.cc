// What people have of data sets and other programs, a bit wrong as it often is.
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/capture/open_capture.h"
#include "server/tools/capture/picture_files.h"
#include "server/tools/capture/posed_pictures.h"
#include "server/tools/capture/sens_file.h"
#include "server/tools/capture/testing_datasets.h"

namespace treeline::capture {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr int kFrames = 4;

class StrangersFoldersTest : public testing::Test {
 protected:
  static const TrueScene& Scene() {
    static const TrueScene* const scene = new TrueScene(MakeTrueScene(kFrames));
    return *scene;
  }
  std::string Path(const std::string& name) const { return folder_.Path(name); }
  absl::StatusOr<Capture> Open(const std::string& name) const {
    return OpenCapture(Path(name), "auto", {});
  }
  std::string ErrorOf(const std::string& name) const {
    return std::string(Open(name).status().message());
  }
  // Writes a file anew.
  void Replace(const std::string& name, const std::string& text) const {
    fs::remove(Path(name));
    folder_.Write(name, text);
  }

  const base::TestingFolder folder_;
};

TEST_F(StrangersFoldersTest, ASensFileThatIsCutOffIsReadAsFarAsItGoes) {
  const std::string bytes = SensBytes(Scene());
  folder_.Write("cut.sens", bytes.substr(0, bytes.size() * 2 / 3));
  const auto capture = Open("cut.sens");
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_EQ(capture->frames.size(), 2);
  EXPECT_THAT(capture->notes, Contains(HasSubstr("its last 2 frames")));
  EXPECT_TRUE(capture->pictures->Load(1).ok());
}

TEST_F(StrangersFoldersTest, WhereTrackingWasLostAFrameIsLeftOut) {
  std::string bytes = SensBytes(Scene());
  const float lost = -std::numeric_limits<float>::infinity();
  constexpr size_t kFirstPose = 4 + 8 + 15 + 4 * 64 + 2 * 4 + 4 * 4 + 4 + 8;
  for (size_t i = 0; i < 16; ++i) {
    bytes.replace(kFirstPose + 4 * i, 4, reinterpret_cast<const char*>(&lost),
                  4);
  }
  folder_.Write("lost.sens", bytes);
  const auto capture = Open("lost.sens");
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_EQ(capture->frames.size(), kFrames - 1);
  EXPECT_THAT(capture->left_out.Lines(),
              Contains(HasSubstr("tracking was lost (the first: frame 0)")));
}

TEST_F(StrangersFoldersTest, WhatIsNoSensFileOrPackedOtherwiseIsSaid) {
  const std::string bytes = SensBytes(Scene());
  folder_.Write("old.sens", "\x03" + bytes.substr(1));
  EXPECT_THAT(ErrorOf("old.sens"), HasSubstr("version 4"));
  std::string packed = bytes;
  constexpr size_t kDepthPacking = 4 + 8 + 15 + 4 * 64 + 4;
  packed[kDepthPacking] = 2;
  folder_.Write("packed.sens", packed);
  EXPECT_THAT(ErrorOf("packed.sens"), HasSubstr("SensReader"));
  folder_.Write("short.sens", bytes.substr(0, 100));
  EXPECT_THAT(ErrorOf("short.sens"), HasSubstr("cut off"));
  // The folder that it lies in.
  fs::create_directory(Path("scene0000_00"));
  folder_.Write("scene0000_00/scene0000_00.sens", bytes);
  EXPECT_THAT(
      ErrorOf("scene0000_00"),
      HasSubstr("Give the file: " + Path("scene0000_00/scene0000_00.sens")));
}

TEST_F(StrangersFoldersTest, TheCameraOfReplicaLiesAboveOrIsTheReleasedOne) {
  WriteReplica(Scene(), Path("Replica/room0"));
  fs::rename(Path("Replica/room0/cam_params.json"),
             Path("Replica/cam_params.json"));
  const auto above = Open("Replica/room0");
  ASSERT_TRUE(above.ok()) << above.status();
  EXPECT_EQ(above->frames[0].color, Scene().calibration.color);
  // Its pictures have not the released size.
  fs::remove(Path("Replica/cam_params.json"));
  EXPECT_THAT(ErrorOf("Replica/room0"),
              AllOf(HasSubstr("cam_params.json"), HasSubstr("\"w\": 256")));
}

TEST_F(StrangersFoldersTest, PosesThatAreMissingOrLostLeaveOutTheirFrames) {
  WriteReplica(Scene(), Path("room"));
  const std::string line = "1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n";
  Replace("room/traj.txt",
          absl::StrCat(line, absl::StrReplaceAll(line, {{"1", "inf"}}),
                       "1 2 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n"));
  const auto capture = Open("room");
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_EQ(capture->frames.size(), 1);
  EXPECT_THAT(
      capture->left_out.Lines(),
      AllOf(Contains(HasSubstr("tracking was lost")),
            Contains(HasSubstr("not rigid")), Contains(HasSubstr("no pose"))));
  Replace("room/traj.txt", line + "1 2 3\n");
  EXPECT_THAT(ErrorOf("room"), HasSubstr("traj.txt:2: expected the 16"));
}

TEST_F(StrangersFoldersTest, Open3dWithoutItsCameraIsPrimeSense) {
  WriteOpen3d(Scene(), Path("walk"));
  fs::remove(Path("walk/camera_intrinsic.json"));
  EXPECT_THAT(ErrorOf("walk"), AllOf(HasSubstr("camera_intrinsic.json"),
                                     HasSubstr("intrinsic_matrix")));
  for (const char* name : {"walk/color/000000.jpg"}) {
    Replace(name, *image::EncodeJpeg(
                      {640, 480, std::vector<uint8_t>(640 * 480 * 3, 90)}, 90));
  }
  const auto capture = Open("walk");
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_EQ(capture->frames[0].color.fx(), 525);
  EXPECT_THAT(capture->notes, Contains(HasSubstr("usual camera")));
}

TEST_F(StrangersFoldersTest, Open3dNeedsAsManyDepthMapsAsPictures) {
  WriteOpen3d(Scene(), Path("walk"));
  fs::remove(Path("walk/depth/000002.png"));
  EXPECT_THAT(ErrorOf("walk"), HasSubstr("4 pictures and 3 depth maps"));
}

TEST(PosedPicturesTest, LogsNameTheirFrames) {
  constexpr const char* kPose = "1 0 0 2\r\n0 1 0 0\r\n0 0 1 0\r\n0 0 0 1\r\n";
  const auto poses =
      ParsePoseLog(absl::StrCat("3 3 4\n", kPose, "7 7 8\n", kPose), "t.log");
  ASSERT_TRUE(poses.ok()) << poses.status();
  EXPECT_EQ(poses->size(), 2);
  EXPECT_EQ(poses->at(7)->translation.x, 2);
  const auto error = [](const std::string& text) {
    return std::string(ParsePoseLog(text, "t.log").status().message());
  };
  EXPECT_THAT(error(absl::StrCat("3 3 4\n", kPose, "3 3 4\n", kPose)),
              HasSubstr("t.log:6"));
  EXPECT_THAT(error("0 0 1\n1 0 0 0\n"), HasSubstr("t.log:1"));
  EXPECT_THAT(error(absl::StrCat("-1 0 1\n", kPose)), HasSubstr("t.log:1"));
  EXPECT_THAT(error(absl::StrCat("0.5 0 1\n", kPose)), HasSubstr("t.log:1"));
}

TEST_F(StrangersFoldersTest, PhotographsAreFoundInTheFolderThatHasMost) {
  for (const char* name : {"a.jpg", "b.JPEG", "c.HEIC"}) {
    folder_.Write(absl::StrCat("walk/images/", name), "");
    folder_.Write(absl::StrCat("walk/more/", name), "");
  }
  folder_.Write("walk/more/d.png", "");
  folder_.Write("walk/few/a.jpg", "");
  folder_.Write("walk/few/b.jpg", "");
  folder_.Write("walk/notes.txt", "");
  EXPECT_EQ(PhotographFolderIn(Path("walk")), Path("walk/more"));
  EXPECT_EQ(PhotographFolderIn(Path("walk/notes.txt")), Path("walk/more"));
  EXPECT_EQ(PhotographFolderIn(Path("walk/images")), Path("walk/images"));
  EXPECT_EQ(PhotographFolderIn(Path("walk/few")), "");
  EXPECT_THAT(ErrorOf("walk"), AllOf(HasSubstr("are in " + Path("walk/more")),
                                     HasSubstr("sparse/0 of COLMAP")));
}

}  // namespace
}  // namespace treeline::capture
