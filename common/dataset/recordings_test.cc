// The readers on real recordings (TREELINE_DATA).
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "common/dataset/dataset.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::dataset {
namespace {

class RecordingsTest : public ::testing::Test {
 protected:
  // Skips the test if the recording is not there.
  std::string Folder(const std::string& name) {
    const char* data = std::getenv("TREELINE_DATA");
    const std::string folder =
        std::string(data != nullptr ? data : TREELINE_DEFAULT_DATA) + "/" +
        name;
    return std::filesystem::is_directory(folder) ? folder : "";
  }
};

TEST_F(RecordingsTest, RedKitchenWithBothGroundTruths) {
  const std::string folder = Folder("7scenes-redkitchen");
  if (folder.empty()) GTEST_SKIP() << "no red kitchen in TREELINE_DATA";
  DatasetOptions options = {.uri = "7scenes:" + folder,
                            .frame_list = folder + "/train.txt"};
  const auto original = Dataset::Open(options);
  ASSERT_TRUE(original.ok()) << original.status();
  options.pose_file = folder + "/poses-sfm.txt";
  const auto sfm = Dataset::Open(options);
  ASSERT_TRUE(sfm.ok()) << sfm.status();
  ASSERT_EQ(original->size(), 500);
  ASSERT_EQ(sfm->size(), 500);
  EXPECT_EQ(sfm->frame(100).stem, "seq-01/frame-000200");
  EXPECT_EQ(sfm->calibration().color.ToString(),
            "PINHOLE,525.505,525.505,320,240");
  // The two worlds differ by a similarity of scale 0.993, and drift by up to
  // 10 cm. Distances between cameras are alike if both are world_from_camera.
  for (int i = 50; i < 500; i += 50) {
    ASSERT_TRUE(original->frame(i).world_from_camera.has_value());
    ASSERT_TRUE(sfm->frame(i).world_from_camera.has_value());
    const auto distance_m = [i](const Dataset& dataset) {
      return geometry::Norm(dataset.frame(i).world_from_camera->translation -
                            dataset.frame(0).world_from_camera->translation);
    };
    const double expected_m = distance_m(*original);
    EXPECT_NEAR(distance_m(*sfm), expected_m, 0.01 * expected_m + 0.1) << i;
  }
  const auto frame = sfm->Load(499);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->color.width, 640);
  ASSERT_TRUE(frame->depth.has_value());
  // A kitchen: most pixels are measured, at room distances.
  int near = 0;
  for (const uint16_t value : frame->depth->values) {
    if (image::IsMeasured(value) && value > 300 && value < 8000) ++near;
  }
  EXPECT_GT(near, 640 * 480 / 2);
}

TEST_F(RecordingsTest, TumFr1IsAssociatedAndRegistered) {
  const std::string folder = Folder("tum-fr1-rpy");
  if (folder.empty()) GTEST_SKIP() << "no tum-fr1-rpy in TREELINE_DATA";
  const auto dataset = Dataset::Open({.uri = "tum:" + folder + "/train"});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 91);
  EXPECT_EQ(dataset->frame(0).stem, "1305031241.529758");
  EXPECT_NEAR(dataset->calibration().color.fx(), 517.3, 1e-9);
  EXPECT_TRUE(dataset->depth_is_registered());
  int with_depth = 0;
  int with_pose = 0;
  for (int i = 0; i < dataset->size(); ++i) {
    with_depth += dataset->frame(i).depth_path.empty() ? 0 : 1;
    with_pose += dataset->frame(i).world_from_camera.has_value() ? 1 : 0;
  }
  // TUM's associate.py pairs all of them; the ground truth has one gap.
  EXPECT_EQ(with_depth, 91);
  EXPECT_GE(with_pose, 89);
  // groundtruth.txt: (1.3035 0.6230 1.5015) at .5230, (1.3037 0.6231 1.5014)
  // at .5330, and the picture was taken at .529758.
  const geometry::Vec3 position_m =
      dataset->frame(0).world_from_camera->translation;
  EXPECT_NEAR(position_m.x, 1.3035 + 0.6758 * 0.0002, 1e-7);
  EXPECT_NEAR(position_m.y, 0.6230 + 0.6758 * 0.0001, 1e-7);
  EXPECT_NEAR(position_m.z, 1.5015 - 0.6758 * 0.0001, 1e-7);
  const auto frame = dataset->Load(0);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->depth->unit_m, 1.0 / 5000);
}

// The keypoints of a model that was read with the right conventions lie where
// its cameras see its points: to a fraction of a pixel, and without bias.
TEST_F(RecordingsTest, SouthBuildingReprojects) {
  const std::string folder = Folder("south-building");
  if (folder.empty()) GTEST_SKIP() << "no south-building in TREELINE_DATA";
  const auto dataset = Dataset::Open(
      {.uri = "colmap:" + folder + "/sparse," + folder + "/images"});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 96);
  EXPECT_FALSE(dataset->units_are_metres());
  const SfmModel& model = *dataset->structure();
  EXPECT_EQ(model.points.size(), 24312u);
  double sum_x = 0;
  double sum_y = 0;
  int seen = 0;
  int near = 0;
  for (const SfmModel::Image& image : model.images) {
    const camera::Camera& camera =
        model.cameras[static_cast<size_t>(image.camera)];
    for (const SfmModel::Keypoint& keypoint : image.keypoints) {
      const geometry::Vec3 point =
          image.camera_from_world *
          model.points[static_cast<size_t>(keypoint.point)].position_in_world;
      const camera::Pixel pixel = camera.Project(point);
      const double dx = pixel.x - keypoint.pixel.x;
      const double dy = pixel.y - keypoint.pixel.y;
      ++seen;
      near += std::hypot(dx, dy) < 1.5;
      sum_x += dx;
      sum_y += dy;
    }
  }
  EXPECT_EQ(seen, 115685);
  EXPECT_GT(near, 0.9 * seen);
  EXPECT_NEAR(sum_x / seen, 0, 0.02);
  EXPECT_NEAR(sum_y / seen, 0, 0.02);
  const auto frame = dataset->Load(0);
  ASSERT_TRUE(frame.ok()) << frame.status();
  EXPECT_EQ(frame->color.width, 1280);
}

TEST_F(RecordingsTest, SouthBuildingsTestPosesFindTheirCameraBeside) {
  const std::string folder = Folder("south-building");
  if (folder.empty()) GTEST_SKIP() << "no south-building in TREELINE_DATA";
  const auto dataset = Dataset::Open(
      {.uri = "colmap:" + folder + "/test," + folder + "/images"});
  ASSERT_TRUE(dataset.ok()) << dataset.status();
  ASSERT_EQ(dataset->size(), 16);
  EXPECT_EQ(dataset->frame(0).stem, "P1180148.jpg");
  EXPECT_EQ(dataset->frame(0).color_camera->model(),
            camera::CameraModel::kSimpleRadial);
  EXPECT_EQ(dataset->frame(0).color_camera->cx(), 639.5);
}

}  // namespace
}  // namespace treeline::dataset
