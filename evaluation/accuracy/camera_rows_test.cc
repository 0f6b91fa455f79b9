#include "evaluation/accuracy/camera_rows.h"

#include "absl/strings/str_cat.h"
#include "gtest/gtest.h"
#include "server/tools/testing_fixtures.h"

namespace treeline::accuracy {
namespace {

FrameResult OfCamera(const std::string& camera, double error_m) {
  FrameResult result;
  result.camera = camera;
  result.estimate = tools::LocalizedAt({});
  result.true_world_from_camera = geometry::Rigid3{};
  result.error = geometry::PoseError{error_m, 0};
  return result;
}

TEST(CameraRows, CountEachCameraApart) {
  EvaluatedMethod method;
  method.results = {OfCamera("a", 0.01), OfCamera("b", 0.01),
                    OfCamera("b", 0.2)};
  const std::vector<CameraRow> rows = CameraRows(method, 0.5);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].camera, "b");
  EXPECT_EQ(rows[0].counts.frames, 2);
  EXPECT_EQ(rows[0].counts.right, 1);
  EXPECT_EQ(rows[1].camera, "a");
  EXPECT_EQ(rows[1].counts.right, 1);
}

TEST(CameraRows, AreNoneOfASingleCamera) {
  EvaluatedMethod method;
  method.results = {OfCamera("", 0.01), OfCamera("", 0.2)};
  EXPECT_TRUE(CameraRows(method, 0.5).empty());
}

TEST(CameraRows, PutRareCamerasTogether) {
  EvaluatedMethod method;
  for (int i = 0; i < 30; ++i) {
    method.results.push_back(OfCamera(absl::StrCat("camera ", i), 0.01));
  }
  method.results.push_back(OfCamera("camera 29", 0.01));
  const std::vector<CameraRow> rows = CameraRows(method, 0.5);
  ASSERT_EQ(rows.size(), kMaxCameraRows);
  EXPECT_EQ(rows.front().camera, "camera 29");
  EXPECT_EQ(rows.back().camera, kOtherCameras);
  EXPECT_EQ(rows.back().counts.frames, 19);
}

}  // namespace
}  // namespace treeline::accuracy
