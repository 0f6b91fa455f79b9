#include "server/tools/learning/learn_source.h"

#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::learning {
namespace {

using testing::HasSubstr;

class LearnSourceTest : public testing::Test {
 protected:
  LearnSource Find(const std::string& path) const {
    const auto source = FindLearnSource(path);
    EXPECT_TRUE(source.ok()) << source.status();
    return source.value_or(LearnSource{});
  }

  const base::TestingFolder folder_;
};

TEST_F(LearnSourceTest, LayoutsOfDataSetsAreKnownByTheirFolders) {
  folder_.Write("seven/seq-01/frame-000000.color.jpg", "");
  folder_.Write("tum/rgb.txt", "");
  folder_.Write("twelve/info.txt", "");
  folder_.Write("twelve/data/frame-000000.color.jpg", "");
  folder_.Write("photos/model/images.bin", "");
  folder_.Write("photos/images/a.jpg", "");
  EXPECT_EQ(Find(folder_.Path("seven/")).uri,
            "7scenes:" + folder_.Path("seven"));
  EXPECT_EQ(Find(folder_.Path("tum")).uri, "tum:" + folder_.Path("tum"));
  EXPECT_EQ(Find(folder_.Path("twelve")).uri,
            "12scenes:" + folder_.Path("twelve"));
  EXPECT_EQ(Find(folder_.Path("photos")).uri,
            "colmap:" + folder_.Path("photos/model") + "," +
                folder_.Path("photos/images"));
  folder_.Write("splats/sparse/0/images.bin", "8 bytes.");
  folder_.Write("splats/images/a.jpg", "");
  EXPECT_EQ(Find(folder_.Path("splats")).uri,
            "colmap:" + folder_.Path("splats/sparse/0") + "," +
                folder_.Path("splats/images"));
  folder_.Write("splats/sparse/1/images.bin", "9 bytes..");
  EXPECT_EQ(Find(folder_.Path("splats")).uri,
            "colmap:" + folder_.Path("splats/sparse/1") + "," +
                folder_.Path("splats/images"))
      << "the larger model";
  folder_.Write("undistorted/sparse/images.txt", "# none");
  folder_.Write("undistorted/images/a.jpg", "");
  EXPECT_EQ(Find(folder_.Path("undistorted")).uri,
            "colmap:" + folder_.Path("undistorted/sparse") + "," +
                folder_.Path("undistorted/images"));
  folder_.Write("splats/transforms.json", "");
  EXPECT_EQ(Find(folder_.Path("splats")).kind, SourceKind::kCapture);
  EXPECT_EQ(Find("tum:" + folder_.Path("tum")).kind, SourceKind::kRecording);
}

TEST_F(LearnSourceTest, WhatLiesBesideARecordingIsFound) {
  folder_.Write("a/seq-01/frame-000000.color.jpg", "");
  folder_.Write("a/train.txt", "");
  EXPECT_EQ(Find(folder_.Path("a")).train_list, "") << "test.txt is missing";
  EXPECT_FALSE(Find(folder_.Path("a")).has_cameras);
  folder_.Write("a/test.txt", "");
  folder_.Write("a/cameras.json", "");
  const LearnSource source = Find("7scenes:" + folder_.Path("a"));
  EXPECT_EQ(source.train_list, folder_.Path("a/train.txt"));
  EXPECT_EQ(source.test_list, folder_.Path("a/test.txt"));
  EXPECT_TRUE(source.has_cameras);
}

TEST_F(LearnSourceTest, AMapBundleIsItsKeyframes) {
  folder_.Write("map/bundle.yaml", "name: cafe\n");
  const LearnSource source = Find(folder_.Path("map"));
  EXPECT_EQ(source.kind, SourceKind::kMapBundle);
  EXPECT_EQ(source.scene, "cafe");
  EXPECT_EQ(source.uri, "7scenes:" + folder_.Path("map/keyframes"));
  EXPECT_EQ(source.calibration_path,
            folder_.Path("map/keyframes/calibration.json"));
}

TEST_F(LearnSourceTest, AnythingElseThatIsThereIsACapture) {
  folder_.Write("capture.r3d", "");
  folder_.Write("stray/odometry.csv", "");
  EXPECT_EQ(Find(folder_.Path("capture.r3d")).kind, SourceKind::kCapture);
  EXPECT_EQ(Find(folder_.Path("stray")).kind, SourceKind::kCapture);
  EXPECT_TRUE(
      absl::IsNotFound(FindLearnSource(folder_.Path("nowhere")).status()));
}

TEST_F(LearnSourceTest, ScenesAreCalledAsTheirCaptures) {
  folder_.Write("my flat/odometry.csv", "");
  EXPECT_EQ(SceneNameOf(folder_.Path("my flat/")), "my-flat");
  EXPECT_EQ(SceneNameOf(folder_.Path("my flat/.")), "my-flat");
  EXPECT_EQ(SceneNameOf("captures/office.r3d"), "office");
  EXPECT_EQ(SceneNameOf("tum:data/desk"), "desk");
}

TEST_F(LearnSourceTest, WithoutPosesItSaysHowToGetThem) {
  const tools::SmallRecording without(3, {});
  const absl::Status status =
      CheckLearnable(without.Open(), "universal", "my-recording");
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(status.message(), HasSubstr("my-recording: no frame has a pose"));
  EXPECT_THAT(status.message(), HasSubstr("treeline-agent map --rgbd 7scenes:" +
                                          without.folder()));
  const tools::SmallRecording with(3, {{}, {}, {}});
  EXPECT_TRUE(CheckLearnable(with.Open(), "universal", "x").ok());
}

TEST_F(LearnSourceTest, SaysWhichFramesAreLeftOut) {
  const tools::SmallRecording all(3, {{}, {}, {}});
  EXPECT_EQ(LeftOutText(all.Open(), "universal"), "");
  const tools::SmallRecording two(3, {{}, {}});
  EXPECT_EQ(LeftOutText(two.Open(), "universal"),
            "1 frames without a pose, 0 without depth, of 3");
}

TEST_F(LearnSourceTest, WithoutDepthOrStructureItSaysWhatIsNeeded) {
  const tools::SmallRecording recording(3, {{}, {}, {}});
  EXPECT_THAT(CheckLearnable(recording.Open(), "sift", "x").message(),
              HasSubstr("structure from motion"));
}

}  // namespace
}  // namespace treeline::learning
