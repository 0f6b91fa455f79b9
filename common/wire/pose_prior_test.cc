#include "common/wire/pose_prior.h"

#include <limits>
#include <string>

#include "absl/strings/escaping.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::wire {
namespace {

using ::testing::StartsWith;

geometry::PosePriors All() {
  geometry::PosePriors priors;
  priors.pose = geometry::PosePrior{
      .world_from_camera = {geometry::Rotation3::FromAxisAngle({0.1, 0.2, 0.3}),
                            {1, 2, 3}},
      .position_radius_m = 0.5,
      .rotation_radius_rad = 0.25};
  priors.position = geometry::PositionPrior{{4, 5, 6}, 7};
  priors.height =
      geometry::HeightBand{.up_in_world = {0, -1, 0}, .min_m = -2, .max_m = 8};
  return priors;
}

TEST(WirePosePrior, EveryPriorArrivesAsItWasSent) {
  v1::LocalizeOptions proto;
  FillPriors(All(), proto);
  const auto priors = PriorsFromProto(proto, "options");
  ASSERT_TRUE(priors.ok()) << priors.status();
  EXPECT_EQ(priors->pose->world_from_camera, All().pose->world_from_camera);
  EXPECT_EQ(priors->pose->position_radius_m, 0.5);
  EXPECT_EQ(priors->pose->rotation_radius_rad, 0.25);
  EXPECT_EQ(priors->position->position_in_world, (geometry::Vec3{4, 5, 6}));
  EXPECT_EQ(priors->position->radius_m, 7);
  EXPECT_EQ(priors->height->up_in_world, (geometry::Vec3{0, -1, 0}));
  EXPECT_EQ(priors->height->min_m, -2);
  EXPECT_EQ(priors->height->max_m, 8);
}

// Other programs speak this contract too: the bytes must stay.
TEST(WirePosePrior, PlacesAndHeightsHaveTheseBytes) {
  geometry::PosePriors priors;
  priors.position = geometry::PositionPrior{{1, 0, 0}, 1};
  priors.height = geometry::HeightBand{.min_m = -1, .max_m = 1};
  v1::LocalizeOptions proto;
  FillPriors(priors, proto);
  EXPECT_EQ(absl::BytesToHexString(proto.SerializeAsString()),
            "3214"
            "0a0909000000000000f03f"
            "11000000000000f03f"
            "3a1d"
            "0a0919000000000000f03f"
            "11000000000000f0bf"
            "19000000000000f03f");
}

TEST(WirePosePrior, WhatIsNotSentIsNotKnown) {
  v1::LocalizeOptions proto;
  FillPriors({}, proto);
  EXPECT_EQ(proto.ByteSizeLong(), 0u);
  EXPECT_TRUE(PriorsFromProto(proto, "options")->empty());
  // Up is z where nothing is said of it.
  proto.mutable_height_band()->set_max_m(1);
  EXPECT_EQ(PriorsFromProto(proto, "options")->height->up_in_world,
            (geometry::Vec3{0, 0, 1}));
}

TEST(WirePosePrior, WhatIsWrongNamesItsField) {
  const auto complaint = [](auto change) {
    v1::LocalizeOptions proto;
    FillPriors(All(), proto);
    change(proto);
    const absl::Status status = PriorsFromProto(proto, "options").status();
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    return std::string(status.message());
  };
  EXPECT_THAT(
      complaint([](auto& o) { o.mutable_prior()->clear_world_from_camera(); }),
      StartsWith("options.prior.world_from_camera: "));
  EXPECT_THAT(
      complaint([](auto& o) { o.mutable_prior()->set_position_radius_m(0); }),
      StartsWith("options.prior.position_radius_m: "));
  EXPECT_THAT(complaint([](auto& o) {
                o.mutable_position_prior()->clear_position_in_world_m();
              }),
              StartsWith("options.position_prior.position_in_world_m: "));
  EXPECT_THAT(
      complaint([](auto& o) { o.mutable_position_prior()->set_radius_m(-1); }),
      StartsWith("options.position_prior.radius_m: "));
  EXPECT_THAT(complaint([](auto& o) {
                o.mutable_height_band()->mutable_up_in_world()->set_y(0);
              }),
              StartsWith("options.height_band.up_in_world: "));
  EXPECT_THAT(complaint([](auto& o) {
                o.mutable_height_band()->set_max_m(
                    std::numeric_limits<double>::quiet_NaN());
              }),
              StartsWith("options.height_band.max_m: "));
}

}  // namespace
}  // namespace treeline::wire
