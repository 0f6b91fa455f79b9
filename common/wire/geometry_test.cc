#include "common/wire/geometry.h"

#include <limits>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::wire {
namespace {

using ::testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

geometry::Rigid3 RandomPose(uint64_t stream) {
  base::Random random(/*seed=*/7, stream);
  const geometry::Vec3 axis_angle_rad{random.NextUniform(-2, 2),
                                      random.NextUniform(-2, 2),
                                      random.NextUniform(-2, 2)};
  return {
      geometry::Normalized(geometry::Rotation3::FromAxisAngle(axis_angle_rad)),
      {random.NextGaussian(), random.NextGaussian(), random.NextGaussian()}};
}

std::string MessageOf(const absl::Status& status) {
  return std::string(status.message());
}

TEST(WireGeometry, VectorsRoundTripBitForBit) {
  const geometry::Vec3 v{0.1, -1e300, 5e-324};
  const auto back = FromProto(ToProto(v), "v");
  ASSERT_TRUE(back.ok()) << back.status();
  EXPECT_EQ(*back, v);
}

TEST(WireGeometry, VectorsThatAreNotFiniteAreRefusedByName) {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    const auto result =
        FromProto(ToProto(geometry::Vec3{0, bad, 0}), "bounds.low");
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
    EXPECT_THAT(MessageOf(result.status()), HasSubstr("bounds.low"));
  }
}

TEST(WireGeometry, PixelsRoundTripBitForBit) {
  const camera::Pixel back = FromProto(ToProto(camera::Pixel{319.5, 0.1}));
  EXPECT_EQ(back.x, 319.5);
  EXPECT_EQ(back.y, 0.1);
}

// A pose that the server computed must reach the client unchanged, although
// the norm of its quaternion is 1 only up to rounding.
TEST(WireGeometry, PosesRoundTripBitForBit) {
  int not_exactly_unit = 0;
  for (uint64_t i = 0; i < 1000; ++i) {
    const geometry::Rigid3 pose = RandomPose(i);
    const auto back = FromProto(ToProto(pose), "world_from_camera");
    ASSERT_TRUE(back.ok()) << back.status();
    ASSERT_EQ(*back, pose) << "pose " << i;
    not_exactly_unit += !(geometry::Normalized(pose.rotation) == pose.rotation);
  }
  // Else the test above would prove nothing.
  EXPECT_GT(not_exactly_unit, 0);
}

TEST(WireGeometry, NearlyUnitQuaternionsAreNormalised) {
  v1::Pose proto = ToProto(RandomPose(1));
  proto.mutable_rotation()->set_w(proto.rotation().w() * 1.002);
  const auto pose = FromProto(proto, "pose");
  ASSERT_TRUE(pose.ok()) << pose.status();
  const geometry::Rotation3& q = pose->rotation;
  EXPECT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1, 1e-15);
}

TEST(WireGeometry, PosesWithoutTranslationAreAtTheOrigin) {
  v1::Pose proto = ToProto(RandomPose(2));
  proto.clear_translation_m();
  const auto pose = FromProto(proto, "pose");
  ASSERT_TRUE(pose.ok()) << pose.status();
  EXPECT_EQ(pose->translation, (geometry::Vec3{0, 0, 0}));
}

TEST(WireGeometry, PosesThatAreNoneAreRefusedByName) {
  v1::Pose no_rotation = ToProto(RandomPose(3));
  no_rotation.clear_rotation();
  v1::Pose zero = ToProto(RandomPose(3));
  zero.mutable_rotation()->Clear();
  v1::Pose twice = ToProto(RandomPose(3));
  for (auto [set, get] :
       {std::pair{&v1::Quaternion::set_w, &v1::Quaternion::w},
        std::pair{&v1::Quaternion::set_x, &v1::Quaternion::x},
        std::pair{&v1::Quaternion::set_y, &v1::Quaternion::y},
        std::pair{&v1::Quaternion::set_z, &v1::Quaternion::z}}) {
    v1::Quaternion& q = *twice.mutable_rotation();
    (q.*set)(2 * (q.*get)());
  }
  v1::Pose nan = ToProto(RandomPose(3));
  nan.mutable_rotation()->set_y(kNan);
  v1::Pose far = ToProto(RandomPose(3));
  far.mutable_translation_m()->set_z(kInfinity);
  for (const v1::Pose& bad : {no_rotation, zero, twice, nan, far}) {
    const auto result = FromProto(bad, "frame.color_from_depth");
    EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument)
        << bad.ShortDebugString();
    EXPECT_THAT(MessageOf(result.status()),
                HasSubstr("frame.color_from_depth"));
  }
}

}  // namespace
}  // namespace treeline::wire
