#include "server/tools/photographs/structure_from_motion.h"

#include <sys/stat.h>

#include <cmath>

#include "common/base/file.h"
#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::photographs {
namespace {

using testing::HasSubstr;

class StructureFromMotionTest : public testing::Test {
 protected:
  // A program in COLMAP's place that runs this shell script.
  StructureOptions With(const std::string& script) const {
    const std::string program =
        folder_.Write("colmap", "#!/bin/sh\n" + script + "\n");
    chmod(program.c_str(), 0755);
    return {.colmap = program,
            .images = folder_.path(),
            .work = folder_.Path("work"),
            .pictures = 30,
            .quiet = true};
  }

  const base::TestingFolder folder_;
};

TEST_F(StructureFromMotionTest, WithoutColmapItSaysWhatToInstall) {
  const absl::Status status = FindColmap("no-such-colmap").status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(status.message(), HasSubstr("apt install colmap"));
  EXPECT_THAT(FindColmap(folder_.Path("none")).status().message(),
              HasSubstr("there is no " + folder_.Path("none")));
  const StructureOptions options = With("exit 0");
  EXPECT_EQ(FindColmap(options.colmap).value(), options.colmap);
  EXPECT_TRUE(FindColmap("sh").ok());
}

TEST_F(StructureFromMotionTest, PicturesThatDoNotGoTogetherAreSaid) {
  const absl::Status status = ComputeStructure(With("exit 0"), {}).status();
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_THAT(status.message(), HasSubstr("the 30 pictures"));
}

TEST_F(StructureFromMotionTest, WhatColmapSaysOfItsFailureIsTold) {
  const absl::Status status =
      ComputeStructure(
          With("echo database is locked; [ $1 != exhaustive_matcher ]"), {})
          .status();
  EXPECT_EQ(status.code(), absl::StatusCode::kUnknown);
  EXPECT_THAT(status.message(), HasSubstr("database is locked"));
}

TEST_F(StructureFromMotionTest, NothingIsAskedOfAGpu) {
  const StructureOptions options =
      With("echo \"$@\" >> " + folder_.Path("calls"));
  (void)ComputeStructure(options, {});
  const auto calls = base::ReadFile(folder_.Path("calls"));
  ASSERT_TRUE(calls.ok());
  EXPECT_THAT(*calls, HasSubstr("--SiftExtraction.use_gpu 0"));
  EXPECT_THAT(*calls, HasSubstr("--SiftMatching.use_gpu 0"));
  EXPECT_THAT(*calls, HasSubstr("mapper"));
}

TEST_F(StructureFromMotionTest, StoppingEndsColmap) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled(
      ComputeStructure(With("sleep 600"), stop.get_token()).status()));
}

// Cameras that look level in a world whose y axis points down, as that of a
// structure usually does, and with -z up.
TEST(UprightTest, WhatIsUpInThePicturesBecomesZ) {
  dataset::SfmModel model;
  for (const double yaw : {0.0, 1.0, 2.5}) {
    dataset::SfmModel::Image image;
    image.camera_from_world.rotation = {std::cos(yaw / 2), 0, std::sin(yaw / 2),
                                        0};
    model.images.push_back(image);
  }
  const geometry::Vec3 up = UprightFromModel(model) * geometry::Vec3{0, -1, 0};
  EXPECT_NEAR(up.z, 1, 1e-12);
  // Up is -z: half a turn.
  model.images.resize(1);
  model.images[0].camera_from_world.rotation =
      geometry::Rotation3{std::sqrt(0.5), std::sqrt(0.5), 0, 0};
  const geometry::Vec3 camera_up =
      model.images[0].camera_from_world.rotation.Inverse() *
      geometry::Vec3{0, -1, 0};
  const geometry::Vec3 turned = UprightFromModel(model) * camera_up;
  EXPECT_NEAR(turned.z, 1, 1e-9);
  EXPECT_EQ(UprightFromModel({}), geometry::Rotation3{});
}

TEST(ScaleTest, ADistanceGivesMetres) {
  dataset::SfmModel model;
  model.images.resize(2);
  model.images[0].name = "a.jpg";
  model.images[1].name = "b.jpg";
  model.images[1].camera_from_world.translation = {0, 0, -4};
  EXPECT_DOUBLE_EQ(ScaleOfDistance(model, "a.jpg", "b.jpg", 2).value(), 0.5);
  EXPECT_THAT(ScaleOfDistance(model, "a.jpg", "c.jpg", 2).status().message(),
              HasSubstr("no picture c.jpg"));
  EXPECT_THAT(ScaleOfDistance(model, "a.jpg", "a.jpg", 2).status().message(),
              HasSubstr("one place"));
}

}  // namespace
}  // namespace treeline::photographs
