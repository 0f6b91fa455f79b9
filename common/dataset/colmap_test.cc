#include "common/dataset/colmap.h"

#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

constexpr char kCameras[] =
    "# Camera list\n"
    "1 PINHOLE 640 480 500 510 320 240\n"
    "7 SIMPLE_RADIAL 1280 960 1000 640 480 -0.02\n";
// Image 3 is turned by 180 degrees about x; its name has a space.
constexpr char kImages[] =
    "# Image list\n"
    "3 0 1 0 0 1 2 3 7 left wing/b 1.jpg\n"
    "10.5 20.25 101 30 40 -1 50 60 102\n"
    "5 1 0 0 0 0 0 0 1 a.jpg\n"
    "\n"
    "9 1 0 0 0 0 0 1 1 c.jpg\n"
    "1.5 2.5 101";
constexpr char kPoints[] =
    "# Points\n"
    "101 1 2 3 255 0 0 0.5 3 0 9 0\n"
    "102 -4 5e-1 6 0 0 0 -1 3 2\n";

ColmapFiles TextModel() {
  ColmapFiles files;
  files.images = {"images.txt", kImages, false};
  files.cameras = ColmapFile{"cameras.txt", kCameras, false};
  files.points = ColmapFile{"points3D.txt", kPoints, false};
  return files;
}

// Little-endian bytes one after the other.
class Bytes {
 public:
  template <typename T>
  Bytes& Add(T value) {
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  template <typename... T>
  Bytes& Doubles(T... values) {
    (Add(static_cast<double>(values)), ...);
    return *this;
  }
  Bytes& Name(const char* name) {
    bytes_.append(name, std::strlen(name) + 1);
    return *this;
  }
  const std::string& str() const { return bytes_; }

 private:
  std::string bytes_;
};

// The same model as TextModel.
ColmapFiles BinaryModel() {
  constexpr uint64_t kNone = ~uint64_t{0};
  Bytes cameras;
  cameras.Add(uint64_t{2});
  cameras.Add(1u).Add(1).Add(uint64_t{640}).Add(uint64_t{480});
  cameras.Doubles(500, 510, 320, 240);
  cameras.Add(7u).Add(2).Add(uint64_t{1280}).Add(uint64_t{960});
  cameras.Doubles(1000, 640, 480, -0.02);
  Bytes images;
  images.Add(uint64_t{3});
  images.Add(3u).Doubles(0, 1, 0, 0, 1, 2, 3).Add(7u).Name("left wing/b 1.jpg");
  images.Add(uint64_t{3});
  images.Doubles(10.5, 20.25).Add(uint64_t{101});
  images.Doubles(30, 40).Add(kNone);
  images.Doubles(50, 60).Add(uint64_t{102});
  images.Add(5u).Doubles(1, 0, 0, 0, 0, 0, 0).Add(1u).Name("a.jpg");
  images.Add(uint64_t{0});
  images.Add(9u).Doubles(1, 0, 0, 0, 0, 0, 1).Add(1u).Name("c.jpg");
  images.Add(uint64_t{1}).Doubles(1.5, 2.5).Add(uint64_t{101});
  Bytes points;
  points.Add(uint64_t{2});
  points.Add(uint64_t{101}).Doubles(1, 2, 3).Name("xy").Doubles(0.5);
  points.Add(uint64_t{2}).Add(3u).Add(0u).Add(9u).Add(0u);
  points.Add(uint64_t{102}).Doubles(-4, 0.5, 6).Name("xy").Doubles(-1);
  points.Add(uint64_t{1}).Add(3u).Add(2u);
  ColmapFiles files;
  files.images = {"images.bin", images.str(), true};
  files.cameras = ColmapFile{"cameras.bin", cameras.str(), true};
  files.points = ColmapFile{"points3D.bin", points.str(), true};
  return files;
}

void ExpectIsTheModel(const absl::StatusOr<SfmModel>& model) {
  ASSERT_TRUE(model.ok()) << model.status();
  ASSERT_EQ(model->cameras.size(), 2u);
  EXPECT_EQ(model->cameras[0].ToString(), "PINHOLE,500,510,319.5,239.5");
  EXPECT_EQ(model->cameras[1].ToString(),
            "SIMPLE_RADIAL,1000,639.5,479.5,-0.02");
  EXPECT_EQ(model->cameras[1].width(), 1280);
  ASSERT_EQ(model->images.size(), 3u);
  const SfmModel::Image& image = model->images[0];
  EXPECT_EQ(image.name, "left wing/b 1.jpg");
  EXPECT_EQ(image.camera, 1);
  EXPECT_EQ(image.camera_from_world.translation, (geometry::Vec3{1, 2, 3}));
  const geometry::Vec3 turned =
      image.camera_from_world.rotation * geometry::Vec3{0, 0, 1};
  EXPECT_NEAR(turned.z, -1, 1e-12);
  ASSERT_EQ(image.keypoints.size(), 3u);
  EXPECT_EQ(image.keypoints[0].pixel.x, 10);
  EXPECT_EQ(image.keypoints[0].pixel.y, 19.75);
  EXPECT_EQ(image.keypoints[0].point, 0);
  EXPECT_EQ(image.keypoints[1].point, -1);
  EXPECT_EQ(image.keypoints[2].point, 1);
  EXPECT_TRUE(model->images[1].keypoints.empty());
  EXPECT_EQ(model->images[2].keypoints[0].point, 0);
  ASSERT_EQ(model->points.size(), 2u);
  EXPECT_EQ(model->points[1].position_in_world, (geometry::Vec3{-4, 0.5, 6}));
  EXPECT_EQ(model->points[0].track_length, 2);
}

std::string ErrorOf(const ColmapFiles& files) {
  const absl::StatusOr<SfmModel> model = ParseColmap(files);
  EXPECT_EQ(model.status().code(), absl::StatusCode::kInvalidArgument)
      << model.status();
  return std::string(model.status().message());
}

// The error of the text model with `from` replaced by `to` in one file.
std::string CameraError(const char* from, const char* to) {
  ColmapFiles files = TextModel();
  files.cameras->bytes = absl::StrReplaceAll(kCameras, {{from, to}});
  return ErrorOf(files);
}
std::string ImageError(const char* from, const char* to) {
  ColmapFiles files = TextModel();
  files.images.bytes = absl::StrReplaceAll(kImages, {{from, to}});
  return ErrorOf(files);
}
std::string PointError(const char* from, const char* to) {
  ColmapFiles files = TextModel();
  files.points->bytes = absl::StrReplaceAll(kPoints, {{from, to}});
  return ErrorOf(files);
}

TEST(ColmapTest, ReadsTextInOurPixelConvention) {
  ExpectIsTheModel(ParseColmap(TextModel()));
}

TEST(ColmapTest, ReadsBinaryAndMixturesToTheSameModel) {
  ExpectIsTheModel(ParseColmap(BinaryModel()));
  ColmapFiles mixed = TextModel();
  mixed.points = BinaryModel().points;
  ExpectIsTheModel(ParseColmap(mixed));
}

TEST(ColmapTest, WithoutPointsKeypointsHaveNone) {
  ColmapFiles files = TextModel();
  files.points.reset();
  const auto model = ParseColmap(files);
  ASSERT_TRUE(model.ok()) << model.status();
  EXPECT_EQ(model->images[0].keypoints[0].point, -1);
  EXPECT_TRUE(model->points.empty());
}

TEST(ColmapTest, AGivenCameraIsEveryImages) {
  ColmapFiles files = TextModel();
  files.cameras.reset();
  files.camera = camera::Camera();
  const auto model = ParseColmap(files);
  ASSERT_TRUE(model.ok()) << model.status();
  ASSERT_EQ(model->cameras.size(), 1u);
  EXPECT_EQ(model->cameras[0], camera::Camera());
  EXPECT_EQ(model->images[0].camera, 0);
}

TEST(ColmapTest, BadCamerasAreNamedWithTheirLine) {
  EXPECT_THAT(CameraError("PINHOLE 640", "WIDE 640"),
              AllOf(HasSubstr("cameras.txt:2: "), HasSubstr("'WIDE'")));
  EXPECT_THAT(CameraError("500 510", "500 nan"), HasSubstr("finite"));
  EXPECT_THAT(CameraError("500 510", "510"), HasSubstr("takes 4 parameters"));
  EXPECT_THAT(CameraError("640 480 500", "0 480 500"), HasSubstr("0 x 480"));
  EXPECT_THAT(CameraError("640 480 500", "4294967936 480 500"),
              HasSubstr("outside"));
  EXPECT_THAT(CameraError("7 SIMPLE", "1 SIMPLE"),
              HasSubstr("cameras.txt:3: camera 1 was already"));
  EXPECT_THAT(CameraError("1 PINHOLE", "-1 PINHOLE"), HasSubstr("'-1'"));
}

TEST(ColmapTest, BadImagesAreNamedWithTheirLine) {
  EXPECT_THAT(ImageError("0 1 0 0 1 2 3", "0 2 0 0 1 2 3"),
              AllOf(HasSubstr("images.txt:2: "), HasSubstr("norm")));
  EXPECT_THAT(ImageError("1 2 3 7", "1 inf 3 7"), HasSubstr("finite"));
  EXPECT_THAT(ImageError("3 7 left", "3 8 left"),
              HasSubstr("image 3 has camera 8"));
  EXPECT_THAT(ImageError("20.25 101", "20.25 999"),
              AllOf(HasSubstr("images.txt:2"), HasSubstr("point 999")));
  EXPECT_THAT(ImageError("30 40 -1", "30 -1"),
              AllOf(HasSubstr("images.txt:3"), HasSubstr("8 words")));
  EXPECT_THAT(ImageError("30 40 -1", "nan 40 -1"), HasSubstr("'nan'"));
  EXPECT_THAT(ImageError("5 1 0", "3 1 0"), HasSubstr("image 3 was already"));
  EXPECT_THAT(ImageError("a.jpg", "c.jpg"), HasSubstr("same name"));
  EXPECT_THAT(ImageError("a.jpg", "../a.jpg"), HasSubstr("no name"));
  EXPECT_THAT(ImageError(" 1 a.jpg", ""), HasSubstr("found 8 words"));
}

TEST(ColmapTest, PointsThatContradictTheImagesAreNamedWithTheirLine) {
  EXPECT_THAT(PointError("101 1 2 3", "101 1 nan 3"),
              HasSubstr("points3D.txt:2"));
  EXPECT_THAT(PointError("102 -4", "101 -4"), HasSubstr("already"));
  EXPECT_THAT(PointError("-1 3 2", "-1 4 2"), HasSubstr("image 4"));
  EXPECT_THAT(PointError("-1 3 2", "-1 3 5"), HasSubstr("keypoint 5"));
  EXPECT_THAT(PointError("-1 3 2", "-1 3 1"), HasSubstr("does not see"));
  EXPECT_THAT(PointError("-1 3 2", "-1 3"), HasSubstr("9 words"));
}

TEST(ColmapTest, EveryTruncatedBinaryIsRefusedWithItsByte) {
  const ColmapFiles whole = BinaryModel();
  ASSERT_TRUE(ParseColmap(whole).ok());
  for (size_t size = 0; size < whole.images.bytes.size(); ++size) {
    ColmapFiles files = whole;
    files.images.bytes.resize(size);
    EXPECT_THAT(ErrorOf(files), HasSubstr("images.bin: byte ")) << size;
  }
  for (size_t size = 0; size < whole.points->bytes.size(); ++size) {
    ColmapFiles files = whole;
    files.points->bytes.resize(size);
    EXPECT_THAT(ErrorOf(files), HasSubstr("points3D.bin: byte ")) << size;
  }
  for (size_t size = 0; size < whole.cameras->bytes.size(); ++size) {
    ColmapFiles files = whole;
    files.cameras->bytes.resize(size);
    EXPECT_THAT(ErrorOf(files), HasSubstr("cameras.bin: byte ")) << size;
  }
}

TEST(ColmapTest, HugeCountsAreRefusedBeforeMemoryIsTaken) {
  for (const uint64_t count : {~uint64_t{0}, uint64_t{1} << 40}) {
    ColmapFiles files = BinaryModel();
    std::memcpy(files.images.bytes.data(), &count, sizeof(count));
    EXPECT_THAT(ErrorOf(files),
                AllOf(HasSubstr("images.bin: byte 0: "), HasSubstr("fit")));
    files = BinaryModel();
    // The number of keypoints of the first image.
    std::memcpy(files.images.bytes.data() + 8 + 4 + 56 + 4 + 18, &count,
                sizeof(count));
    EXPECT_THAT(ErrorOf(files), HasSubstr("keypoints do not fit"));
  }
}

TEST(ColmapTest, BytesAfterTheLastRecordAndUnknownModelsAreRefused) {
  ColmapFiles files = BinaryModel();
  files.cameras->bytes += "x";
  EXPECT_THAT(ErrorOf(files), HasSubstr("1 bytes follow"));
  files = BinaryModel();
  files.cameras->bytes[8 + 4] = 11;
  EXPECT_THAT(ErrorOf(files), HasSubstr("model number 11"));
}

TEST(ColmapTest, CamerasAreFoundBesideAFolderThatHasNone) {
  const fs::path folder =
      fs::temp_directory_path() / absl::StrCat("treeline-colmap-", getpid());
  fs::create_directories(folder / "sparse");
  fs::create_directories(folder / "test");
  const std::string test = (folder / "test").string();
  EXPECT_THAT(std::string(ReadColmap(test, std::nullopt).status().message()),
              HasSubstr("no images.bin"));
  std::ofstream(folder / "test" / "images.txt") << "1 1 0 0 0 0 0 0 1 a.jpg\n";
  const auto without = ReadColmap(test, std::nullopt);
  EXPECT_EQ(without.status().code(), absl::StatusCode::kNotFound);
  EXPECT_THAT(std::string(without.status().message()),
              HasSubstr("give the colour camera"));
  std::ofstream(folder / "sparse" / "cameras.txt") << kCameras;
  const auto with = ReadColmap(test, std::nullopt);
  ASSERT_TRUE(with.ok()) << with.status();
  EXPECT_EQ(with->cameras[0].width(), 640);
  fs::remove_all(folder);
}

}  // namespace
}  // namespace treeline::dataset
