#include "server/service/recent_queries.h"

#include <chrono>
#include <string>

#include "common/base/error_info.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/service/call.h"

namespace treeline::service {
namespace {

CallRecord Localized(const std::string& scene, int inliers) {
  CallRecord record;
  record.rpc = "Localize";
  record.client = "somebody";
  record.peer = "ipv4:10.0.0.7:1";
  record.scene = scene;
  record.model_version = "1";
  record.outcome = localizer::Outcome::kLocalized;
  record.world_from_camera = geometry::Rigid3{{}, {1, 2, 3}};
  record.inliers = inliers;
  record.samples = 500;
  record.confidence = 0.75;
  record.timings.total_ms = 12;
  return record;
}

class RecentQueriesTest : public ::testing::Test {
 protected:
  RecentQueries queries_{3, [this] { return now_ += std::chrono::seconds(1); }};
  std::chrono::system_clock::time_point now_{
      std::chrono::milliseconds(1'763'717'399'250)};
};

TEST_F(RecentQueriesTest, TellsWhereAndWhen) {
  queries_.OnCall(Localized("hall", 40));
  const v1::ListRecentQueriesResponse response = queries_.Of("hall");
  ASSERT_EQ(response.queries_size(), 1);
  const v1::RecentQuery& query = response.queries(0);
  EXPECT_EQ(query.time_utc(), "2025-11-21T09:30:00.250Z");
  EXPECT_EQ(query.world_from_camera().translation_m().z(), 3);
  EXPECT_EQ(query.reason(), "");
  EXPECT_FALSE(query.is_error());
  EXPECT_EQ(query.inliers(), 40);
  EXPECT_EQ(query.samples(), 500);
  EXPECT_EQ(query.confidence(), 0.75);
  EXPECT_EQ(query.total_ms(), 12);
  // Nothing of who asked.
  EXPECT_EQ(response.SerializeAsString().find("somebody"), std::string::npos);
  EXPECT_EQ(response.SerializeAsString().find("10.0.0.7"), std::string::npos);
}

TEST_F(RecentQueriesTest, TellsWhyNot) {
  CallRecord record = Localized("hall", 4);
  record.rpc = "LocalizeStream";
  record.outcome = localizer::Outcome::kNotLocalized;
  record.reason = localizer::NotLocalizedReason::kTooFewInliers;
  record.world_from_camera.reset();
  queries_.OnCall(record);
  record.outcome.reset();
  record.status = base::WithReason(absl::InvalidArgumentError("no picture"),
                                   "INVALID_REQUEST");
  queries_.OnCall(record);
  const v1::ListRecentQueriesResponse response = queries_.Of("hall");
  ASSERT_EQ(response.queries_size(), 2);
  EXPECT_EQ(response.queries(0).reason(), "INVALID_REQUEST");
  EXPECT_TRUE(response.queries(0).is_error());
  EXPECT_EQ(response.queries(1).reason(), "TOO_FEW_INLIERS");
  EXPECT_FALSE(response.queries(1).is_error());
  EXPECT_FALSE(response.queries(1).has_world_from_camera());
}

TEST_F(RecentQueriesTest, KeepsTheNewest) {
  for (int i = 0; i < 5; ++i) queries_.OnCall(Localized("hall", i));
  queries_.OnCall(Localized("attic", 9));
  const v1::ListRecentQueriesResponse response = queries_.Of("hall");
  ASSERT_EQ(response.queries_size(), 2);
  EXPECT_EQ(response.queries(0).inliers(), 4);
  EXPECT_EQ(response.queries(1).inliers(), 3);
  EXPECT_EQ(queries_.Of("attic").queries_size(), 1);
  EXPECT_EQ(queries_.Of("cellar").queries_size(), 0);
}

TEST_F(RecentQueriesTest, KeepsNothingElse) {
  CallRecord record = Localized("hall", 1);
  // What promises that nothing is kept of it.
  record.rpc = kGeoPoseRpc;
  queries_.OnCall(record);
  record.rpc = "GetScene";
  queries_.OnCall(record);
  // A name that may be anything.
  record = Localized("hall", 1);
  record.model_version = "";
  queries_.OnCall(record);
  EXPECT_EQ(queries_.Of("hall").queries_size(), 0);
}

}  // namespace
}  // namespace treeline::service
