// Each format there and back: a room with known poses, cameras and depth,
// written as an app writes it, imported, and opened as `treeline train` does.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "common/base/testing_folder.h"
#include "common/dataset/dataset.h"
#include "common/image/decode.h"
#include "gtest/gtest.h"
#include "server/tools/capture/open_capture.h"
#include "server/tools/capture/recording_writer.h"
#include "server/tools/capture/testing_captures.h"
#include "server/tools/capture/testing_datasets.h"
#include "server/tools/capture/testing_ros_captures.h"
#include "server/tools/capture/testing_rtabmap.h"

namespace treeline::capture {
namespace {

constexpr int kFrames = 12;

struct Case {
  const char* format;
  void (*write)(const TrueScene& scene, const std::string& folder);
  // Of a picture that was encoded once, or as a frame of a video.
  int max_color_error;
  // What the capture is called: bags are told by their endings.
  const char* name = "capture";
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.format; }

class RoundTripTest : public testing::TestWithParam<Case> {
 protected:
  static const TrueScene& Scene() {
    static const TrueScene* const scene = new TrueScene(MakeTrueScene(kFrames));
    return *scene;
  }

  dataset::Dataset Import(const WriteOptions& options) {
    const std::string path = folder_.Path(GetParam().name);
    GetParam().write(Scene(), path);
    auto capture = OpenCapture(path, "auto", {});
    EXPECT_TRUE(capture.ok()) << capture.status();
    EXPECT_EQ(capture->format, GetParam().format);
    const auto written =
        WriteRecording(*std::move(capture), options, {}, std::stop_token());
    EXPECT_TRUE(written.ok()) << written.status();
    EXPECT_EQ(written->frames, kFrames);
    EXPECT_EQ(written->with_depth, kFrames);
    EXPECT_EQ(written->left_out.count(), 0);
    auto dataset = dataset::Dataset::Open({.uri = "7scenes:" + options.folder});
    EXPECT_TRUE(dataset.ok()) << dataset.status();
    return *std::move(dataset);
  }

  WriteOptions Options() const {
    return {.folder = folder_.Path("recording"), .source = "test"};
  }

  const base::TestingFolder folder_;
};

void ExpectSameCamera(const camera::Camera& camera,
                      const camera::Camera& truth) {
  EXPECT_EQ(camera.width(), truth.width());
  EXPECT_EQ(camera.height(), truth.height());
  EXPECT_NEAR(camera.fx(), truth.fx(), 1e-6);
  EXPECT_NEAR(camera.fy(), truth.fy(), 1e-6);
  EXPECT_NEAR(camera.cx(), truth.cx(), 1e-6);
  EXPECT_NEAR(camera.cy(), truth.cy(), 1e-6);
  EXPECT_FALSE(camera.has_distortion());
}

TEST_P(RoundTripTest, PosesCamerasAndDepthAreTheTrueOnes) {
  const dataset::Dataset dataset = Import(Options());
  ASSERT_EQ(dataset.size(), kFrames);
  ExpectSameCamera(dataset.calibration().color, Scene().calibration.color);
  ExpectSameCamera(dataset.calibration().depth, Scene().calibration.depth);
  EXPECT_EQ(dataset.calibration().color_from_depth, geometry::Rigid3());
  EXPECT_EQ(dataset.calibration().pose_sensor, camera::RgbdSensor::kColor);
  for (int i = 0; i < kFrames; ++i) {
    const auto index = static_cast<size_t>(i);
    ASSERT_TRUE(dataset.frame(i).world_from_camera.has_value());
    const geometry::PoseError error = geometry::ErrorBetween(
        *dataset.frame(i).world_from_camera, Scene().world_from_camera[index]);
    EXPECT_LT(error.translation_m, 1e-4);
    EXPECT_LT(error.rotation_rad, 0.001 * std::numbers::pi / 180);
    const auto frame = dataset.Load(i);
    ASSERT_TRUE(frame.ok()) << frame.status();
    EXPECT_EQ(frame->depth->values, Scene().frames[index].depth->values);
    EXPECT_EQ(frame->depth->unit_m, 0.001);
  }
}

// Where the room's pixel is in the picture, and how far away, is worked out
// from another frame: a point that one frame sees is where the other one shows
// it, with the same colour and the depth that the other one measures.
TEST_P(RoundTripTest, APointIsWhereTheOtherPicturesShowIt) {
  const dataset::Dataset dataset = Import(Options());
  const camera::RgbdCalibration& calibration = dataset.calibration();
  int seen = 0;
  int same_color = 0;
  for (int i = 0; i < kFrames; ++i) {
    const int other = (i + 1) % kFrames;
    const auto from = dataset.Load(i);
    const auto to = dataset.Load(other);
    ASSERT_TRUE(from.ok() && to.ok());
    const geometry::Rigid3 other_from_camera =
        dataset.frame(other).world_from_camera->Inverse() *
        *dataset.frame(i).world_from_camera;
    for (int y = 4; y < from->depth->height; y += 8) {
      for (int x = 4; x < from->depth->width; x += 8) {
        const auto at = [](const image::DepthImage& depth, int px, int py) {
          return 0.001 *
                 depth.values[static_cast<size_t>(py * depth.width + px)];
        };
        const double z = at(*from->depth, x, y);
        const auto ray = calibration.depth.Unproject(
            {static_cast<double>(x), static_cast<double>(y)});
        const geometry::Vec3 point = z * geometry::Vec3{ray->x, ray->y, 1};
        const geometry::Vec3 in_other = other_from_camera * point;
        if (in_other.z < 0.3) continue;
        const camera::Pixel in_depth = calibration.depth.Project(in_other);
        const int u = static_cast<int>(std::lround(in_depth.x));
        const int v = static_cast<int>(std::lround(in_depth.y));
        if (u < 1 || v < 1 || u >= to->depth->width - 1 ||
            v >= to->depth->height - 1) {
          continue;
        }
        // Half a pixel beside it, a wall that is seen aslant is that much
        // nearer or farther than its neighbours differ.
        double slope = 0;
        for (const auto& [du, dv] :
             {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
          slope = std::max(slope, std::abs(at(*to->depth, u + du, v + dv) -
                                           at(*to->depth, u, v)));
        }
        EXPECT_NEAR(at(*to->depth, u, v), in_other.z, 0.003 + slope);
        const auto color_at = [&](const image::Frame& frame,
                                  geometry::Vec3 p) -> int {
          const camera::Pixel pixel = calibration.color.Project(p);
          const auto px = static_cast<size_t>(std::lround(pixel.x));
          const auto py = static_cast<size_t>(std::lround(pixel.y));
          const auto width = static_cast<size_t>(frame.color.width);
          return frame.color.rgb[3 * (py * width + px) + 1];
        };
        ++seen;
        same_color +=
            std::abs(color_at(*from, point) - color_at(*to, in_other)) <=
                    GetParam().max_color_error
                ? 1
                : 0;
      }
    }
  }
  EXPECT_GT(seen, 100);
  // A pixel is up to half of one beside the point, where the pattern is
  // another now and then.
  EXPECT_GT(same_color, 0.9 * seen);
}

TEST_P(RoundTripTest, AChangedSizeKeepsTheFieldOfView) {
  WriteOptions options = Options();
  options.max_side_px = 128;
  const dataset::Dataset dataset = Import(options);
  const camera::Camera& color = dataset.calibration().color;
  EXPECT_EQ(color.width(), 128);
  EXPECT_EQ(color.height(), 96);
  const camera::Camera& truth = Scene().calibration.color;
  EXPECT_NEAR(color.fx(), truth.fx() / 2, 1e-6);
  EXPECT_NEAR(color.cx(), (truth.cx() + 0.5) / 2 - 0.5, 1e-6);
  ExpectSameCamera(dataset.calibration().depth, Scene().calibration.depth);
}

INSTANTIATE_TEST_SUITE_P(
    Formats, RoundTripTest,
    testing::Values(
        Case{"nerfstudio", WriteNerfstudio, 12}, Case{"stray", WriteStray, 12},
        Case{"stray", WriteStrayVideo, 25}, Case{"record3d", WriteRecord3d, 12},
        Case{"polycam", WritePolycam, 12},
        Case{"3dscanner", WriteScannerApp, 12},
        Case{"scannet", WriteScanNet, 12},
        Case{"sens", WriteSens, 12, "capture.sens"},
        Case{"replica", WriteReplica, 12}, Case{"open3d", WriteOpen3d, 12},
        Case{"rosbag", WriteRosMcap, 12, "capture.mcap"},
        Case{"rosbag", WriteRosMcapFolder, 12},
        Case{"rosbag", WriteRosSqlite, 12},
        Case{"rosbag", WriteRos1, 12, "capture.bag"},
        Case{"rtabmap", WriteRtabmap, 12, "capture.db"},
        Case{"rtabmap", WriteOldRtabmap, 12, "capture.db"},
        Case{"rtabmap", WriteOldestRtabmap, 12, "capture.db"},
        Case{"rtabmap", WritePhoneRtabmap, 12, "capture.db"}));

}  // namespace
}  // namespace treeline::capture
