#include "server/service/scene_maps.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <exception>
#include <utility>

#include "absl/cleanup/cleanup.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/status_macros.h"
#include "common/wire/camera.h"
#include "common/wire/geometry.h"
#include "server/core/keyframes/coverage.h"
#include "server/core/keyframes/keyframe_map.h"
#include "server/core/keyframes/scene_axes.h"

namespace treeline::service {
namespace {

constexpr int kDefaultPoints = 50000;
constexpr int kMaxPoints = 200000;
constexpr std::chrono::milliseconds kCoveragePause{1000};

static_assert(std::endian::native == std::endian::little,
              "points are sent as they lie in memory");

absl::Status Check(const v1::GetSceneMapRequest& request) {
  if (request.max_points() >= 0 && request.max_points() <= kMaxPoints) {
    return absl::OkStatus();
  }
  return wire::FieldError(
      "max_points",
      absl::StrCat(request.max_points(), " is not 0..", kMaxPoints));
}

void AddPoints(const keyframes::KeyframeMap& map, size_t most,
               v1::GetSceneMapResponse& response) {
  size_t total = 0;
  for (size_t i = 0; i < map.size(); ++i) total += map.points(i).size();
  response.set_points_in_model(static_cast<int64_t>(total));
  const size_t stride = std::max<size_t>(1, (total + most - 1) / most);
  std::string& positions = *response.mutable_points_in_world_m();
  std::string& brightness = *response.mutable_brightness();
  positions.reserve((total / stride + 1) * 3 * sizeof(float));
  size_t next = 0;
  for (size_t i = 0; i < map.size(); ++i) {
    const auto points = map.points(i);
    for (; next < points.size(); next += stride) {
      const keyframes::KeyframePoint& point = points[next];
      positions.append(
          reinterpret_cast<const char*>(point.position_in_world.data()),
          sizeof(point.position_in_world));
      brightness.push_back(static_cast<char>(point.gray[0]));
    }
    next -= points.size();
  }
}

v1::SceneCoverage ToProto(const keyframes::CoverageMap& map) {
  v1::SceneCoverage coverage;
  coverage.set_min_x_m(map.min_x_m);
  coverage.set_min_y_m(map.min_y_m);
  coverage.set_cell_m(map.cell_m);
  coverage.set_columns(map.columns);
  coverage.set_rows(map.rows);
  coverage.set_headings(map.headings);
  coverage.set_height_m(map.height_m);
  coverage.set_ground_m(map.ground_m);
  for (const keyframes::CoveragePlace& place : map.places) {
    coverage.mutable_is_open()->push_back(place.is_open ? 1 : 0);
    coverage.mutable_good_headings()->push_back(
        static_cast<char>(std::popcount(place.good)));
    coverage.mutable_weak_headings()->push_back(
        static_cast<char>(std::popcount(place.weak)));
  }
  const keyframes::CoverageSummary summary = keyframes::Summarize(map);
  coverage.set_open_m2(summary.open_m2);
  coverage.set_good_share(summary.good_share);
  coverage.set_weak_share(summary.weak_share);
  return coverage;
}

}  // namespace

void SceneMaps::Start(Call call) {
  if (const absl::Status valid = Check(call.request); !valid.ok()) {
    call.done(valid);
    return;
  }
  if (!waiting_for_scene_.Enter()) {
    call.done(QueueIsFull());
    return;
  }
  const auto shared = std::make_shared<Call>(std::move(call));
  repository_.AcquireAsync(
      shared->request.scene(), "",
      [this,
       shared](absl::StatusOr<std::shared_ptr<const repository::Scene>> scene) {
        waiting_for_scene_.Leave();
        if (scene.ok()) {
          Enqueue(shared, *std::move(scene));
        } else {
          shared->done(scene.status());
        }
      });
}

// On a worker, in the client's turn: coverage takes its time.
void SceneMaps::Enqueue(const std::shared_ptr<Call>& call,
                        std::shared_ptr<const repository::Scene> scene) {
  WorkerPool::Task task;
  task.client = call->client;
  task.kind = "GetSceneMap";
  task.deadline = call->deadline;
  task.run = [this, call, scene = std::move(scene)] {
    if (clock_.Now() >= call->deadline) {
      call->done(absl::DeadlineExceededError("the deadline passed"));
    } else if (call->stop.stop_requested()) {
      call->done(absl::CancelledError("the call was cancelled"));
    } else {
      call->done(MakeOrFault(*call, *scene));
    }
  };
  task.give_way = [call] { call->done(QueueIsFull()); };
  const WorkerPool::Admission admission = workers_.Submit(std::move(task));
  if (admission.verdict != WorkerPool::Verdict::kAccepted) {
    call->done(QueueIsFull(admission.retry_after));
  }
}

// What is thrown must not end the server: whole points may not fit in memory.
absl::StatusOr<v1::GetSceneMapResponse> SceneMaps::MakeOrFault(
    const Call& call, const repository::Scene& scene) {
  try {
    return Make(call.request, scene);
  } catch (const std::exception& error) {
    call.on_fault(error.what());
  } catch (...) {
    call.on_fault("an exception of unknown type");
  }
  return InternalFault();
}

absl::StatusOr<v1::GetSceneMapResponse> SceneMaps::Make(
    const v1::GetSceneMapRequest& request, const repository::Scene& scene) {
  const keyframes::KeyframeMap* const map = scene.localizer->keyframes();
  if (map == nullptr || map->empty()) {
    return base::WithReason(
        absl::FailedPreconditionError(absl::StrCat(
            "the model of scene '", scene.name,
            "' has no keyframes; train it with method universal from a "
            "recording that has depth")),
        "NO_KEYFRAMES");
  }
  v1::GetSceneMapResponse response;
  response.set_scene(scene.name);
  response.set_model_version(scene.version);
  const int most =
      request.max_points() > 0 ? request.max_points() : kDefaultPoints;
  AddPoints(*map, static_cast<size_t>(most), response);
  for (size_t i = 0; i < map->size(); ++i) {
    *response.add_world_from_keyframe() =
        wire::ToProto(map->world_from_camera(i));
  }
  *response.mutable_camera() =
      wire::ToProto(repository::QueryCalibration(scene).color);
  *response.mutable_plan_from_world() =
      wire::ToProto(keyframes::PlanFromWorld(*map));
  if (request.include_coverage()) {
    TL_ASSIGN_OR_RETURN(const std::shared_ptr<const v1::SceneCoverage> coverage,
                        CoverageOf(scene));
    *response.mutable_coverage() = *coverage;
  }
  return response;
}

absl::StatusOr<std::shared_ptr<const v1::SceneCoverage>> SceneMaps::CoverageOf(
    const repository::Scene& scene) {
  {
    const absl::MutexLock lock(&mutex_);
    Kept& kept = kept_[scene.name];
    if (kept.localizer.lock() == scene.localizer) {
      if (kept.coverage != nullptr) return kept.coverage;
      return base::WithRetryAfter(
          base::WithReason(absl::UnavailableError(
                               absl::StrCat("the coverage of scene '",
                                            scene.name, "' is being computed")),
                           "COVERAGE_NOT_READY"),
          kCoveragePause);
    }
    kept = {.localizer = scene.localizer, .coverage = nullptr};
  }
  keyframes::CoverageOptions options;
  options.threads = 1;
  const absl::Cleanup forget = [&] { ForgetUnlessKept(scene); };
  TL_ASSIGN_OR_RETURN(const keyframes::CoverageMap map,
                      keyframes::PredictCoverage(
                          *scene.localizer->keyframes(),
                          repository::QueryCalibration(scene).color, options));
  auto coverage = std::make_shared<const v1::SceneCoverage>(ToProto(map));
  const absl::MutexLock lock(&mutex_);
  const auto kept = kept_.find(scene.name);
  if (kept != kept_.end() && kept->second.localizer.lock() == scene.localizer) {
    kept->second.coverage = coverage;
  }
  return coverage;
}

void SceneMaps::ForgetUnlessKept(const repository::Scene& scene) {
  const absl::MutexLock lock(&mutex_);
  const auto kept = kept_.find(scene.name);
  if (kept != kept_.end() && kept->second.coverage == nullptr &&
      kept->second.localizer.lock() == scene.localizer) {
    kept_.erase(kept);
  }
}

}  // namespace treeline::service
