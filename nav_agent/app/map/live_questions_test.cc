#include "nav_agent/app/map/live_questions.h"

#include <memory>
#include <utility>
#include <vector>

#include "gtest/gtest.h"

namespace treeline::map_app {
namespace {

using behavior::FixVerdict;

core::RelocalizationAnswer Seen(double confidence) {
  core::RelocalizationAnswer answer;
  answer.localized = true;
  answer.confidence = confidence;
  return answer;
}

geometry::Rigid3 At(double x, double y, double z) {
  return {.rotation = {}, .translation = {x, y, z}};
}

FixVerdict Verdict(const core::RelocalizationAnswer& answer,
                   const geometry::Rigid3& map_from_base,
                   const geometry::Rotation3& level_from_base = {}) {
  // Along the ground floor, and on the storey above it.
  std::vector<dataset::TimedPose> driven;
  for (int i = 0; i < 10; ++i) {
    driven.push_back({.time = i, .world_from_camera = At(i, 0, 0)});
    driven.push_back({.time = i + 10, .world_from_camera = At(i, 0, 3.2)});
  }
  return JudgeWhileMapping(answer, map_from_base, level_from_base, driven, {})
      .verdict;
}

TEST(JudgeWhileMapping, LetsThroughToTheScansWhatCanBe) {
  EXPECT_EQ(Verdict(Seen(0.9), At(3.5, 1, 0.02)), FixVerdict::kWeak);
  EXPECT_EQ(Verdict(Seen(0.9), At(3.5, 1, 3.22)), FixVerdict::kWeak);
}

TEST(JudgeWhileMapping, RefusesWhatCannot) {
  EXPECT_EQ(Verdict({}, At(3, 0, 0)), FixVerdict::kNotLocalized);
  EXPECT_EQ(Verdict(Seen(0.1), At(3, 0, 0)), FixVerdict::kLowConfidence);
  // Between the storeys, and where nobody has been.
  EXPECT_EQ(Verdict(Seen(0.9), At(3, 0, 1.4)), FixVerdict::kNotOnGround);
  EXPECT_EQ(Verdict(Seen(0.9), At(3, 5, 0)), FixVerdict::kNotOnGround);
  EXPECT_EQ(Verdict(Seen(0.9), At(3, 0, 0),
                    geometry::Rotation3::FromAxisAngle({0.2, 0, 0})),
            FixVerdict::kAgainstGravity);
}

// Counts what it is asked.
class CountingServer final : public core::RelocalizationPort {
 public:
  void Ask(const core::RgbdFrame& /*frame*/, double /*timeout_s*/) override {
    ++asked;
  }
  std::optional<absl::StatusOr<core::RelocalizationAnswer>> TakeAnswer()
      override {
    return std::exchange(answer, std::nullopt);
  }
  bool IsAsking() const override { return false; }
  void Cancel() override {}

  int asked = 0;
  std::optional<absl::StatusOr<core::RelocalizationAnswer>> answer;
};

TEST(LiveQuestions, ARobotThatKnowsItsPlaceAsksNobodyAndBelievesNobody) {
  CountingServer server;
  LiveQuestions questions(server, {});
  const auto mapper = mapping::OnlineMapper::Create(
      {.beams = 181, .range_max_m = 30}, core::RobotModel(), {});
  ASSERT_TRUE(mapper.ok()) << mapper.status();
  questions.Add({}, **mapper);
  EXPECT_EQ(server.asked, 0);
  server.answer = Seen(0.99);
  EXPECT_FALSE(questions.Step(**mapper, {}).has_value());
  EXPECT_EQ(questions.status().suggested, 0);
}

}  // namespace
}  // namespace treeline::map_app
