#include "server/tools/capture/rtabmap.h"

#include <sqlite3.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "common/image/decode.h"
#include "common/image/quarter_turn.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/tools/capture/open_capture.h"
#include "server/tools/capture/rtabmap_blobs.h"
#include "server/tools/capture/testing_rtabmap.h"

namespace treeline::capture {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

constexpr int kFrames = 6;

Bytes BytesOf(const std::string& text) {
  return {reinterpret_cast<const uint8_t*>(text.data()), text.size()};
}

class RtabmapTest : public testing::Test {
 protected:
  static const TrueScene& Scene() {
    static const TrueScene* const scene = new TrueScene(MakeTrueScene(kFrames));
    return *scene;
  }
  static RtabmapDatabase Today() {
    return RtabmapOf(Scene(), "0.23.2", RtabmapDepth::kRvl);
  }

  absl::StatusOr<Capture> Open(const RtabmapDatabase& database,
                               const OpenOptions& options = {}) {
    const std::string path =
        folder_.Path(absl::StrCat("walk", ++written_, ".db"));
    WriteDatabase(database, path);
    return OpenCapture(path, "auto", options);
  }

  static void ExpectTruePoses(const Capture& capture) {
    for (const CaptureFrame& frame : capture.frames) {
      const size_t node = std::stoul(frame.name.substr(5));
      const geometry::PoseError error = geometry::ErrorBetween(
          frame.world_from_camera, Scene().world_from_camera.at(node - 1));
      EXPECT_LT(error.translation_m, 1e-5) << frame.name;
      EXPECT_LT(error.rotation_rad, 1e-5) << frame.name;
    }
  }

  const base::TestingFolder folder_;
  int written_ = 0;
};

TEST_F(RtabmapTest, NodesThatGraphOptimizationDidNotPlaceAreLeftOut) {
  RtabmapDatabase database = Today();
  std::vector<geometry::Rigid3> poses;
  for (const size_t frame : {size_t{1}, size_t{3}, size_t{4}}) {
    poses.push_back(Scene().world_from_camera[frame] *
                    RtabmapBaseFromCamera().Inverse());
  }
  // Landmarks have negative numbers.
  poses.push_back({});
  SetOptimizedPoses({2, 4, 5, -7}, poses, database);
  const auto capture = Open(database);
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_EQ(capture->format, "rtabmap");
  EXPECT_EQ(capture->frames.size(), 3);
  ExpectTruePoses(*capture);
  EXPECT_THAT(capture->left_out.Lines(),
              Contains(HasSubstr("3 frames: graph optimization did not place "
                                 "it (the first: node 1)")));
}

TEST_F(RtabmapTest, WithoutOptimizedPosesTheLargestSessionIsTaken) {
  RtabmapDatabase database = Today();
  database.optimized_ids.reset();
  database.optimized_poses.reset();
  database.nodes[0].session = 3;
  database.nodes[1].session = 3;
  const auto capture = Open(database);
  ASSERT_TRUE(capture.ok()) << capture.status();
  EXPECT_EQ(capture->frames.size(), kFrames - 2);
  EXPECT_THAT(capture->notes, Contains(HasSubstr("odometry's, which drifts")));
  EXPECT_THAT(capture->left_out.Lines(),
              Contains(HasSubstr("2 frames: it is of another session than 0")));
}

TEST_F(RtabmapTest, NodesWithoutPictureCalibrationOrPoseAreLeftOut) {
  RtabmapDatabase database = Today();
  database.optimized_ids.reset();
  database.optimized_poses.reset();
  database.nodes[0].image.reset();
  database.nodes[1].calibration.reset();
  database.nodes[2].pose.reset();
  database.nodes[3].weight = -9;
  database.nodes[4].depth.reset();  // this is none to leave it out
  const auto capture = Open(database);
  ASSERT_TRUE(capture.ok()) << capture.status();
  ASSERT_EQ(capture->frames.size(), 2);
  EXPECT_EQ(capture->frames[0].name, "node 5");
  EXPECT_EQ(capture->left_out.count(), 4);
  EXPECT_THAT(capture->left_out.Lines(), Contains(HasSubstr("no picture")));
  EXPECT_THAT(capture->left_out.Lines(), Contains(HasSubstr("calibration")));
  EXPECT_THAT(capture->left_out.Lines(), Contains(HasSubstr("no rigid pose")));
  EXPECT_THAT(capture->left_out.Lines(), Contains(HasSubstr("removed")));
  const auto pictures = capture->pictures->Load(0);
  ASSERT_TRUE(pictures.ok()) << pictures.status();
  EXPECT_FALSE(pictures->depth.has_value());
}

// The same camera twice, the second one turned to the left by a quarter.
TEST_F(RtabmapTest, PicturesOfSeveralCamerasAreTakenApart) {
  RtabmapDatabase database = Today();
  const camera::Camera& color = Scene().calibration.color;
  const geometry::Rigid3 first = RtabmapBaseFromCamera();
  const geometry::Rigid3 left{
      geometry::Rotation3::FromAxisAngle({0, 0, std::acos(0.0)}), {}};
  RtabmapNode& node = database.nodes[0];
  node.calibration = RtabmapCalibration(color, first) +
                     RtabmapCalibration(color, left * first);
  const auto beside = [](const auto& a, const auto& b, int width,
                         int channels) {
    auto both = a;
    both.clear();
    const auto row = static_cast<ptrdiff_t>(width) * channels;
    for (ptrdiff_t at = 0; at < static_cast<ptrdiff_t>(a.size()); at += row) {
      both.insert(both.end(), a.begin() + at, a.begin() + at + row);
      both.insert(both.end(), b.begin() + at, b.begin() + at + row);
    }
    return both;
  };
  const image::Frame& a = Scene().frames[0];
  const image::Frame& b = Scene().frames[3];
  node.image =
      *image::EncodePng({2 * a.color.width, a.color.height,
                         beside(a.color.rgb, b.color.rgb, a.color.width, 3)});
  node.depth = *image::EncodeDepthPng(
      {2 * a.depth->width, a.depth->height,
       beside(a.depth->values, b.depth->values, a.depth->width, 1), 0.001});
  node.confidence.reset();
  database.nodes.resize(2);
  const auto capture = Open(database);
  ASSERT_TRUE(capture.ok()) << capture.status();
  ASSERT_EQ(capture->frames.size(), 3);
  EXPECT_EQ(capture->frames[0].name, "node 1 camera 0");
  EXPECT_EQ(capture->frames[1].name, "node 2");
  EXPECT_EQ(capture->frames[2].name, "node 1 camera 1");
  const geometry::Rigid3 world_from_base =
      Scene().world_from_camera[0] * first.Inverse();
  EXPECT_LT(geometry::ErrorBetween(capture->frames[2].world_from_camera,
                                   world_from_base * left * first)
                .rotation_rad,
            1e-5);
  EXPECT_EQ(capture->frames[2].color, color);
  const auto of_first = capture->pictures->Load(0);
  const auto of_second = capture->pictures->Load(2);
  ASSERT_TRUE(of_first.ok() && of_second.ok());
  EXPECT_EQ(of_first->color.rgb, a.color.rgb);
  EXPECT_EQ(of_second->color.rgb, b.color.rgb);
  EXPECT_EQ(of_second->depth->values, b.depth->values);
  EXPECT_TRUE(of_second->encoded_color.empty());
}

TEST_F(RtabmapTest, AStereoDatabaseIsRefusedWithWhatToDo) {
  RtabmapDatabase database = Today();
  for (RtabmapNode& node : database.nodes) {
    (*node.calibration)[12] = 1;  // the fourth int32
  }
  const auto today = Open(database);
  EXPECT_EQ(today.status().code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(today.status().message(), HasSubstr("rtabmap-export"));
  // Before 0.18: fx, fy, cx, cy, baseline, width, height, transform.
  RtabmapDatabase old = RtabmapOf(Scene(), "0.16.3", RtabmapDepth::kPng);
  for (RtabmapNode& node : old.nodes) {
    node.calibration->insert(0, std::string(4, '\0'));
  }
  EXPECT_EQ(Open(old).status().code(), absl::StatusCode::kFailedPrecondition);
}

TEST_F(RtabmapTest, PicturesThatAreNotRectifiedKeepTheirDistortion) {
  RtabmapDatabase database = Today();
  std::string without_p = *database.nodes[0].calibration;
  without_p[4 * 9] = 0;  // the number of P
  without_p.erase(44 + 8 * (9 + 5 + 9), 8 * 12);
  const double k1 = -0.1;
  without_p.replace(44 + 8 * 9, 8, reinterpret_cast<const char*>(&k1), 8);
  for (RtabmapNode& node : database.nodes) node.calibration = without_p;
  const auto capture = Open(database);
  ASSERT_TRUE(capture.ok()) << capture.status();
  ASSERT_EQ(capture->frames.size(), kFrames);
  EXPECT_TRUE(capture->frames[0].color.has_distortion());
  EXPECT_EQ(capture->frames[0].color.parameters()[4], k1);
}

TEST_F(RtabmapTest, UncertainDepthIsLeftOut) {
  RtabmapDatabase database = Today();
  const image::DepthImage& depth = *Scene().frames[0].depth;
  std::string confidence(depth.values.size(), 100);
  confidence[5] = 0;
  confidence[6] = 50;
  database.nodes[0].confidence =
      RtabmapMatrix(confidence, depth.height, depth.width, 0);
  for (const int least : {0, 1, 2}) {
    OpenOptions options;
    options.min_confidence = least;
    const auto capture = Open(database, options);
    ASSERT_TRUE(capture.ok()) << capture.status();
    const auto pictures = capture->pictures->Load(0);
    ASSERT_TRUE(pictures.ok()) << pictures.status();
    EXPECT_EQ(pictures->depth->values[5] == 0, least >= 1);
    EXPECT_EQ(pictures->depth->values[6] == 0, least >= 2);
    EXPECT_EQ(pictures->depth->values[7], depth.values[7]);
  }
}

TEST_F(RtabmapTest, DatabasesBeforeVersionTenAreNamed) {
  const std::string path = folder_.Path("old.db");
  sqlite3* file = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &file), SQLITE_OK);
  sqlite3_exec(file,
               "CREATE TABLE Node(id INTEGER); CREATE TABLE Link(a INTEGER); "
               "CREATE TABLE Word(id INTEGER); CREATE TABLE Image(id INTEGER);",
               nullptr, nullptr, nullptr);
  sqlite3_close(file);
  const auto capture = OpenCapture(path, "auto", {});
  EXPECT_THAT(capture.status().message(), HasSubstr("before 0.10"));
}

TEST_F(RtabmapTest, BrokenBlobsLeaveOutTheirNodeAlone) {
  RtabmapDatabase database = Today();
  const std::string calibration = *database.nodes[0].calibration;
  database.nodes[0].calibration = calibration.substr(0, 60);
  database.nodes[1].calibration = std::string(44, '\x7f');
  database.nodes[2].image = "no picture";
  database.nodes[3].depth = database.nodes[3].depth->substr(0, 40);
  const auto capture = Open(database);
  ASSERT_TRUE(capture.ok()) << capture.status();
  ASSERT_EQ(capture->frames.size(), 3);
  ExpectTruePoses(*capture);
  const auto cut = capture->pictures->Load(0);
  ASSERT_FALSE(cut.ok());
  EXPECT_THAT(cut.status().message(), HasSubstr("node 4"));
  EXPECT_TRUE(capture->pictures->Load(1).ok());
}

TEST_F(RtabmapTest, ADatabaseThatIsCutOffIsSaid) {
  const std::string path = folder_.Path("whole.db");
  WriteDatabase(Today(), path);
  const std::string bytes = *base::ReadFile(path);
  folder_.Write("cut.db", bytes.substr(0, bytes.size() / 2));
  const auto capture = OpenCapture(folder_.Path("cut.db"), "auto", {});
  ASSERT_FALSE(capture.ok());
  EXPECT_THAT(capture.status().message(), HasSubstr("rtabmap-recovery"));
}

TEST(RtabmapBlobsTest, PackedMatricesMustBeAsLargeAsTheySay) {
  constexpr int kInts = 4;
  constexpr int kFloats = 5;
  const std::string ids(8, '\0');
  std::string poses = RtabmapPose({}) + RtabmapPose({});
  const auto parse = [](const std::string& a, const std::string& b) {
    return ParseOptimizedPoses(BytesOf(a), BytesOf(b));
  };
  const std::string good_ids = RtabmapMatrix(ids, 1, 2, kInts);
  const std::string good_poses = RtabmapMatrix(poses, 1, 24, kFloats);
  ASSERT_TRUE(parse(good_ids, good_poses).ok());
  EXPECT_FALSE(parse("", good_poses).ok());
  EXPECT_FALSE(parse(good_ids.substr(0, 11), good_poses).ok());
  EXPECT_FALSE(parse(good_ids, RtabmapMatrix(poses, 1, 12, kFloats)).ok());
  EXPECT_FALSE(parse(good_ids, RtabmapMatrix(poses, 1, 36, kFloats)).ok());
  EXPECT_FALSE(parse(good_ids, RtabmapMatrix(poses, 1, 24, kInts)).ok());
  EXPECT_FALSE(parse(good_ids, RtabmapMatrix(poses, -1, 24, kFloats)).ok());
  EXPECT_FALSE(
      parse(RtabmapMatrix(ids.substr(4), 1, 1, kInts), good_poses).ok());
  // Gigabytes of zeros are refused before they are unpacked.
  EXPECT_FALSE(
      parse(good_ids, RtabmapMatrix(poses, 1 << 15, 1 << 15, kFloats)).ok());
  // What is not rigid or not a number is no pose.
  geometry::Rigid3 nowhere;
  nowhere.translation.x = std::numeric_limits<double>::quiet_NaN();
  poses = RtabmapPose(nowhere) + RtabmapPose({});
  const std::string two_ids{'\1', '\0', '\0', '\0', '\2', '\0', '\0', '\0'};
  const auto one = parse(RtabmapMatrix(two_ids, 1, 2, kInts),
                         RtabmapMatrix(poses, 1, 24, kFloats));
  ASSERT_TRUE(one.ok());
  ASSERT_EQ(one->size(), 1);
  EXPECT_EQ(one->begin()->first, 2);
}

TEST(RtabmapBlobsTest, VersionsAreThreeNumbers) {
  EXPECT_EQ(ParseRtabmapVersion("0.21.4")->at(1), 21);
  EXPECT_LT(*ParseRtabmapVersion("0.9.0"), *ParseRtabmapVersion("0.18.0"));
  for (const char* text : {"", "0.21", "0.21.x", "0.21.4.1"}) {
    EXPECT_FALSE(ParseRtabmapVersion(text).ok()) << text;
  }
}

}  // namespace
}  // namespace treeline::capture
