#include "server/core/localizer/stated_camera.h"

#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"

namespace treeline::localizer {
namespace {

camera::Camera CameraOf(const std::string& text, int width, int height) {
  return camera::Camera::Parse(text, width, height).value();
}

const camera::Camera& Learnt() {
  static const auto& camera =
      *new camera::Camera(CameraOf("PINHOLE,525,525,320,240", 640, 480));
  return camera;
}

TEST(MayBeGuessedTest, IsNotTheScenesCamera) {
  EXPECT_FALSE(MayBeGuessed(Learnt(), Learnt()));
  // Resized, and held upright.
  EXPECT_FALSE(
      MayBeGuessed(CameraOf("PINHOLE,262,262,160,120", 320, 240), Learnt()));
  EXPECT_FALSE(
      MayBeGuessed(CameraOf("PINHOLE,525,525,240,320", 480, 640), Learnt()));
}

TEST(MayBeGuessedTest, IsAnotherFocalLengthInTheMiddle) {
  for (const double focal : {440, 500, 551, 700}) {
    EXPECT_TRUE(MayBeGuessed(
        CameraOf(absl::StrCat("PINHOLE,", focal, ",", focal, ",320,240"), 640,
                 480),
        Learnt()))
        << focal;
  }
  // A page that assumes a field of view of 65 degrees.
  EXPECT_TRUE(
      MayBeGuessed(CameraOf("PINHOLE,1005,1005,640,360", 1280, 720), Learnt()));
}

TEST(MayBeGuessedTest, IsNotAWindowOfTheScenesPictures) {
  // In the middle, and at an edge.
  EXPECT_FALSE(
      MayBeGuessed(CameraOf("PINHOLE,525,525,160,120", 320, 240), Learnt()));
  EXPECT_FALSE(
      MayBeGuessed(CameraOf("PINHOLE,525,525,0,240", 320, 240), Learnt()));
  // As large as none of them.
  EXPECT_TRUE(
      MayBeGuessed(CameraOf("PINHOLE,525,525,400,300", 800, 600), Learnt()));
}

TEST(MayBeCutElsewhereTest, IsAWindowOfWhichTheMiddleIsStated) {
  for (const char* middle : {"160,120", "159.5,119.5"}) {
    EXPECT_TRUE(MayBeCutElsewhere(
        CameraOf(absl::StrCat("PINHOLE,525,525,", middle), 320, 240),
        Learnt()));
  }
  EXPECT_FALSE(MayBeCutElsewhere(CameraOf("PINHOLE,525,525,155,123", 320, 240),
                                 Learnt()));
  // Another zoom, the picture itself, resized, and a larger one.
  EXPECT_FALSE(MayBeCutElsewhere(CameraOf("PINHOLE,600,600,160,120", 320, 240),
                                 Learnt()));
  EXPECT_FALSE(MayBeCutElsewhere(Learnt(), Learnt()));
  EXPECT_FALSE(MayBeCutElsewhere(CameraOf("PINHOLE,262,262,160,120", 320, 240),
                                 Learnt()));
  EXPECT_FALSE(MayBeCutElsewhere(CameraOf("PINHOLE,525,525,400,300", 800, 600),
                                 Learnt()));
}

TEST(MayBeGuessedTest, IsNotAWindowOfOtherPictures) {
  EXPECT_FALSE(
      MayBeGuessed(CameraOf("PINHOLE,900,900,100,400", 640, 480), Learnt()));
  // As lenses are mounted.
  EXPECT_TRUE(
      MayBeGuessed(CameraOf("PINHOLE,900,900,330,250", 640, 480), Learnt()));
}

std::vector<std::string> Centred(const std::string& text, int width,
                                 int height) {
  std::vector<std::string> texts;
  for (const camera::Camera& camera :
       CentredCameras(CameraOf(text, width, height), Learnt())) {
    EXPECT_EQ(camera.width(), width);
    texts.push_back(camera.ToString());
  }
  return texts;
}

TEST(CentredCamerasTest, IntrinsicsOfAnotherResolutionMayBeMeant) {
  // Of pictures twice as large, and of half the size.
  EXPECT_EQ(Centred("PINHOLE,1050,1050,639.5,479.5", 640, 480),
            (std::vector<std::string>{"PINHOLE,525,525,319.5,239.5",
                                      "PINHOLE,1050,1050,319.5,239.5"}));
  EXPECT_EQ(Centred("PINHOLE,262.5,262.5,159.5,119.5", 640, 480).front(),
            "PINHOLE,525,525,319.5,239.5");
}

TEST(CentredCamerasTest, ThePrincipalPointMayBeWrong) {
  const std::vector<std::string> middle = {"PINHOLE,525,525,319.5,239.5"};
  EXPECT_EQ(Centred("PINHOLE,525,525,240,320", 640, 480), middle) << "cy, cx";
  EXPECT_EQ(Centred("PINHOLE,525,525,380,240", 640, 480), middle);
  EXPECT_EQ(Centred("PINHOLE,525,525,-100,240", 640, 480), middle);
  EXPECT_EQ(Centred("PINHOLE,525,525,0.5,0.5", 640, 480), middle) << "absurd";
  EXPECT_EQ(Centred("OPENCV,525,525,380,240,0.1,0,0,0", 640, 480),
            (std::vector<std::string>{"OPENCV,525,525,319.5,239.5,0.1,0,0,0"}));
}

TEST(CentredCamerasTest, OneThatIsNearTheMiddleOrTheScenesIsNotDoubted) {
  EXPECT_TRUE(Centred("PINHOLE,525,525,330,230", 640, 480).empty());
  EXPECT_TRUE(Centred("PINHOLE,400,400,350,240", 640, 480).empty());
  const camera::Camera window = CameraOf("PINHOLE,525,525,100,240", 640, 480);
  EXPECT_TRUE(CentredCameras(window, window).empty());
  EXPECT_TRUE(
      CentredCameras(CameraOf("PINHOLE,262,262,50,120", 320, 240), window)
          .empty());
}

TEST(MayBeGuessedTest, IsNotALensWhoseDistortionIsKnown) {
  const std::string lens = "OPENCV,600,600,320,240,-0.1,0,0,0";
  EXPECT_FALSE(MayBeGuessed(CameraOf(lens, 640, 480), Learnt()));
  // That of the scene's camera at another focal length says nothing new.
  EXPECT_TRUE(
      MayBeGuessed(CameraOf(lens, 640, 480),
                   CameraOf("OPENCV,525,525,320,240,-0.1,0,0,0", 640, 480)));
  EXPECT_FALSE(
      MayBeGuessed(CameraOf(lens, 640, 480),
                   CameraOf("OPENCV,525,525,320,240,-0.2,0,0,0", 640, 480)));
  EXPECT_TRUE(
      MayBeGuessed(CameraOf("PINHOLE,600,600,320,240", 640, 480),
                   CameraOf("OPENCV,525,525,320,240,-0.2,0,0,0", 640, 480)));
}

TEST(NarrownessTest, IsOfTheViewWhateverTheResolution) {
  EXPECT_DOUBLE_EQ(Narrowness(Learnt(), Learnt()), 1);
  EXPECT_DOUBLE_EQ(
      Narrowness(CameraOf("PINHOLE,525,525,9,9", 320, 240), Learnt()), 2);
  EXPECT_DOUBLE_EQ(
      Narrowness(CameraOf("PINHOLE,1050,1050,9,9", 1280, 960), Learnt()), 1);
  EXPECT_DOUBLE_EQ(
      Narrowness(CameraOf("PINHOLE,300,300,320,240", 640, 480), Learnt()), 1);
}

TEST(FeatureReductionTest, KeepsTheSizeOfFeaturesInTheScene) {
  // 640 x 480 is searched at half its size.
  EXPECT_EQ(FeatureReduction(Learnt(), Learnt()), 2);
  // A window of it, too; half of it as it is.
  EXPECT_EQ(
      FeatureReduction(CameraOf("PINHOLE,525,525,9,9", 320, 240), Learnt()), 2);
  EXPECT_EQ(
      FeatureReduction(CameraOf("PINHOLE,262,262,9,9", 320, 240), Learnt()), 1);
  EXPECT_EQ(
      FeatureReduction(CameraOf("PINHOLE,1050,1050,9,9", 640, 480), Learnt()),
      4);
}

TEST(FeatureReductionTest, LeavesSomethingOfThePicture) {
  EXPECT_EQ(
      FeatureReduction(CameraOf("PINHOLE,9000,9000,9,9", 640, 480), Learnt()),
      5);
  EXPECT_EQ(
      FeatureReduction(CameraOf("PINHOLE,525,525,9,9", 100, 60), Learnt()), 1);
}

}  // namespace
}  // namespace treeline::localizer
