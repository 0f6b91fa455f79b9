// What a source needs to give a candidate, on points whose places are known.
#include "server/core/localizer/pose_source.h"

#include "gtest/gtest.h"
#include "server/core/pose/point_refinement.h"
#include "server/core/pose/point_solver.h"

namespace treeline::localizer {
namespace {

// Sees exact points in two batches.
template <int kWantedInliers>
class FakeSource {
 public:
  using Observations = PointObservations;
  static constexpr uint64_t kRansacStream = 1;
  static constexpr int kMinSamples = 30;
  static constexpr int kMinInliers = kWantedInliers;
  static constexpr bool kIsMatched = false;

  FakeSource(size_t available, size_t first)
      : available_(available), first_(first) {}

  absl::StatusOr<size_t> Observe(Query& /*query*/,
                                 std::span<const Candidate> /*earlier*/,
                                 PointObservations& seen) const {
    const size_t end = seen.size() == 0 ? first_ : available_;
    for (size_t i = seen.size(); i < end; ++i) Append(i, seen);
    return available_;
  }
  pose::PointSolver Solver(Query& /*query*/,
                           const PointObservations& seen) const {
    return {seen.scene, {}};
  }
  std::optional<pose::RefinedPose> Refine(
      Query& /*query*/, const PointObservations& seen,
      const geometry::Rigid3& world_from_camera) const {
    return pose::RefinePoints(seen.scene, world_from_camera, {});
  }
  std::vector<Correspondence> Explain(
      const PointObservations& seen,
      const std::optional<pose::RefinedPose>& pose) const {
    return CorrespondencesOf(seen, pose);
  }

  static geometry::Rigid3 Truth() {
    return {geometry::Rotation3::FromAxisAngle({0.3, -0.2, 0.5}), {1, 2, 3}};
  }

 private:
  // Every third prediction is wrong.
  static void Append(size_t i, PointObservations& seen) {
    base::Random random(1, i);
    const double z = random.NextUniform(1, 3);
    const geometry::Vec3 point{z * random.NextUniform(-0.5, 0.5),
                               z * random.NextUniform(-0.4, 0.4), z};
    const geometry::Vec3 off =
        i % 3 == 0 ? geometry::Vec3{5, 1, 0} : geometry::Vec3{};
    seen.pixel.push_back({static_cast<double>(i), 0});
    seen.scene.point_in_camera.push_back(point);
    seen.scene.depth_sigma_m.push_back(0.01);
    seen.scene.predictions.push_back(
        {Truth() * point + off, {1e-4, 0, 0, 1e-4, 0, 1e-4}});
  }

  size_t available_;
  size_t first_;
};
static_assert(PoseSource<FakeSource<0>>);

template <int kWantedInliers>
absl::StatusOr<Candidate> Propose(const FakeSource<kWantedInliers>& source,
                                  int settled_inliers,
                                  const LocalizeOptions& options = {}) {
  const image::Frame frame;
  const camera::RgbdCalibration calibration;
  QueryScratch scratch;
  Query query(frame, calibration, DepthUse::kIgnored, options, scratch);
  const SourceGenerator<FakeSource<kWantedInliers>> generator(
      source, {.settled_inliers = settled_inliers});
  return generator.Propose(query, {});
}

TEST(SourceGeneratorTest, FindsThePoseAndWhatSupportsIt) {
  const auto candidate = Propose(FakeSource<0>(150, 150), 100);
  ASSERT_TRUE(candidate.ok());
  ASSERT_TRUE(candidate->pose.has_value());
  const geometry::PoseError error = geometry::ErrorBetween(
      candidate->pose->world_from_camera, FakeSource<0>::Truth());
  EXPECT_LT(error.translation_m, 1e-6);
  EXPECT_LT(error.rotation_rad, 1e-6);
  EXPECT_EQ(candidate->pose->inliers, 100);
  EXPECT_DOUBLE_EQ(candidate->inlier_ratio(), 100. / 150);
}

TEST(SourceGeneratorTest, AsksForMoreSamplesOnlyWhileThePoseIsNotSettled) {
  // Two in three of the first 150 support it.
  EXPECT_EQ(Propose(FakeSource<0>(300, 150), 100)->samples, 150);
  const auto more = Propose(FakeSource<0>(300, 150), 101);
  EXPECT_EQ(more->samples, 300);
  EXPECT_EQ(more->pose->inliers, 200);
}

TEST(SourceGeneratorTest, TooFewSamplesGiveNoPoseAndSaySo) {
  const auto candidate = Propose(FakeSource<0>(29, 29), 100);
  ASSERT_TRUE(candidate.ok());
  EXPECT_FALSE(candidate->pose.has_value());
  EXPECT_EQ(candidate->samples, 29);
  EXPECT_EQ(candidate->reason, NotLocalizedReason::kTooFewSamples);
}

TEST(SourceGeneratorTest, APoseOfTooFewInliersIsNotProposed) {
  EXPECT_TRUE(Propose(FakeSource<100>(150, 150), 100)->pose.has_value());
  const auto candidate = Propose(FakeSource<101>(150, 150), 100);
  EXPECT_FALSE(candidate->pose.has_value());
  EXPECT_EQ(candidate->reason, NotLocalizedReason::kTooFewInliers);
}

TEST(SourceGeneratorTest, ExplainsItselfOnRequest) {
  const FakeSource<0> source(150, 150);
  EXPECT_TRUE(Propose(source, 100)->correspondences.empty());
  LocalizeOptions options;
  options.keep_correspondences = true;
  const auto candidate = Propose(source, 100, options);
  ASSERT_EQ(candidate->correspondences.size(), 150u);
  for (size_t i = 0; i < 150; ++i) {
    EXPECT_EQ(candidate->correspondences[i].inlier, i % 3 != 0);
    EXPECT_EQ(candidate->correspondences[i].color_pixel.x,
              static_cast<double>(i));
  }
}

TEST(SourceGeneratorTest, IsCancelledByAStop) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(Propose(FakeSource<0>(150, 150), 100, {.stop = stop.get_token()})
                .status()
                .code(),
            absl::StatusCode::kCancelled);
}

TEST(CorrespondencesTest, TakeTheSupportingPredictionOrTheBest) {
  RayObservations seen;
  seen.scene.per_sample = 2;
  for (const double x : {1., 2.}) {
    seen.pixel.push_back({x, 0});
    seen.scene.ray.push_back({x, 0});
    seen.scene.predictions.push_back({{x, 0, 0}, {}});
    seen.scene.predictions.push_back({{10 * x, 0, 0}, {}});
  }
  pose::RefinedPose pose;
  pose.world_from_camera.translation = {0, 0, -4};
  pose.supported = {1, -1};
  const auto of_rays = CorrespondencesOf(seen, pose);
  ASSERT_EQ(of_rays.size(), 2u);
  EXPECT_TRUE(of_rays[0].inlier);
  EXPECT_EQ(of_rays[0].point_in_world, (geometry::Vec3{10, 0, 0}));
  EXPECT_EQ(of_rays[0].point_in_camera, (geometry::Vec3{}));
  EXPECT_FALSE(of_rays[1].inlier);
  EXPECT_EQ(of_rays[1].point_in_world, (geometry::Vec3{2, 0, 0}));
  // Of matches also where they are in the camera, if there is a pose.
  EXPECT_EQ(MatchesOf(seen, pose)[0].point_in_camera,
            (geometry::Vec3{10, 0, 4}));
  EXPECT_EQ(MatchesOf(seen, std::nullopt)[0].point_in_camera,
            (geometry::Vec3{}));
  EXPECT_EQ(MatchesOf(seen, std::nullopt)[0].point_in_world,
            (geometry::Vec3{1, 0, 0}));
}

TEST(CountPlacesTest, FeaturesAtOnePlaceCountOnce) {
  RayObservations seen;
  pose::RefinedPose pose;
  const auto add = [&](double x, double y, int8_t supported) {
    seen.pixel.push_back({x, y});
    seen.scene.ray.push_back({x, y});
    pose.supported.push_back(supported);
  };
  add(10, 10, 0);
  add(10, 10, 0);   // another size
  add(13, 14, 0);   // 5 px away
  add(50, 10, -1);  // does not support the pose
  add(90, 10, 0);
  EXPECT_EQ(CountPlaces(seen, pose, 5.1, 100), 2);
  EXPECT_EQ(CountPlaces(seen, pose, 4.9, 100), 3);
  EXPECT_EQ(CountPlaces(seen, pose, 4.9, 2), 2) << "enough";
}

}  // namespace
}  // namespace treeline::localizer
