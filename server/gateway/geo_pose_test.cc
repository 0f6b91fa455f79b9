#include "server/gateway/geo_pose.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace treeline::gateway {
namespace {

using ::testing::DoubleNear;

constexpr double kRadPerDeg = std::numbers::pi / 180;

v1::GeoAnchor Anchor(double latitude_deg, double longitude_deg, double height_m,
                     const geometry::Rotation3& enu_from_world = {}) {
  v1::GeoAnchor anchor;
  anchor.set_latitude_deg(latitude_deg);
  anchor.set_longitude_deg(longitude_deg);
  anchor.set_height_m(height_m);
  anchor.mutable_enu_from_world()->set_w(enu_from_world.w);
  anchor.mutable_enu_from_world()->set_x(enu_from_world.x);
  anchor.mutable_enu_from_world()->set_y(enu_from_world.y);
  anchor.mutable_enu_from_world()->set_z(enu_from_world.z);
  return anchor;
}

GeoFrame Frame(const v1::GeoAnchor& anchor) {
  return GeoFrame::Create(anchor, "geo_anchor").value();
}

// Seeded numbers that need not be the same on every library.
class Draws {
 public:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  geometry::Rotation3 Rotation() {
    return geometry::Rotation3::FromAxisAngle(
        {Uniform(-3, 3), Uniform(-3, 3), Uniform(-3, 3)});
  }

 private:
  std::mt19937_64 engine_{20261121};
};

TEST(Geodesy, KnowsTheAxesOfTheEllipsoid) {
  EXPECT_NEAR(EcefFromGeodetic({0, 0, 0}).x, 6378137.0, 1e-9);
  EXPECT_NEAR(EcefFromGeodetic({0, 90, 0}).y, 6378137.0, 1e-9);
  EXPECT_NEAR(EcefFromGeodetic({90, 0, 0}).z, 6356752.314245, 1e-6);
  EXPECT_NEAR(EcefFromGeodetic({-90, 0, 10}).z, -6356762.314245, 1e-6);
  EXPECT_NEAR(EcefFromGeodetic({0, 180, 0}).x, -6378137.0, 1e-9);
}

// What defines geodetic coordinates, without their formulas: the foot lies on
// the ellipsoid, and up is the normal of the ellipsoid there.
TEST(Geodesy, UpIsTheNormalOfTheEllipsoid) {
  Draws draws;
  const double a2 = std::pow(6378137.0, 2);
  const double b2 = std::pow(6356752.314245, 2);
  for (int i = 0; i < 1000; ++i) {
    const GeodeticPosition foot{draws.Uniform(-90, 90),
                                draws.Uniform(-180, 180), 0};
    const geometry::Vec3 point = EcefFromGeodetic(foot);
    EXPECT_NEAR(
        (point.x * point.x + point.y * point.y) / a2 + point.z * point.z / b2,
        1, 1e-12);
    const geometry::Vec3 normal = geometry::Normalized(
        geometry::Vec3{point.x / a2, point.y / a2, point.z / b2});
    EXPECT_LT(
        geometry::Norm(EcefFromEnu(foot) * geometry::Vec3{0, 0, 1} - normal),
        1e-12);
    GeodeticPosition above = foot;
    above.height_m = 123;
    EXPECT_LT(geometry::Norm(EcefFromGeodetic(above) - point - 123 * normal),
              1e-6);
  }
}

TEST(Geodesy, ComesBackFromEcefWithinAMicrometre) {
  Draws draws;
  for (int i = 0; i < 20000; ++i) {
    const GeodeticPosition position{draws.Uniform(-90, 90),
                                    draws.Uniform(-180, 180),
                                    draws.Uniform(-11000, 50000)};
    const geometry::Vec3 point = EcefFromGeodetic(position);
    const GeodeticPosition back = GeodeticFromEcef(point);
    ASSERT_LT(geometry::Norm(EcefFromGeodetic(back) - point), 1e-6);
    ASSERT_NEAR(back.latitude_deg, position.latitude_deg, 1e-11);
    ASSERT_NEAR(back.height_m, position.height_m, 1e-6);
  }
}

TEST(Geodesy, EastIsAlongTheParallelAndNorthToThePole) {
  const GeodeticPosition here{48, 11, 500};
  const geometry::Vec3 origin = EcefFromGeodetic(here);
  const geometry::Rotation3 enu_from_ecef = EcefFromEnu(here).Inverse();
  const geometry::Vec3 east =
      enu_from_ecef * (EcefFromGeodetic({48, 11.001, 500}) - origin);
  EXPECT_GT(east.x, 70);
  EXPECT_NEAR(east.y, 0, 1e-3);
  const geometry::Vec3 north =
      enu_from_ecef * (EcefFromGeodetic({48.001, 11, 500}) - origin);
  EXPECT_NEAR(north.x, 0, 1e-6);
  EXPECT_GT(north.y, 110);
}

TEST(GeoFrame, ALevelCameraThatLooksNorthHasTheIdentity) {
  // World axes East, North, Up: camera x is East, y down, z North.
  const geometry::Rotation3 world_from_camera = geometry::Rotation3::FromMatrix(
      geometry::Mat3{{1, 0, 0, 0, 0, 1, 0, -1, 0}});
  const GeoPose pose =
      Frame(Anchor(48, 11, 500)).ToGeoPose({world_from_camera, {}});
  EXPECT_LT(
      geometry::AngleBetween_rad(pose.enu_from_device, geometry::Rotation3{}),
      1e-9);
  EXPECT_NEAR(pose.position.latitude_deg, 48, 1e-12);
  EXPECT_NEAR(pose.position.longitude_deg, 11, 1e-12);
  EXPECT_NEAR(pose.position.height_m, 500, 1e-6);
}

TEST(GeoFrame, ACameraThatLooksEastIsTurnedMinus90DegreesAboutUp) {
  // Camera x is South, y down, z East.
  const geometry::Rotation3 world_from_camera = geometry::Rotation3::FromMatrix(
      geometry::Mat3{{0, 0, 1, -1, 0, 0, 0, -1, 0}});
  const GeoPose pose =
      Frame(Anchor(-33, 151, 20)).ToGeoPose({world_from_camera, {}});
  const geometry::Rotation3 expected =
      geometry::Rotation3::FromAxisAngle({0, 0, -90 * kRadPerDeg});
  EXPECT_LT(geometry::AngleBetween_rad(pose.enu_from_device, expected), 1e-9);
}

TEST(GeoFrame, TheAnchorsRotationTurnsTheWorld) {
  // World x points North: enu_from_world is a quarter turn about up.
  const GeoFrame frame = Frame(Anchor(
      10, 20, 0, geometry::Rotation3::FromAxisAngle({0, 0, 90 * kRadPerDeg})));
  const GeoPose pose = frame.ToGeoPose({{}, {100, 0, 0}});
  EXPECT_GT(pose.position.latitude_deg, 10.0008);
  EXPECT_NEAR(pose.position.longitude_deg, 20, 1e-9);
}

// East at the camera is not East at the anchor: 3 km further east at latitude
// 60 the meridians have turned by 3000 m / (radius * cot 60).
TEST(GeoFrame, TheOrientationIsThatAtTheCamera) {
  const geometry::Rotation3 world_from_camera = geometry::Rotation3::FromMatrix(
      geometry::Mat3{{1, 0, 0, 0, 0, 1, 0, -1, 0}});
  const GeoPose pose =
      Frame(Anchor(60, 0, 0)).ToGeoPose({world_from_camera, {3000, 0, 0}});
  const geometry::Vec3 axis_angle = geometry::ToAxisAngle(pose.enu_from_device);
  const double expected_rad =
      3000 / 6378137.0 / (1 / std::tan(60 * kRadPerDeg));
  EXPECT_NEAR(std::abs(axis_angle.z), expected_rad, 0.01 * expected_rad);
}

struct Place {
  double latitude_deg;
  double longitude_deg;
};

// The target of the issue is 1 mm and 0.001 degree.
TEST(GeoFrame, RoundTripsWithinMicrometresEverywhere) {
  Draws draws;
  const std::array<Place, 9> places{{{0, 0},
                                     {48.1, 11.6},
                                     {-33.9, 151.2},
                                     {90, 0},
                                     {90, 135},
                                     {-90, -77},
                                     {12, 180},
                                     {-12, -180},
                                     {89.9999, 179.9999}}};
  for (const Place& place : places) {
    for (int i = 0; i < 500; ++i) {
      const GeoFrame frame =
          Frame(Anchor(place.latitude_deg, place.longitude_deg,
                       draws.Uniform(-100, 3000), draws.Rotation()));
      const geometry::Rigid3 world_from_camera{
          draws.Rotation(),
          {draws.Uniform(-4000, 4000), draws.Uniform(-4000, 4000),
           draws.Uniform(-300, 300)}};
      const geometry::PoseError error = geometry::ErrorBetween(
          frame.FromGeoPose(frame.ToGeoPose(world_from_camera)),
          world_from_camera);
      ASSERT_LT(error.translation_m, 1e-6) << place.latitude_deg;
      ASSERT_LT(error.rotation_rad, 1e-8) << place.latitude_deg;
    }
  }
}

TEST(GeoFrame, RoundTripsWhenThePositionGoesThroughText) {
  const GeoFrame frame = Frame(Anchor(51.5, -0.1, 40));
  const geometry::Rigid3 world_from_camera{
      geometry::Rotation3::FromAxisAngle({0.1, 0.2, 0.3}), {10, -20, 3}};
  GeoPose pose = frame.ToGeoPose(world_from_camera);
  // 1e-9 degree is a tenth of a millimetre.
  pose.position.latitude_deg =
      std::round(pose.position.latitude_deg * 1e9) / 1e9;
  pose.position.longitude_deg =
      std::round(pose.position.longitude_deg * 1e9) / 1e9;
  EXPECT_LT(geometry::ErrorBetween(frame.FromGeoPose(pose), world_from_camera)
                .translation_m,
            1e-3);
}

TEST(GeoFrame, CrossesTheAntimeridian) {
  const GeoPose east =
      Frame(Anchor(10, 179.9999, 0)).ToGeoPose({{}, {100, 0, 0}});
  EXPECT_LT(east.position.longitude_deg, -179.99);
  const GeoPose west =
      Frame(Anchor(10, -179.9999, 0)).ToGeoPose({{}, {-100, 0, 0}});
  EXPECT_GT(west.position.longitude_deg, 179.99);
}

TEST(GeoFrame, RefusesWhatIsNoPlace) {
  EXPECT_FALSE(GeoFrame::Create(Anchor(90.1, 0, 0), "a").ok());
  EXPECT_FALSE(GeoFrame::Create(Anchor(0, 181, 0), "a").ok());
  EXPECT_FALSE(GeoFrame::Create(Anchor(0, 0, NAN), "a").ok());
  EXPECT_FALSE(GeoFrame::Create(Anchor(NAN, 0, 0), "a").ok());
  EXPECT_FALSE(GeoFrame::Create(Anchor(0, 0, 0, {2, 0, 0, 0}), "a").ok());
}

TEST(GeoFrame, TakesAnAbsentRotationAsTheIdentity) {
  v1::GeoAnchor anchor = Anchor(10, 20, 30);
  const GeoPose with = Frame(anchor).ToGeoPose({{}, {1, 2, 3}});
  anchor.clear_enu_from_world();
  const GeoPose without = Frame(anchor).ToGeoPose({{}, {1, 2, 3}});
  EXPECT_EQ(with.position, without.position);
}

std::array<double, 36> Diagonal(const std::array<double, 6>& variances) {
  std::array<double, 36> covariance{};
  for (size_t i = 0; i < 6; ++i) covariance[7 * i] = variances[i];
  return covariance;
}

TEST(Accuracy, IsTheLongestHalfAxisOfThe95PercentEllipsoid) {
  const auto covariance = Diagonal({1e-4, 4e-4, 1e-4, 1e-6, 1e-6, 9e-6});
  const GeoAccuracy accuracy = AccuracyOf(covariance.data(), 36).value();
  EXPECT_THAT(accuracy.position_m, DoubleNear(0.02 * 2.79548, 1e-6));
  EXPECT_THAT(accuracy.orientation_deg,
              DoubleNear(0.003 * 2.79548 / kRadPerDeg, 1e-4));
}

TEST(Accuracy, HoldsAtLeast95PercentOfTheDraws) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal;
  for (const double thin : {1.0, 0.5, 0.01}) {
    const auto covariance = Diagonal({1, thin, thin, 1, 1, 1});
    const double radius = AccuracyOf(covariance.data(), 36)->position_m;
    int inside = 0;
    for (int i = 0; i < 20000; ++i) {
      const geometry::Vec3 error{normal(engine),
                                 std::sqrt(thin) * normal(engine),
                                 std::sqrt(thin) * normal(engine)};
      inside += geometry::Norm(error) <= radius ? 1 : 0;
    }
    // Three standard deviations of the count below 95 %.
    EXPECT_GT(inside, 19000 - 93) << thin;
  }
}

TEST(Accuracy, IsNeverMoreThanHalfATurnAndNeverNegative) {
  const auto wild = Diagonal({0, 0, 0, 100, 100, 100});
  EXPECT_EQ(AccuracyOf(wild.data(), 36)->orientation_deg, 180);
  EXPECT_EQ(AccuracyOf(wild.data(), 36)->position_m, 0);
  const auto negative = Diagonal({-1, -1, -1, 1, 1, 1});
  EXPECT_FALSE(AccuracyOf(negative.data(), 36).ok());
  EXPECT_FALSE(AccuracyOf(negative.data(), 0).ok());
}

}  // namespace
}  // namespace treeline::gateway
