// The corrector does what client/fusion_vectors say.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/fusion/drift_corrector.h"
#include "client/fusion/drift_options_fields.h"
#include "gtest/gtest.h"
#include "nlohmann/json.hpp"

namespace treeline::drift {
namespace {

using Json = nlohmann::json;
using std::chrono::nanoseconds;

// Of docs/explanation/device-fusion.md.
constexpr double kTolerance = 1e-6;

nanoseconds TimeOf(const Json& time_ms) {
  return nanoseconds(std::llround(1e6 * time_ms.get<double>()));
}

geometry::Rigid3 PoseOf(const Json& numbers) {
  return {Normalized(geometry::Rotation3{numbers.at(0), numbers.at(1),
                                         numbers.at(2), numbers.at(3)}),
          {numbers.at(4), numbers.at(5), numbers.at(6)}};
}

Fix FixOf(const Json& event) {
  return {.capture_time = TimeOf(event.at("capture_time_ms")),
          .world_from_camera = PoseOf(event.at("world_from_camera")),
          .covariance = event.at("covariance").get<geometry::PoseCovariance>(),
          .confidence = event.at("confidence")};
}

void ExpectNear(const std::optional<double>& actual, const Json& expected) {
  ASSERT_EQ(actual.has_value(), !expected.is_null());
  if (actual.has_value()) {
    EXPECT_NEAR(*actual, expected.get<double>(), kTolerance);
  }
}

void ExpectNear(const std::optional<geometry::Rigid3>& actual,
                const Json& expected) {
  ASSERT_EQ(actual.has_value(), !expected.is_null());
  if (!actual.has_value()) return;
  const auto& [q, t] = *actual;
  const double numbers[] = {q.w, q.x, q.y, q.z, t.x, t.y, t.z};
  ASSERT_EQ(expected.size(), std::size(numbers));
  for (size_t i = 0; i < std::size(numbers); ++i) {
    EXPECT_NEAR(numbers[i], expected[i].get<double>(), kTolerance) << i;
  }
}

void ExpectEstimate(const DriftEstimate& actual, const Json& expected) {
  EXPECT_EQ(expected.size(), 8u) << "there is something new in the vectors";
  EXPECT_EQ(NameOf(actual.state), expected.at("state").get<std::string>());
  ExpectNear(actual.world_from_device, expected.at("world_from_device"));
  ExpectNear(actual.position_sigma_m, expected.at("position_sigma_m"));
  ExpectNear(actual.rotation_sigma_deg, expected.at("rotation_sigma_deg"));
  ExpectNear(actual.since_good_fix_s, expected.at("since_good_fix_s"));
  EXPECT_EQ(actual.contradicting_views, expected.at("contradicting_views"));
  EXPECT_EQ(actual.snapped, expected.at("snapped"));
  EXPECT_EQ(actual.tracking_broke, expected.at("tracking_broke"));
}

// The claims are of the truth, not of the algorithm. Returns how many were put
// to the test.
int ExpectClaims(const DriftEstimate& estimate, const Json& claims,
                 const Json& event) {
  if (estimate.state != DriftState::kLocked) return 0;
  const double error_m =
      Norm(estimate.world_from_camera->translation -
           PoseOf(event.at("true_world_from_camera")).translation);
  int claimed = 0;
  for (const Json& claim : claims) {
    if (event.at("time_ms") < claim.at("from_ms") ||
        event.at("time_ms") > claim.at("to_ms")) {
      continue;
    }
    ++claimed;
    EXPECT_LE(error_m, claim.at("max_error_m").get<double>());
  }
  return claimed;
}

DriftOptions OptionsOf(const Json& parameters) {
  DriftOptions options;
  size_t fields = 0;
  ForEachField(options, [&](const char* name, auto& field) {
    parameters.at(name).get_to(field);
    ++fields;
  });
  EXPECT_EQ(fields, parameters.size());
  return options;
}

Json ReadVectors(const std::filesystem::path& path) {
  std::ifstream file(path);
  return Json::parse(file);
}

std::vector<std::filesystem::path> VectorFiles() {
  std::vector<std::filesystem::path> files;
  for (const auto& entry :
       std::filesystem::directory_iterator(TREELINE_FUSION_VECTORS)) {
    if (entry.path().extension() == ".json") files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

class VectorsTest : public testing::TestWithParam<std::filesystem::path> {};

TEST_P(VectorsTest, TheSameStatesAndNearTheTruth) {
  const Json vectors = ReadVectors(GetParam());
  absl::StatusOr<DriftCorrector> corrector =
      DriftCorrector::Create(OptionsOf(vectors.at("parameters")));
  ASSERT_TRUE(corrector.ok()) << corrector.status();
  int claimed = 0;
  int number = 0;
  for (const Json& event : vectors.at("events")) {
    SCOPED_TRACE(absl::StrCat("event ", number++));
    const std::string kind = event.at("kind");
    const Json& expected = event.at("expect");
    if (kind == "track") {
      const absl::StatusOr<DriftEstimate> estimate = corrector->Track(
          TimeOf(event.at("time_ms")), PoseOf(event.at("device_from_camera")));
      ASSERT_TRUE(estimate.ok()) << estimate.status();
      ExpectEstimate(*estimate, expected);
      claimed += ExpectClaims(*estimate, vectors.at("claims"), event);
    } else if (kind == "fix") {
      const absl::StatusOr<FixVerdict> verdict =
          corrector->AddFix(FixOf(event));
      ASSERT_TRUE(verdict.ok()) << verdict.status();
      EXPECT_EQ(NameOf(*verdict), expected.at("verdict").get<std::string>());
    } else {
      ASSERT_EQ(kind, "reset");
      corrector->Reset();
    }
    EXPECT_EQ(NameOf(corrector->state()),
              expected.at("state").get<std::string>());
  }
  EXPECT_GT(claimed, 10);
}

INSTANTIATE_TEST_SUITE_P(All, VectorsTest, testing::ValuesIn(VectorFiles()),
                         [](const auto& file) {
                           return file.param.stem().string();
                         });

TEST(VectorFilesTest, AreAllThere) { EXPECT_GE(VectorFiles().size(), 13u); }

TEST(VectorFilesTest, HaveTheDefaultsOfTheOptions) {
  // A walk for which nothing was changed.
  const DriftOptions written =
      OptionsOf(ReadVectors(std::filesystem::path(TREELINE_FUSION_VECTORS) /
                            "clean_walk.json")
                    .at("parameters"));
  std::vector<double> expected;
  ForEachField(written,
               [&](const char*, auto value) { expected.push_back(value); });
  size_t i = 0;
  const DriftOptions defaults;
  ForEachField(defaults, [&](const char* name, auto value) {
    EXPECT_EQ(value, expected[i++]) << name;
  });
}

}  // namespace
}  // namespace treeline::drift
