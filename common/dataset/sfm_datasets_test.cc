#include <filesystem>
#include <string>

#include "absl/strings/str_cat.h"
#include "common/base/testing_folder.h"
#include "common/dataset/dataset.h"
#include "common/dataset/twelve_scenes.h"
#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;

namespace fs = std::filesystem;

constexpr char kInfo[] =
    "m_versionNumber = 4\n"
    "m_colorWidth = 40\n"
    "m_colorHeight = 30\n"
    "m_depthWidth = 20\n"
    "m_depthHeight = 15\n"
    "m_depthShift = 1000\n"
    "m_calibrationColorIntrinsic = 36 0 20 0 0 35 15 0 0 0 1 0 0 0 0 1 \n"
    "m_calibrationColorExtrinsic = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1 \n"
    "m_calibrationDepthIntrinsic = 18 0 10 0 0 18 7 0 0 0 1 0 0 0 0 1 \n"
    "m_calibrationDepthExtrinsic = 1 0 0 0.02 0 1 0 0 0 0 1 0 0 0 0 1 \n";

class SfmDatasetsTest : public ::testing::Test {
 protected:
  void Write(const std::string& name, const std::string& contents) const {
    folder_.Write(name, contents);
  }
  void WritePicture(const std::string& name, int width, int height) const {
    const image::ColorImage image{
        width, height,
        std::vector<uint8_t>(static_cast<size_t>(3 * width * height), 90)};
    Write(name, *image::EncodePng(image));
  }
  // Two cameras of different sizes; b.png stands before a.png in the model.
  void WriteColmap() const {
    Write("model/cameras.txt",
          "1 PINHOLE 32 24 30 30 16 12\n2 FOV 40 20 30 30 20 10 0.3\n");
    Write("model/images.txt",
          "1 1 0 0 0 0 0 0 2 b.png\n20 10 5\n2 1 0 0 0 -1 0 0 1 a.png\n\n");
    Write("model/points3D.txt", "5 0 0 1 0 0 0 0 1 0\n");
    WritePicture("images/a.png", 32, 24);
    WritePicture("images/b.png", 40, 20);
  }
  DatasetOptions Colmap() const {
    return {.uri = absl::StrCat("colmap:", folder_.path(), "/model,",
                                folder_.path(), "/images")};
  }
  static std::string ErrorOf(const DatasetOptions& options,
                             absl::StatusCode code) {
    const absl::StatusOr<Dataset> dataset = Dataset::Open(options);
    EXPECT_EQ(dataset.status().code(), code) << dataset.status();
    return std::string(dataset.status().message());
  }

  const base::TestingFolder folder_;
};

TEST_F(SfmDatasetsTest, ColmapFramesComeByNameWithTheirOwnCameras) {
  WriteColmap();
  const auto dataset = Dataset::Open(Colmap());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_FALSE(dataset->units_are_metres());
  EXPECT_FALSE(dataset->depth_is_registered());
  ASSERT_EQ(dataset->size(), 2);
  EXPECT_EQ(dataset->frame(0).stem, "a.png");
  EXPECT_EQ(dataset->frame(0).world_from_camera->translation.x, 1);
  EXPECT_EQ(dataset->frame(1).structure_image, 0);
  ASSERT_NE(dataset->structure(), nullptr);
  EXPECT_EQ(dataset->structure()->images[0].keypoints[0].point, 0);
  const auto frame = dataset->Load(1);
  ASSERT_TRUE(frame.ok()) << frame.status();
  ASSERT_TRUE(frame->calibration.has_value());
  EXPECT_EQ(frame->calibration->color.ToString(), "FOV,30,30,19.5,9.5,0.3");
  EXPECT_EQ(frame->color.width, 40);
  const auto decoded = dataset->Decode(*dataset->ReadEncoded(1));
  ASSERT_TRUE(decoded.ok()) << decoded.status();
  EXPECT_EQ(decoded->calibration, frame->calibration);
}

// Structure from motion knows no unit, but somebody may have scaled the model.
TEST_F(SfmDatasetsTest, AModelIsInMetresIfItSaysSo) {
  WriteColmap();
  EXPECT_FALSE(Dataset::Open(Colmap())->units_are_metres());
  Write("model/units.txt", "metres\n");
  EXPECT_TRUE(Dataset::Open(Colmap())->units_are_metres());
  Write("model/units.txt", "feet\n");
  EXPECT_THAT(ErrorOf(Colmap(), absl::StatusCode::kInvalidArgument),
              HasSubstr("model/units.txt"));
}

TEST_F(SfmDatasetsTest, FrameListsNameImages) {
  WriteColmap();
  Write("list.txt", "b.png\n");
  DatasetOptions options = Colmap();
  options.frame_list = folder_.Path("list.txt");
  const auto dataset = Dataset::Open(options);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 1);
  EXPECT_EQ(dataset->frame(0).stem, "b.png");
  Write("list.txt", "b.png\nc.png\n");
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kNotFound),
              AllOf(HasSubstr("list.txt:2"), HasSubstr("'c.png'")));
}

TEST_F(SfmDatasetsTest, AGivenCameraReplacesTheModels) {
  WriteColmap();
  fs::remove(folder_.Path("model/cameras.txt"));
  EXPECT_THAT(ErrorOf(Colmap(), absl::StatusCode::kNotFound),
              HasSubstr("cameras"));
  DatasetOptions options = Colmap();
  options.color_camera = "PINHOLE,31,31,16,12";
  const auto dataset = Dataset::Open(options);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  EXPECT_EQ(dataset->frame(0).color_camera->ToString(), "PINHOLE,31,31,16,12");
  // b.png is of another size than the first picture.
  EXPECT_THAT(std::string(dataset->Load(1).status().message()),
              AllOf(HasSubstr("b.png"), HasSubstr("40 x 20")));
}

TEST_F(SfmDatasetsTest, MissingPartsAndWrongOptionsAreNamed) {
  WriteColmap();
  DatasetOptions options = Colmap();
  options.pose_file = "poses.txt";
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kInvalidArgument),
              HasSubstr("own poses"));
  options = Colmap();
  options.uri = absl::StrCat("colmap:", folder_.path(), "/model");
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kInvalidArgument),
              HasSubstr("MODEL_DIR,IMAGES_DIR"));
  options.uri += ",/no/such";
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kNotFound),
              HasSubstr("/no/such"));
  fs::remove(folder_.Path("images/a.png"));
  fs::remove(folder_.Path("images/b.png"));
  EXPECT_THAT(ErrorOf(Colmap(), absl::StatusCode::kNotFound),
              AllOf(HasSubstr("2 of 2 pictures"), HasSubstr("first: a.png")));
  fs::remove(folder_.Path("model/points3D.txt"));
  Write("model/images.txt", "# none\n");
  EXPECT_THAT(ErrorOf(Colmap(), absl::StatusCode::kInvalidArgument),
              HasSubstr("no image"));
}

TEST_F(SfmDatasetsTest, AnImageWithoutItsPictureIsLeftOutAndCounted) {
  WriteColmap();
  EXPECT_EQ(Dataset::Open(Colmap())->missing_pictures().count, 0);
  fs::remove(folder_.Path("images/a.png"));
  DatasetOptions options = Colmap();
  for (const char* camera : {"", "PINHOLE,31,31,16,12"}) {
    options.color_camera = camera;
    const auto dataset = Dataset::Open(options);
    ASSERT_TRUE(dataset.ok()) << dataset.status();
    ASSERT_EQ(dataset->size(), 1);
    EXPECT_EQ(dataset->frame(0).stem, "b.png");
    EXPECT_EQ(
        dataset->structure()
            ->images[static_cast<size_t>(dataset->frame(0).structure_image)]
            .name,
        "b.png");
    EXPECT_EQ(dataset->missing_pictures().count, 1);
    EXPECT_EQ(dataset->missing_pictures().first, "a.png");
    EXPECT_TRUE(dataset->Load(0).ok());
  }
}

TEST_F(SfmDatasetsTest, AFileThatVanishesIsAnErrorOfItsFrame) {
  WriteColmap();
  const auto dataset = Dataset::Open(Colmap());
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  fs::remove(folder_.Path("images/a.png"));
  EXPECT_THAT(std::string(dataset->Load(0).status().message()),
              HasSubstr("a.png"));
  EXPECT_TRUE(dataset->Load(1).ok());
}

TEST_F(SfmDatasetsTest, NvmTakesSizesFromPicturesWhateverTheirEnding) {
  Write("m.nvm",
        "NVM_V3\n2\nseq/a.jpg 30 1 0 0 0 0 0 0 0 0\n"
        "seq/b.jpg 30 1 0 0 0 2 0 0 0 0\n1\n0 0 1 0 0 0 1 0 0 1 -2\n0\n");
  WritePicture("seq/a.png", 32, 24);
  WritePicture("seq/b.png", 40, 20);
  const auto dataset =
      Dataset::Open({.uri = absl::StrCat("nvm:", folder_.path(), "/m.nvm")});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 2);
  EXPECT_EQ(dataset->frame(0).stem, "seq/a.jpg");
  EXPECT_THAT(dataset->frame(0).color_path, EndsWith("seq/a.png"));
  EXPECT_EQ(dataset->frame(1).color_camera->ToString(),
            "PINHOLE,30,30,19.5,9.5");
  EXPECT_NEAR(dataset->frame(1).world_from_camera->translation.x, 2, 1e-12);
  EXPECT_EQ(dataset->structure()->images[0].keypoints[0].pixel.x, 16.5);
  EXPECT_THAT(ErrorOf({.uri = "nvm:/no/such.nvm"}, absl::StatusCode::kNotFound),
              HasSubstr("/no/such.nvm"));
}

TEST_F(SfmDatasetsTest, TwelveScenesKnowsItsCamerasAndLostFrames) {
  Write("info.txt", kInfo);
  for (const char* stem : {"data/frame-000000", "data/frame-000001"}) {
    WritePicture(absl::StrCat(stem, ".color.png"), 40, 30);
    const image::DepthImage depth{20, 15, std::vector<uint16_t>(300, 1500)};
    Write(absl::StrCat(stem, ".depth.png"), *image::EncodeDepthPng(depth));
  }
  Write("data/frame-000000.pose.txt", "1 0 0 2\n0 1 0 0\n0 0 1 0\n0 0 0 1\n");
  Write("data/frame-000001.pose.txt",
        "-inf -inf -inf -inf\n-inf -inf -inf -inf\n"
        "-inf -inf -inf -inf\n-inf -inf -inf -inf\n");
  DatasetOptions options{.uri = absl::StrCat("12scenes:", folder_.path())};
  const auto dataset = Dataset::Open(options);
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 2);
  EXPECT_EQ(dataset->frame(0).stem, "frame-000000");
  EXPECT_EQ(dataset->frame(0).world_from_camera->translation.x, 2);
  EXPECT_FALSE(dataset->frame(1).world_from_camera.has_value());
  EXPECT_EQ(dataset->calibration().color.ToString(), "PINHOLE,36,35,20,15");
  EXPECT_EQ(dataset->calibration().depth.ToString(), "PINHOLE,18,18,10,7");
  EXPECT_EQ(dataset->calibration().color_from_depth.translation.x, 0.02);
  EXPECT_TRUE(dataset->units_are_metres());
  const auto frame = dataset->Load(1);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->depth->width, 20);
  options.color_camera = "PINHOLE,37,37,20,15";
  EXPECT_EQ(Dataset::Open(options)->calibration().color.fx(), 37);
  fs::remove(folder_.Path("info.txt"));
  EXPECT_THAT(ErrorOf(options, absl::StatusCode::kNotFound),
              HasSubstr("info.txt"));
}

TEST_F(SfmDatasetsTest, TwelveScenesInfoErrorsNameTheEntry) {
  const auto error = [](const std::string& text) {
    const auto info = ParseTwelveScenesInfo(text, "info.txt");
    EXPECT_EQ(info.status().code(), absl::StatusCode::kInvalidArgument);
    return std::string(info.status().message());
  };
  const std::string whole(kInfo);
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string text = whole;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  EXPECT_THAT(error(""), HasSubstr("m_colorWidth"));
  EXPECT_THAT(error(with("Width = 40", "Width = nan")), HasSubstr(":2: "));
  EXPECT_THAT(error(with("Width = 40", "Width = 0")), HasSubstr("0 x 30"));
  EXPECT_THAT(error(with("= 36 0", "= 36")), HasSubstr("15 numbers"));
  EXPECT_THAT(error(with("Shift = 1000", "Shift = 0")),
              HasSubstr("m_depthShift"));
  EXPECT_THAT(error(with("= 1 0 0 0.02", "= 5 0 0 0.02")),
              HasSubstr("m_calibrationDepthExtrinsic"));
}

}  // namespace
}  // namespace treeline::dataset
