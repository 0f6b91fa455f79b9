#include "server/service/scene_health.h"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::service {
namespace {

constexpr auto kPeriod = std::chrono::milliseconds(500);

}  // namespace

SceneHealth::SceneHealth(const repository::SceneRepository& repository,
                         HealthGrpcService& health)
    : repository_(repository), health_(health) {
  Update();
  thread_ = std::jthread([this](const std::stop_token& stop) {
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    while (!never.wait_for(lock, stop, kPeriod,
                           [&] { return stop.stop_requested(); })) {
      Update();
    }
  });
}

void SceneHealth::Update() {
  std::map<std::string, bool> now;
  for (const repository::SceneStatus& scene : repository_.List()) {
    now[scene.name] = scene.state != repository::SceneState::kFailed;
  }
  for (const auto& [scene, serving] : now) {
    const auto told = told_.find(scene);
    if (told != told_.end() && told->second == serving) continue;
    health_.Set(HealthServiceOf(scene), serving);
  }
  for (const auto& [scene, serving] : told_) {
    if (serving && now.count(scene) == 0) {
      health_.Set(HealthServiceOf(scene), false);
    }
  }
  told_ = std::move(now);
}

std::string HealthServiceOf(const std::string& scene) {
  return absl::StrCat("treeline.scene.", scene);
}

}  // namespace treeline::service
