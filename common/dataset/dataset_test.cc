#include "common/dataset/dataset.h"

#include <filesystem>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/testing_folder.h"
#include "common/camera/calibration_json.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

constexpr char kIdentity[] = "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n";

image::ColorImage FlatColor(int width, int height, uint8_t value) {
  return {.width = width,
          .height = height,
          .rgb = std::vector<uint8_t>(static_cast<size_t>(3 * width * height),
                                      value)};
}

image::DepthImage FlatDepth(int width, int height, uint16_t value) {
  return {.width = width,
          .height = height,
          .values = std::vector<uint16_t>(static_cast<size_t>(width * height),
                                          value)};
}

class DatasetTest : public ::testing::Test {
 protected:
  void Write(const std::string& name, const std::string& contents) const {
    folder_.Write(name, contents);
  }
  void WriteSevenScenesFrame(const std::string& stem, double x_m,
                             uint8_t color = 100, uint16_t depth = 1500) const {
    Write(stem + ".color.png", *image::EncodePng(FlatColor(640, 480, color)));
    Write(stem + ".depth.png",
          *image::EncodeDepthPng(FlatDepth(640, 480, depth)));
    Write(stem + ".pose.txt",
          absl::StrCat("1 0 0 ", x_m, "\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"));
  }

  DatasetOptions SevenScenes() const {
    return {.uri = absl::StrCat("7scenes:", folder_.path())};
  }
  DatasetOptions Tum() const {
    return {.uri = absl::StrCat("tum:", folder_.path())};
  }

  static std::string ErrorOf(const DatasetOptions& options,
                             absl::StatusCode code) {
    const absl::StatusOr<Dataset> dataset = Dataset::Open(options);
    EXPECT_EQ(dataset.status().code(), code) << dataset.status();
    return std::string(dataset.status().message());
  }

  const base::TestingFolder folder_;
};

TEST_F(DatasetTest, SevenScenesWithoutAListReadsAllSequencesInOrder) {
  WriteSevenScenesFrame("seq-02/frame-000000", 3);
  WriteSevenScenesFrame("seq-01/frame-000010", 2, 101, 1700);
  WriteSevenScenesFrame("seq-01/frame-000009", 1);
  Write("seq-01/notes.txt", "not a frame");
  Write("other/frame-000000.color.png", "not a sequence");
  const auto dataset = Dataset::Open(SevenScenes());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->frame(0).stem, "seq-01/frame-000009");
  EXPECT_EQ(dataset->frame(1).stem, "seq-01/frame-000010");
  EXPECT_EQ(dataset->frame(2).stem, "seq-02/frame-000000");
  EXPECT_EQ(dataset->frame(1).world_from_camera->translation.x, 2);
  EXPECT_FALSE(dataset->depth_is_registered());
  EXPECT_EQ(dataset->calibration().pose_sensor, camera::RgbdSensor::kDepth);
  EXPECT_EQ(dataset->calibration().depth.ToString(), "PINHOLE,585,585,320,240");
  EXPECT_EQ(dataset->calibration().color.ToString(), "PINHOLE,525,525,320,240");
  EXPECT_EQ(dataset->calibration().color_from_depth, geometry::Rigid3{});

  const auto frame = dataset->Load(1);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->color.rgb[0], 101);
  ASSERT_TRUE(frame->depth.has_value());
  EXPECT_EQ(frame->depth->values[0], 1700);
  EXPECT_EQ(frame->depth->unit_m, 0.001);
  EXPECT_FALSE(frame->calibration.has_value());
}

TEST_F(DatasetTest, TumDepthOfAnotherCameraNeedsAFileThatSaysWhereThatIs) {
  Write("rgb.txt", "1.0 a.png\n");
  Write("depth.txt", "1.0 b.png\n");
  Write("groundtruth.txt", "0.99 0 0 0 0 0 0 1\n1.01 0 0 0 0 0 0 1\n");
  Write("a.png", *image::EncodePng(FlatColor(640, 480, 9)));
  Write("b.png", *image::EncodeDepthPng(FlatDepth(320, 240, 5000)));
  const auto registered = Dataset::Open(Tum());
  ASSERT_TRUE(registered.ok()) << registered.status();
  EXPECT_THAT(std::string(registered->Load(0).status().message()),
              AllOf(HasSubstr("b.png"), HasSubstr("320 x 240"),
                    HasSubstr("cameras.json"), HasSubstr("color_from_depth")));
  camera::RgbdCalibration cameras;
  cameras.depth = *camera::Camera::Parse("PINHOLE,290,290,160,120", 320, 240);
  cameras.color_from_depth.translation.x = 0.02;
  cameras.pose_sensor = camera::RgbdSensor::kColor;
  Write("cameras.json", camera::CalibrationToJson(cameras));
  const auto apart = Dataset::Open(Tum());
  ASSERT_TRUE(apart.ok()) << apart.status();
  EXPECT_FALSE(apart->depth_is_registered());
  EXPECT_TRUE(apart->states_its_cameras());
  EXPECT_EQ(apart->calibration(), cameras);
  const auto frame = apart->Load(0);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->depth->width, 320);
  EXPECT_EQ(frame->depth->unit_m, 0.0002);
  Write("cameras.json", "{}");
  EXPECT_THAT(ErrorOf(Tum(), absl::StatusCode::kInvalidArgument),
              HasSubstr("cameras.json"));
}

TEST_F(DatasetTest, EncodedFilesDecodeToWhatLoadGives) {
  WriteSevenScenesFrame("seq-01/frame-000000", 0);
  const auto dataset = Dataset::Open(SevenScenes());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  const auto encoded = dataset->ReadEncoded(0);
  ASSERT_TRUE(encoded.ok()) << encoded.status();
  EXPECT_EQ(image::SniffFormat(encoded->color), image::ImageFormat::kPng);
  const auto decoded = dataset->Decode(*encoded);
  const auto loaded = dataset->Load(0);
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  ASSERT_TRUE(loaded.ok()) << loaded.status();
  EXPECT_EQ(decoded->color.rgb, loaded->color.rgb);
  EXPECT_EQ(decoded->depth->values, loaded->depth->values);
}

TEST_F(DatasetTest, ListOrderIsKeptAndJpegIsFound) {
  WriteSevenScenesFrame("seq-01/frame-000000", 0);
  Write("seq-01/frame-000001.color.jpg",
        *image::EncodeJpeg(FlatColor(640, 480, 50), 90));
  Write("list.txt", "seq-01/frame-000001\nseq-01/frame-000000\n");
  DatasetOptions options = SevenScenes();
  options.frame_list = folder_.Path("list.txt");
  const auto dataset = Dataset::Open(options);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 2);
  EXPECT_THAT(dataset->frame(0).color_path, EndsWith("000001.color.jpg"));
  // Neither depth nor pose on disk.
  EXPECT_EQ(dataset->frame(0).depth_path, "");
  EXPECT_FALSE(dataset->frame(0).world_from_camera.has_value());
  const auto frame = dataset->Load(0);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_FALSE(frame->depth.has_value());
}

TEST_F(DatasetTest, AStemThatIsNotThereIsNamedWithListLineAndFile) {
  WriteSevenScenesFrame("seq-01/frame-000000", 0);
  Write("list.txt", "seq-01/frame-000000\n# more\nseq-01/frame-000007\n");
  DatasetOptions options = SevenScenes();
  options.frame_list = folder_.Path("list.txt");
  EXPECT_THAT(
      ErrorOf(options, absl::StatusCode::kNotFound),
      AllOf(HasSubstr("list.txt:3: "), HasSubstr("'seq-01/frame-000007'"),
            HasSubstr("seq-01/frame-000007.color.png")));
}

TEST_F(DatasetTest, FramesWithoutFoldersAreNotADataset) {
  WriteSevenScenesFrame("seq-01/frame-000000", 0);
  DatasetOptions options = SevenScenes();
  options.uri += "/seq-01";
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kNotFound),
              HasSubstr("no frames in seq-*"));
}

TEST_F(DatasetTest, MalformedPosesAreNamed) {
  WriteSevenScenesFrame("seq-01/frame-000000", 0);
  Write("seq-01/frame-000000.pose.txt",
        "1 0 0 0\n0 1 0 nan\n0 0 1 0\n0 0 0 1\n");
  EXPECT_THAT(ErrorOf(SevenScenes(), absl::StatusCode::kInvalidArgument),
              HasSubstr("frame-000000.pose.txt:2: 'nan'"));
  Write("seq-01/frame-000000.pose.txt", "1 1 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  EXPECT_THAT(ErrorOf(SevenScenes(), absl::StatusCode::kInvalidArgument),
              HasSubstr("frame-000000.pose.txt: "));
}

TEST_F(DatasetTest, APoseFileReplacesPosesAndFocalLength) {
  WriteSevenScenesFrame("seq-01/frame-000000", 1);
  WriteSevenScenesFrame("seq-01/frame-000001", 2);
  // Not even looked at.
  Write("seq-01/frame-000000.pose.txt", "broken");
  Write("poses.txt", "seq-01/frame-000000 1 0 0 0 -7 0 0 526\n");
  DatasetOptions options = SevenScenes();
  options.pose_file = folder_.Path("poses.txt");
  const auto dataset = Dataset::Open(options);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->frame(0).world_from_camera->translation.x, 7);
  // Frames that the file leaves out have no pose, not their old one.
  EXPECT_FALSE(dataset->frame(1).world_from_camera.has_value());
  EXPECT_EQ(dataset->calibration().pose_sensor, camera::RgbdSensor::kColor);
  EXPECT_EQ(dataset->calibration().color.ToString(), "PINHOLE,526,526,320,240");

  options.color_camera = "SIMPLE_PINHOLE,530,321,241";
  EXPECT_EQ(Dataset::Open(options)->calibration().color.fx(), 530);
}

TEST_F(DatasetTest, APoseFileForOtherFramesIsAnError) {
  WriteSevenScenesFrame("seq-01/frame-000000", 1);
  Write("poses.txt", "seq-02/frame-000000 1 0 0 0 0 0 0\n");
  DatasetOptions options = SevenScenes();
  options.pose_file = folder_.Path("poses.txt");
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kInvalidArgument),
              HasSubstr("'seq-01/frame-000000'"));
}

TEST_F(DatasetTest, FocalLengthsOfDifferentCamerasAreAnError) {
  WriteSevenScenesFrame("seq-01/frame-000000", 1);
  WriteSevenScenesFrame("seq-01/frame-000001", 1);
  Write("poses.txt",
        "seq-01/frame-000000 1 0 0 0 0 0 0 525\n"
        "seq-01/frame-000001 1 0 0 0 0 0 0 600\n");
  DatasetOptions options = SevenScenes();
  options.pose_file = folder_.Path("poses.txt");
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kInvalidArgument),
              HasSubstr("525 to 600"));
}

TEST_F(DatasetTest, GivenCamerasAndUnitAreUsed) {
  WriteSevenScenesFrame("seq-01/frame-000000", 1);
  DatasetOptions options = SevenScenes();
  options.color_camera = "OPENCV,520,521,318,242,0.1,0,0,0";
  options.depth_camera = "PINHOLE,580,581,319,241";
  options.depth_unit_m = 0.0002;
  const auto dataset = Dataset::Open(options);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->calibration().color.ToString(), options.color_camera);
  EXPECT_EQ(dataset->calibration().depth.ToString(), options.depth_camera);
  EXPECT_EQ(dataset->depth_unit_m(), 0.0002);
  EXPECT_EQ(dataset->Load(0)->depth->unit_m, 0.0002);
}

TEST_F(DatasetTest, CamerasBesideTheFramesAreTaken) {
  WriteSevenScenesFrame("seq-01/frame-000000", 1);
  camera::RgbdCalibration cameras;
  cameras.color = *camera::Camera::Parse("PINHOLE,500,501,322,241", 640, 480);
  cameras.depth = *camera::Camera::Parse("PINHOLE,510,511,323,242", 640, 480);
  Write("cameras.json", camera::CalibrationToJson(cameras));
  const auto dataset = Dataset::Open(SevenScenes());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->calibration(), cameras);
  EXPECT_TRUE(dataset->states_its_cameras());
  DatasetOptions options = SevenScenes();
  options.color_camera = "PINHOLE,600,600,320,240";
  EXPECT_EQ(Dataset::Open(options)->calibration().color.fx(), 600);
  Write("cameras.json", "{}");
  EXPECT_THAT(ErrorOf(SevenScenes(), absl::StatusCode::kInvalidArgument),
              HasSubstr("cameras.json"));
}

TEST_F(DatasetTest, DefaultsHoldForTheirImageSizeOnly) {
  Write("seq-01/frame-000000.color.png",
        *image::EncodePng(FlatColor(320, 240, 9)));
  Write("seq-01/frame-000000.pose.txt", kIdentity);
  EXPECT_THAT(ErrorOf(SevenScenes(), absl::StatusCode::kInvalidArgument),
              HasSubstr("give the colour camera"));
  DatasetOptions options = SevenScenes();
  options.color_camera = "PINHOLE,260,260,160,120";
  const auto dataset = Dataset::Open(options);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->calibration().color.width(), 320);
}

TEST_F(DatasetTest, AnImageOfAnotherSizeIsAnErrorThatNamesTheFile) {
  WriteSevenScenesFrame("seq-01/frame-000000", 0);
  WriteSevenScenesFrame("seq-01/frame-000001", 0);
  WriteSevenScenesFrame("seq-01/frame-000002", 0);
  Write("seq-01/frame-000001.color.png",
        *image::EncodePng(FlatColor(639, 480, 9)));
  Write("seq-01/frame-000002.depth.png",
        *image::EncodeDepthPng(FlatDepth(640, 479, 9)));
  const auto dataset = Dataset::Open(SevenScenes());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_THAT(dataset->Load(1).status().message(),
              AllOf(HasSubstr("frame-000001.color.png"), HasSubstr("639")));
  EXPECT_THAT(dataset->Load(2).status().message(),
              AllOf(HasSubstr("frame-000002.depth.png"), HasSubstr("479")));
}

TEST_F(DatasetTest, AnEmptyDepthFileIsAnErrorNotAFrameWithoutDepth) {
  WriteSevenScenesFrame("seq-01/frame-000000", 0);
  WriteSevenScenesFrame("seq-01/frame-000001", 0);
  Write("seq-01/frame-000001.depth.png", "");
  const auto dataset = Dataset::Open(SevenScenes());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_THAT(dataset->Load(1).status().message(),
              AllOf(HasSubstr("frame-000001.depth.png"), HasSubstr("empty")));
}

TEST_F(DatasetTest, BadOptionsAreRefused) {
  WriteSevenScenesFrame("seq-01/frame-000000", 0);
  const auto error = [&](auto change, absl::StatusCode code) {
    DatasetOptions options = SevenScenes();
    change(options);
    return ErrorOf(options, code);
  };
  using enum absl::StatusCode;
  EXPECT_THAT(error([](auto& o) { o.uri = "/tmp"; }, kInvalidArgument),
              HasSubstr("7scenes:DIR"));
  EXPECT_THAT(error([](auto& o) { o.uri = "tum:"; }, kInvalidArgument),
              HasSubstr("no folder"));
  EXPECT_THAT(error([](auto& o) { o.uri = "7scenes:/none"; }, kNotFound),
              HasSubstr("/none"));
  EXPECT_THAT(error([](auto& o) { o.frame_list = "/none.txt"; }, kNotFound),
              HasSubstr("/none.txt"));
  EXPECT_THAT(error([](auto& o) { o.pose_file = "/none.txt"; }, kNotFound),
              HasSubstr("/none.txt"));
  EXPECT_THAT(error([](auto& o) { o.depth_unit_m = -1; }, kInvalidArgument),
              HasSubstr("depth unit"));
  EXPECT_THAT(
      error([](auto& o) { o.max_time_difference_s = 0; }, kInvalidArgument),
      HasSubstr("time difference"));
  EXPECT_THAT(
      error([](auto& o) { o.color_camera = "PINHOLE,1"; }, kInvalidArgument),
      HasSubstr("PINHOLE,1"));
}

class TumDatasetTest : public DatasetTest {
 protected:
  TumDatasetTest() {
    for (const char* name : {"rgb/a.png", "rgb/b.png", "rgb/c.png"}) {
      Write(name, *image::EncodePng(FlatColor(640, 480, 70)));
    }
    Write("depth/a.png", *image::EncodeDepthPng(FlatDepth(640, 480, 5000)));
    Write("depth/b.png", *image::EncodeDepthPng(FlatDepth(640, 480, 10000)));
    Write("rgb.txt",
          "# colour\n10.000 rgb/a.png\n10.100 rgb/b.png\n"
          "10.300 rgb/c.png\n");
    Write("depth.txt", "10.110 depth/b.png\n9.995 depth/a.png\n");
    Write("groundtruth.txt",
          "9.98 0 0 0 0 0 0 1\n10.02 4 0 0 0 0 0 1\n10.10 8 0 0 0 0 0 1\n");
  }
};

TEST_F(TumDatasetTest, AssociatesDepthAndInterpolatesPoses) {
  const auto dataset = Dataset::Open(Tum());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->frame(0).stem, "10.000");
  EXPECT_THAT(dataset->frame(0).depth_path, EndsWith("depth/a.png"));
  EXPECT_NEAR(dataset->frame(0).world_from_camera->translation.x, 2, 1e-12);
  EXPECT_THAT(dataset->frame(1).depth_path, EndsWith("depth/b.png"));
  EXPECT_EQ(dataset->frame(1).world_from_camera->translation.x, 8);
  // Too late for either.
  EXPECT_EQ(dataset->frame(2).depth_path, "");
  EXPECT_FALSE(dataset->frame(2).world_from_camera.has_value());

  EXPECT_TRUE(dataset->depth_is_registered());
  EXPECT_EQ(dataset->calibration().pose_sensor, camera::RgbdSensor::kColor);
  EXPECT_EQ(dataset->calibration().depth, dataset->calibration().color);
  EXPECT_EQ(dataset->Load(1)->depth->unit_m, 1.0 / 5000);
  EXPECT_FALSE(dataset->Load(2)->depth.has_value());
}

TEST_F(TumDatasetTest, ColourAloneHasNoDepth) {
  fs::remove(folder_.Path("depth.txt"));
  const auto dataset = Dataset::Open(Tum());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->size(), 3);
  EXPECT_EQ(dataset->frame(0).depth_path, "");
}

TEST_F(TumDatasetTest, TheTimeDifferenceIsAnOption) {
  DatasetOptions options = Tum();
  options.max_time_difference_s = 0.008;
  const auto dataset = Dataset::Open(options);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_THAT(dataset->frame(0).depth_path, EndsWith("depth/a.png"));
  EXPECT_EQ(dataset->frame(1).depth_path, "");
}

TEST_F(TumDatasetTest, TheListSelectsByTheWrittenTimeStamp) {
  Write("list.txt", "10.300\n10.000\n");
  DatasetOptions options = Tum();
  options.frame_list = folder_.Path("list.txt");
  const auto dataset = Dataset::Open(options);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 2);
  EXPECT_EQ(dataset->frame(0).stem, "10.300");
  EXPECT_EQ(dataset->frame(1).stem, "10.000");
  Write("list.txt", "10.300\n10.2\n");
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kNotFound),
              AllOf(HasSubstr("list.txt:2: "), HasSubstr("'10.2'")));
}

TEST_F(TumDatasetTest, AListedImageThatIsMissingIsNamed) {
  fs::remove(folder_.Path("rgb/b.png"));
  EXPECT_THAT(ErrorOf(Tum(), absl::StatusCode::kNotFound),
              AllOf(HasSubstr("rgb.txt:3: "), HasSubstr("rgb/b.png")));
  Write("rgb/b.png", *image::EncodePng(FlatColor(640, 480, 70)));
  fs::remove(folder_.Path("depth/a.png"));
  EXPECT_THAT(ErrorOf(Tum(), absl::StatusCode::kNotFound),
              AllOf(HasSubstr("depth.txt:2: "), HasSubstr("depth/a.png")));
}

TEST_F(TumDatasetTest, MissingOrEmptyIndexFilesAreNamed) {
  Write("rgb.txt", "# nothing\n");
  EXPECT_THAT(ErrorOf(Tum(), absl::StatusCode::kInvalidArgument),
              HasSubstr("rgb.txt: names no image"));
  fs::remove(folder_.Path("rgb.txt"));
  EXPECT_THAT(ErrorOf(Tum(), absl::StatusCode::kNotFound),
              HasSubstr("rgb.txt"));
}

TEST_F(TumDatasetTest, TellsHowTheCameraTurnedAndWhenDepthWasTaken) {
  // 0.02 rad about z in 40 ms.
  Write("groundtruth.txt",
        "9.98 0 0 0 0 0 0 1\n10.02 0 0 0 0 0 0.0099998333 0.99995\n");
  const auto dataset = Dataset::Open(Tum());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_TRUE(dataset->frame(0).motion.has_value());
  EXPECT_NEAR(dataset->frame(0).motion->turn_rate_rad_s.z, 0.5, 1e-6);
  EXPECT_NEAR(dataset->frame(0).motion->depth_delay_s, -0.005, 1e-12);
  EXPECT_FALSE(dataset->frame(1).motion.has_value());
}

TEST_F(TumDatasetTest, ARollingShutterIsUndoneWhereTheMotionIsKnown) {
  Write("groundtruth.txt",
        "9.98 0 0 0 0 0 0 1\n10.02 0 0 0 0 0 0.0099998333 0.99995\n");
  const auto dataset = Dataset::Open(Tum());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  const Dataset undone =
      dataset->WithShutter({.readout_s = 0.03}, dataset->calibration());
  const auto as_it_is = dataset->Load(0);
  const auto frame = undone.Load(0);
  ASSERT_TRUE(as_it_is.ok() && frame.ok()) << frame.status();
  // 0.5 rad/s turn the corners of the picture, 15 ms before the middle row, by
  // 2 px: there nothing was measured.
  EXPECT_NE(frame->depth->values, as_it_is->depth->values);
  EXPECT_EQ(frame->depth->values[320 + 240 * 640],
            as_it_is->depth->values[320 + 240 * 640]);
  const auto other = undone.Load(1);
  ASSERT_TRUE(other.ok()) << other.status();
  EXPECT_EQ(other->depth->values, dataset->Load(1)->depth->values);
}

TEST_F(TumDatasetTest, WithoutGroundTruthNoFrameHasAPose) {
  fs::remove(folder_.Path("groundtruth.txt"));
  const auto dataset = Dataset::Open(Tum());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_FALSE(dataset->frame(0).world_from_camera.has_value());
}

TEST_F(TumDatasetTest, AGroundTruthOfAnotherClockIsAnError) {
  Write("groundtruth.txt", "0.00 0 0 0 0 0 0 1\n0.02 4 0 0 0 0 0 1\n");
  EXPECT_THAT(
      ErrorOf(Tum(), absl::StatusCode::kInvalidArgument),
      AllOf(HasSubstr("poses from 0.000 to 0.020 s"), HasSubstr("10.000 to")));
}

TEST_F(TumDatasetTest, ADepthCameraContradictsRegisteredDepth) {
  DatasetOptions options = Tum();
  options.depth_camera = "PINHOLE,585,585,320,240";
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kInvalidArgument),
              HasSubstr("registered"));
}

}  // namespace
}  // namespace treeline::dataset
