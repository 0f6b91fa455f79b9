// The search for the best candidate, with generators and a verifier that say
// what the test wants.
#include "server/core/localizer/pipeline.h"

#include <cmath>
#include <deque>
#include <map>
#include <utility>

#include "gtest/gtest.h"

namespace treeline::localizer {
namespace {

// What a generator was asked.
struct Asked {
  int times = 0;
  size_t earlier = 0;
};

class FakeGenerator final : public CandidateGenerator {
 public:
  FakeGenerator(absl::StatusOr<Candidate> answer, Asked* asked)
      : answer_(std::move(answer)), asked_(asked) {}

  absl::StatusOr<Candidate> Propose(
      Query& /*query*/, std::span<const Candidate> earlier) const override {
    ++asked_->times;
    asked_->earlier = earlier.size();
    return answer_;
  }

 private:
  const absl::StatusOr<Candidate> answer_;
  Asked* const asked_;
};

// Looks its verdict up by the pose's inliers.
class FakeVerifier final : public PoseVerifier {
 public:
  FakeVerifier(std::map<int, Verdict> verdicts, int* verified,
               std::optional<keyframes::DepthScale> depth)
      : verdicts_(std::move(verdicts)), verified_(verified), depth_(depth) {}

  Verdict Verify(Query& /*query*/, const Candidate& candidate) const override {
    ++*verified_;
    return verdicts_.at(candidate.pose->inliers);
  }
  double MinConfidence(const LocalizeOptions& /*options*/) const override {
    return 0.5;
  }
  double MaxPositionSigma() const override { return 0.05; }
  std::optional<keyframes::DepthScale> MeasureDepth(
      Query& /*query*/,
      const geometry::Rigid3& /*world_from_camera*/) const override {
    return depth_;
  }

 private:
  const std::map<int, Verdict> verdicts_;
  int* const verified_;
  const std::optional<keyframes::DepthScale> depth_;
};

// A candidate with the pose that the verifier knows by `number`.
Candidate Pose(int number) {
  Candidate candidate;
  candidate.samples = 100;
  candidate.pose.emplace();
  candidate.pose->inliers = number;
  return candidate;
}

Candidate NoPose(int samples) {
  Candidate candidate;
  candidate.samples = samples;
  candidate.reason = NotLocalizedReason::kTooFewInliers;
  return candidate;
}

Verdict Believed(double confidence) { return {.confidence = confidence}; }
Verdict Refused(double confidence) {
  return {.reason = NotLocalizedReason::kLowConfidence,
          .confidence = confidence};
}

class SelectCandidateTest : public testing::Test {
 protected:
  Asked& AddStep(absl::StatusOr<Candidate> answer, bool is_fallback = false,
                 bool is_shortcut = false) {
    Asked& asked = asked_.emplace_back();
    method_.steps.push_back(
        {std::make_unique<FakeGenerator>(std::move(answer), &asked),
         is_fallback, is_shortcut});
    return asked;
  }
  Asked& AddShortcut(absl::StatusOr<Candidate> answer) {
    return AddStep(std::move(answer), /*is_fallback=*/false,
                   /*is_shortcut=*/true);
  }

  absl::StatusOr<Selection> Select(std::map<int, Verdict> verdicts,
                                   const LocalizeOptions& options = {}) {
    method_.verifier =
        std::make_unique<FakeVerifier>(std::move(verdicts), &verified_, depth_);
    const image::Frame frame;
    const camera::RgbdCalibration calibration;
    QueryScratch scratch;
    Query query(frame, calibration, method_.depth_use, options, scratch);
    if (is_focal_doubtful_) query.set_focal_doubtful();
    query.set_depth_scale_open(is_depth_scale_open_);
    return SelectCandidate(method_, query);
  }

  Method method_;
  std::deque<Asked> asked_;
  int verified_ = 0;
  bool is_focal_doubtful_ = false;
  bool is_depth_scale_open_ = true;
  std::optional<keyframes::DepthScale> depth_;
};

TEST_F(SelectCandidateTest, TheFirstVerifiedPoseIsTheAnswerUnlessAskedForMore) {
  AddStep(Pose(1));
  const Asked& second = AddStep(Pose(2));
  const auto selection = Select({{1, Refused(0.1)}, {2, Believed(0.9)}});
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.pose->inliers, 1);
  EXPECT_FALSE(selection->verdict->is_believed());
  EXPECT_EQ(second.times, 0);
}

// A forest's pose that is sure, from which depth seems 1 % too near, then those
// of two sources of matched features.
class ScaledDepthTest : public SelectCandidateTest {
 protected:
  ScaledDepthTest() {
    method_.sufficient_confidence = 0.9;
    AddStep(Pose(1));
    for (const int number : {102, 103}) {
      Candidate matched = Pose(number);
      matched.is_matched = true;
      matched.focal = kFocal;
      features_.push_back(&AddStep(std::move(matched)));
    }
  }
  absl::StatusOr<Selection> SelectAmongThem() {
    Verdict suspect = Believed(0.95);
    suspect.depth_scale = keyframes::DepthScale{.scale = 1.01};
    return Select({{1, suspect}, {102, suspect}, {103, suspect}});
  }

  static constexpr pose::FocalEstimate kFocal{.scale = 1.001, .sigma = 0.005};
  std::vector<const Asked*> features_;
};

TEST_F(ScaledDepthTest, FeaturesMeasureItWhereASurePoseDoubtsIt) {
  depth_ = {.scale = 1.05, .sigma = 0.004, .points = 300, .agreement = 0.9};
  const auto selection = SelectAmongThem();
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->depth_scale, 1.05);
  EXPECT_EQ(features_[0]->times, 1);
  EXPECT_EQ(features_[1]->times, 0);
}

TEST_F(ScaledDepthTest, APoseIsSureWhereItFits) {
  depth_ = {.scale = 1.003, .sigma = 0.004, .points = 300, .agreement = 0.9};
  const auto selection = SelectAmongThem();
  ASSERT_TRUE(selection.ok());
  EXPECT_FALSE(selection->depth_scale.has_value());
  EXPECT_TRUE(selection->verdict->is_believed());
  EXPECT_EQ(features_[1]->times, 0);
}

TEST_F(ScaledDepthTest, OneThatExplainsLittleOrIsVagueCorrectsNothing) {
  for (const keyframes::DepthScale& depth :
       {keyframes::DepthScale{.scale = 1.05, .sigma = 0.004, .agreement = 0.5},
        keyframes::DepthScale{
            .scale = 1.05, .sigma = 0.05, .agreement = 0.9}}) {
    depth_ = depth;
    const auto selection = SelectAmongThem();
    ASSERT_TRUE(selection.ok());
    EXPECT_FALSE(selection->depth_scale.has_value());
  }
  EXPECT_EQ(features_[1]->times, 1);
}

TEST_F(ScaledDepthTest, ItIsNoQuestionOnceItIsSettled) {
  is_depth_scale_open_ = false;
  depth_ = {.scale = 1.05, .sigma = 0.004, .points = 300, .agreement = 0.9};
  const auto selection = SelectAmongThem();
  ASSERT_TRUE(selection.ok());
  EXPECT_FALSE(selection->depth_scale.has_value());
  EXPECT_EQ(features_[0]->times, 0);
}

TEST_F(ScaledDepthTest, AFocalLengthThatMayBeGuessedIsSettledFirst) {
  is_focal_doubtful_ = true;
  depth_ = {.scale = 1.05, .sigma = 0.004, .points = 300, .agreement = 0.9};
  const auto known = SelectAmongThem();
  ASSERT_TRUE(known.ok());
  EXPECT_EQ(known->depth_scale, 1.05);
  // Where the picture does not tell it, or tells another, depth might lie.
  for (const pose::FocalEstimate& focal :
       {pose::FocalEstimate{.scale = 1.001, .sigma = 0.02},
        pose::FocalEstimate{.scale = 1.03, .sigma = 0.004}}) {
    method_.steps.clear();
    Candidate matched = Pose(102);
    matched.is_matched = true;
    matched.focal = focal;
    AddStep(std::move(matched));
    const auto unknown = SelectAmongThem();
    ASSERT_TRUE(unknown.ok());
    EXPECT_FALSE(unknown->depth_scale.has_value());
  }
}

// Features that want a focal length 5 % longer, which has one standard
// deviation, until the query has it.
class FocalGenerator final : public CandidateGenerator {
 public:
  explicit FocalGenerator(double sigma) : sigma_(sigma) {}
  absl::StatusOr<Candidate> Propose(
      Query& query, std::span<const Candidate> /*earlier*/) const override {
    const bool is_stated = query.camera().fx() < 510;
    Candidate candidate = Pose(is_stated ? 100 : 101);
    candidate.is_matched = true;
    candidate.focal =
        pose::FocalEstimate{.scale = is_stated ? 1.05 : 1, .sigma = sigma_};
    return candidate;
  }

 private:
  const double sigma_;
};

class OtherFocalAnswerTest : public testing::Test {
 protected:
  // Of the answer, if the longer one makes its confidence 0.8 the given one.
  double FocalScale(double confidence) {
    int verified = 0;
    method_.verifier = std::make_unique<FakeVerifier>(
        std::map<int, Verdict>{{100, Believed(0.8)},
                               {101, Believed(confidence)}},
        &verified, std::nullopt);
    method_.steps.clear();
    method_.steps.push_back(
        {std::make_unique<FocalGenerator>(std::log(1.05) / sigmas_)});
    camera::RgbdCalibration calibration;
    calibration.color =
        camera::Camera::Parse("PINHOLE,500,500,320,240", 640, 480).value();
    const image::Frame frame;
    const LocalizeOptions options;
    QueryScratch scratch;
    Query query(frame, calibration, method_.depth_use, options, scratch);
    if (is_doubtful_) query.set_focal_doubtful();
    query.set_focal_open(is_open_);
    Corrections corrections;
    const auto selection =
        SelectWithAnyCalibration(method_, query, corrections);
    EXPECT_TRUE(selection.ok());
    EXPECT_NEAR(corrections.focal_error_sigmas, sigmas_, 1e-9);
    return corrections.focal_scale;
  }

  Method method_;
  bool is_open_ = true;
  double sigmas_ = 7;  // by which the features want the longer one
  bool is_doubtful_ = false;
};

TEST_F(OtherFocalAnswerTest, IsTakenUnlessItIsWorse) {
  EXPECT_NEAR(FocalScale(0.7), 1.05, 1e-9);
  EXPECT_EQ(FocalScale(0.6), 1);
}

TEST_F(OtherFocalAnswerTest, HasToBeMuchBetterWhereFeaturesAreNotVerySure) {
  sigmas_ = 5;
  EXPECT_EQ(FocalScale(0.82), 1);
  EXPECT_NEAR(FocalScale(0.9), 1.05, 1e-9);  // 9 to 1, not 4 to 1
  sigmas_ = 3;
  EXPECT_EQ(FocalScale(0.9), 1);
  is_doubtful_ = true;
  EXPECT_NEAR(FocalScale(0.82), 1.05, 1e-9);
}

TEST_F(OtherFocalAnswerTest, HasToBeMuchBetterWhereTheSceneStatesTooMuch) {
  method_.focal_sigma_scale = 3;
  EXPECT_EQ(FocalScale(0.82), 1);
  EXPECT_NEAR(FocalScale(0.9), 1.05, 1e-9);
  sigmas_ = 13;
  EXPECT_NEAR(FocalScale(0.82), 1.05, 1e-9);
}

TEST_F(OtherFocalAnswerTest, MayBeALittleWorseForAGuessThatIsClearlyWrong) {
  is_doubtful_ = true;
  EXPECT_NEAR(FocalScale(0.7), 1.05, 1e-9);
  EXPECT_EQ(FocalScale(0.6), 1);
  sigmas_ = 3;
  EXPECT_EQ(FocalScale(0.7), 1);
}

TEST_F(OtherFocalAnswerTest, IsNeverTakenForOneThatIsKnown) {
  is_open_ = false;
  EXPECT_EQ(FocalScale(0.99), 1);
}

// A forest's pose that is believed, and one by features that depth refutes.
class RefutedPoseTest : public SelectCandidateTest {
 protected:
  RefutedPoseTest() {
    method_.sufficient_confidence = 0.9;
    AddStep(Pose(1));
    AddStep(Pose(2));
  }
  NotLocalizedReason ReasonBeside(double picture_confidence, geometry::Vec3 at,
                                  double turned_rad) {
    Verdict refuted;
    refuted.reason = NotLocalizedReason::kContradictsDepth;
    refuted.confidence = 0.6;
    refuted.picture_confidence = picture_confidence;
    refuted.world_from_camera = {
        geometry::Rotation3::FromAxisAngle({0, turned_rad, 0}), at};
    const auto selection = Select({{1, Believed(0.8)}, {2, refuted}});
    EXPECT_TRUE(selection.ok());
    EXPECT_EQ(selection->candidate.pose->inliers, 1);
    return selection->verdict->reason;
  }
};

TEST_F(RefutedPoseTest, SpeaksAgainstAnAnswerThatThePictureIsLessOf) {
  EXPECT_EQ(ReasonBeside(0.95, {0.1, 0, 0}, 0),
            NotLocalizedReason::kContradictsDepth);
  EXPECT_EQ(ReasonBeside(0.95, {0, 0, 0}, 0.1),
            NotLocalizedReason::kContradictsDepth);
}

TEST_F(RefutedPoseTest, IsNoMatterNearTheAnswerOrLessLikelyThanIt) {
  EXPECT_EQ(ReasonBeside(0.95, {0.04, 0, 0}, 0.05), NotLocalizedReason::kNone);
  EXPECT_EQ(ReasonBeside(0.79, {0.5, 0, 0}, 1), NotLocalizedReason::kNone);
}

TEST_F(RefutedPoseTest, OfSeveralTheLikeliestCounts) {
  AddStep(Pose(3));
  const auto refuted = [](double picture_confidence) {
    Verdict verdict;
    verdict.reason = NotLocalizedReason::kContradictsDepth;
    verdict.picture_confidence = picture_confidence;
    verdict.world_from_camera.translation = {1, 0, 0};
    return verdict;
  };
  for (const auto& [second, third] : {std::pair(0.95, 0.1), {0.1, 0.95}}) {
    const auto selection =
        Select({{1, Believed(0.8)}, {2, refuted(second)}, {3, refuted(third)}});
    ASSERT_TRUE(selection.ok());
    EXPECT_EQ(selection->verdict->reason,
              NotLocalizedReason::kContradictsDepth);
  }
}

TEST_F(SelectCandidateTest, FewFeaturesOrAVaguePoseDoNotEndTheSearch) {
  method_.sufficient_confidence = 0.9;
  AddStep(Pose(1));
  const Asked& second = AddStep(Pose(2));
  Verdict few = Believed(0.95);
  few.evidence.matches = 12;
  ASSERT_TRUE(Select({{1, few}, {2, Believed(0.93)}}).ok());
  EXPECT_EQ(second.times, 1);
  Verdict vague = Believed(0.95);
  vague.evidence.sigma_m = 0.02;
  ASSERT_TRUE(Select({{1, vague}, {2, Believed(0.93)}}).ok());
  EXPECT_EQ(second.times, 2);
  Verdict neither = Believed(0.95);
  neither.evidence.matches = 60;
  neither.evidence.sigma_m = 0.004;
  ASSERT_TRUE(Select({{1, neither}, {2, Believed(0.93)}}).ok());
  EXPECT_EQ(second.times, 2);
}

TEST_F(SelectCandidateTest, DearStepsAreAskedOnlyWhileTheVerifierIsNotContent) {
  method_.sufficient_confidence = 0.9;
  AddStep(Pose(1));
  AddStep(Pose(2));
  const Asked& dear = AddStep(Pose(3));
  const auto selection =
      Select({{1, Believed(0.6)}, {2, Believed(0.95)}, {3, Believed(0.99)}});
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.pose->inliers, 2);
  EXPECT_EQ(dear.times, 0);
  EXPECT_EQ(verified_, 2);
}

TEST_F(SelectCandidateTest, TheBestEvidenceWinsWhateverTheOrder) {
  method_.sufficient_confidence = 0.9;
  AddStep(Pose(1));
  AddStep(Pose(2));
  AddStep(Pose(3));
  const auto selection =
      Select({{1, Refused(0.8)}, {2, Believed(0.7)}, {3, Believed(0.6)}});
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.pose->inliers, 2);
  EXPECT_EQ(selection->verdict->confidence, 0.7);
  EXPECT_EQ(verified_, 3);
}

TEST_F(SelectCandidateTest, AmongEqualsTheEarlierWins) {
  method_.sufficient_confidence = 0.9;
  AddStep(Pose(1));
  AddStep(Pose(2));
  const auto selection = Select({{1, Believed(0.7)}, {2, Believed(0.7)}});
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.pose->inliers, 1);
}

TEST_F(SelectCandidateTest, AFallbackIsNotVerifiedWhereAnotherStepHasAPose) {
  AddStep(Pose(1), /*is_fallback=*/true);
  AddStep(NoPose(5));
  const Asked& third = AddStep(Pose(3));
  const auto selection = Select({{3, Believed(0.6)}});
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.pose->inliers, 3);
  // It had the fallback to start from.
  EXPECT_EQ(third.earlier, 2u);
}

TEST_F(SelectCandidateTest, AFallbackAnswersWhereNoOtherStepDoes) {
  AddStep(Pose(1), /*is_fallback=*/true);
  AddStep(NoPose(5));
  const auto selection = Select({{1, Believed(0.6)}});
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.pose->inliers, 1);
  EXPECT_TRUE(selection->verdict->is_believed());
}

TEST_F(SelectCandidateTest, WithoutAPoseTheFirstStepSaysWhy) {
  AddStep(NoPose(40), /*is_fallback=*/true);
  AddStep(NoPose(5));
  const auto selection = Select({});
  ASSERT_TRUE(selection.ok());
  EXPECT_FALSE(selection->verdict.has_value());
  EXPECT_EQ(selection->candidate.samples, 40);
  EXPECT_EQ(selection->candidate.reason, NotLocalizedReason::kTooFewInliers);
}

TEST_F(SelectCandidateTest, WhoHadNothingToLookAtDoesNotSayWhy) {
  AddStep(Candidate());  // too few samples
  AddStep(NoPose(40));
  const auto selection = Select({});
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.samples, 40);
}

// Where the poses of these tests are, and where they are not.
LocalizeOptions ExpectedAt(geometry::Vec3 position) {
  LocalizeOptions options;
  options.priors.position = geometry::PositionPrior{position, 1};
  return options;
}

TEST_F(SelectCandidateTest, AShortcutIsTakenOnlyWhereThePoseIsExpected) {
  const Asked& shortcut = AddShortcut(Pose(1));
  const Asked& second = AddStep(Pose(2));
  ASSERT_TRUE(Select({{1, Believed(0.6)}, {2, Believed(0.6)}}).ok());
  EXPECT_EQ(shortcut.times, 0);
  EXPECT_EQ(second.earlier, 0u);
  const auto selection =
      Select({{1, Believed(0.6)}, {2, Believed(0.9)}}, ExpectedAt({}));
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.pose->inliers, 1);
  EXPECT_EQ(second.times, 1);
}

TEST_F(SelectCandidateTest, AShortcutThatIsNotBelievedCostsNoAnswer) {
  AddShortcut(Pose(1));
  AddStep(Pose(2), /*is_fallback=*/true);
  const Asked& third = AddStep(Pose(3));
  const auto selection =
      Select({{1, Refused(0.4)}, {3, Believed(0.7)}}, ExpectedAt({}));
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.pose->inliers, 3);
  EXPECT_EQ(third.earlier, 2u);
}

TEST_F(SelectCandidateTest, AShortcutThatIsNotBelievedIsNoReasonAgainstOthers) {
  AddShortcut(Pose(1));
  AddStep(Pose(2), /*is_fallback=*/true);
  AddStep(NoPose(5));
  const auto selection =
      Select({{1, Refused(0.4)}, {2, Believed(0.6)}}, ExpectedAt({}));
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.pose->inliers, 2);
}

TEST_F(SelectCandidateTest, AShortcutWithoutAPoseSaysNothing) {
  AddShortcut(NoPose(3));
  const Asked& second = AddStep(NoPose(40));
  const auto selection = Select({}, ExpectedAt({}));
  ASSERT_TRUE(selection.ok());
  EXPECT_EQ(selection->candidate.samples, 40);
  EXPECT_EQ(second.earlier, 0u);
}

TEST_F(SelectCandidateTest, APoseThatContradictsAPriorDoesNotEndTheSearch) {
  AddStep(Pose(1));
  AddStep(Pose(2));
  Verdict elsewhere = Believed(0.99);
  elsewhere.world_from_camera.translation = {5, 0, 0};
  const auto found =
      Select({{1, elsewhere}, {2, Believed(0.6)}}, ExpectedAt({}));
  ASSERT_TRUE(found.ok());
  EXPECT_EQ(found->candidate.pose->inliers, 2);
  EXPECT_TRUE(found->verdict->is_believed());
  const auto lost = Select({{1, elsewhere}, {2, elsewhere}}, ExpectedAt({}));
  ASSERT_TRUE(lost.ok());
  EXPECT_EQ(lost->verdict->reason, NotLocalizedReason::kContradictsPrior);
}

TEST_F(SelectCandidateTest, ADoubtfulFocalLengthIsLookedAtWithFeatures) {
  method_.sufficient_confidence = 0.9;
  AddStep(Pose(1));
  Candidate matched = Pose(2);
  matched.is_matched = true;
  matched.focal = pose::FocalEstimate{.scale = 0.95, .sigma = 0.01};
  AddStep(matched);
  Asked& after = AddStep(Pose(3));
  is_focal_doubtful_ = true;
  const auto selection = Select({{1, Believed(0.99)}, {2, Believed(0.95)}});
  ASSERT_TRUE(selection.ok()) << selection.status();
  EXPECT_EQ(selection->candidate.pose->inliers, 1);
  ASSERT_TRUE(selection->focal.features.has_value());
  EXPECT_EQ(selection->focal.features->scale, 0.95);
  EXPECT_EQ(after.times, 0);
}

TEST_F(SelectCandidateTest, OneThatMeasuredPointsDoubtIsLookedAtWithFeatures) {
  method_.sufficient_confidence = 0.9;
  Candidate measured = Pose(1);
  for (const auto& [scale, asked] : {std::pair{1.03, 0}, {1.06, 1}}) {
    method_.steps.clear();
    measured.focal = pose::FocalEstimate{.scale = scale, .sigma = 0.015};
    AddStep(measured);
    Candidate matched = Pose(200);
    matched.is_matched = true;
    matched.focal = pose::FocalEstimate{.scale = 1, .sigma = 0.01};
    const Asked& features = AddStep(matched);
    const Asked& after = AddStep(Pose(3));
    const auto selection = Select({{1, Believed(0.99)}, {200, Believed(0.95)}});
    ASSERT_TRUE(selection.ok()) << selection.status();
    EXPECT_EQ(selection->candidate.pose->inliers, 1);
    EXPECT_EQ(features.times, asked) << scale;
    EXPECT_EQ(after.times, 0);
    ASSERT_TRUE(selection->focal.points.has_value());
    EXPECT_EQ(selection->focal.points->scale, scale);
    EXPECT_EQ(selection->focal.features.has_value(), asked == 1);
  }
}

TEST_F(SelectCandidateTest, AnErrorOfAGeneratorIsTheQuerys) {
  AddStep(absl::InternalError("the library failed"));
  EXPECT_EQ(Select({}).status(), absl::InternalError("the library failed"));
}

TEST_F(SelectCandidateTest, AsksNothingMoreAfterAStop) {
  const Asked& first = AddStep(Pose(1));
  std::stop_source stop;
  stop.request_stop();
  const auto selection = Select({{1, Believed(1)}}, {.stop = stop.get_token()});
  EXPECT_EQ(selection.status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(first.times, 0);
}

}  // namespace
}  // namespace treeline::localizer
