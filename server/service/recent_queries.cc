#include "server/service/recent_queries.h"

#include <utility>

#include "absl/strings/strip.h"
#include "absl/time/time.h"
#include "common/base/error_info.h"
#include "common/wire/geometry.h"
#include "server/service/call.h"
#include "server/service/convert.h"

namespace treeline::service {
namespace {

bool IsQuery(absl::string_view rpc) {
  return rpc == "Localize" || rpc == "LocalizeStream";
}

std::string ReasonOf(const CallRecord& record) {
  if (!record.status.ok()) return base::ErrorInfoOf(record.status).reason;
  if (record.outcome == localizer::Outcome::kLocalized) return "";
  return std::string(localizer::ReasonName(record.reason));
}

}  // namespace

void RecentQueries::OnCall(const CallRecord& record) {
  // Only with a version the scene is one of ours.
  if (!IsQuery(record.rpc) || record.model_version.empty()) return;
  Entry entry;
  entry.scene = record.scene;
  entry.query.set_time_utc(absl::FormatTime("%Y-%m-%dT%H:%M:%E3SZ",
                                            absl::FromChrono(wall_clock_()),
                                            absl::UTCTimeZone()));
  if (record.world_from_camera.has_value()) {
    *entry.query.mutable_world_from_camera() =
        wire::ToProto(*record.world_from_camera);
  }
  entry.query.set_reason(ReasonOf(record));
  entry.query.set_is_error(!record.status.ok());
  entry.query.set_confidence(record.confidence);
  entry.query.set_inliers(record.inliers);
  entry.query.set_samples(record.samples);
  entry.query.set_total_ms(record.timings.total_ms);
  const absl::MutexLock lock(&mutex_);
  entries_.push_front(std::move(entry));
  if (entries_.size() > capacity_) entries_.pop_back();
}

v1::ListRecentQueriesResponse RecentQueries::Of(absl::string_view scene) const {
  v1::ListRecentQueriesResponse response;
  const absl::MutexLock lock(&mutex_);
  for (const Entry& entry : entries_) {
    if (entry.scene == scene) *response.add_queries() = entry.query;
  }
  return response;
}

}  // namespace treeline::service
