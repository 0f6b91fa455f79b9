#include "server/service/scene_recognizer.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <stop_token>
#include <utility>

namespace treeline::service {
namespace {

constexpr auto kPeriod = std::chrono::seconds(1);

}  // namespace

SceneRecognizer::SceneRecognizer(const repository::SceneRepository& repository,
                                 DescriptorReader read)
    : repository_(repository), read_(std::move(read)) {
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

void SceneRecognizer::Update() {
  std::set<std::string> there;
  for (const repository::ModelRef& model : repository_.Models()) {
    there.insert(model.scene);
    const auto known = known_.find(model.scene);
    if (known != known_.end() && known->second == model.fingerprint) continue;
    const auto path = repository_.LocalPath(model);
    // Not fetched yet: it may be by the next time.
    if (!path.ok()) continue;
    const auto descriptor = read_(*path);
    if (descriptor.ok()) {
      index_.Set(model.scene, *descriptor);
    } else {
      index_.Remove(model.scene);
    }
    known_[model.scene] = model.fingerprint;
  }
  for (auto known = known_.begin(); known != known_.end();) {
    if (there.count(known->first) > 0) {
      ++known;
      continue;
    }
    index_.Remove(known->first);
    known = known_.erase(known);
  }
}

std::vector<recognition::SceneScore> SceneRecognizer::Rank(
    const image::Frame& frame, std::span<const std::string> candidates) const {
  if (candidates.empty()) return index_.Rank(frame);
  std::vector<recognition::SceneScore> ranking = index_.Rank(frame, candidates);
  for (const std::string& candidate : candidates) {
    const bool ranked = std::any_of(ranking.begin(), ranking.end(),
                                    [&](const recognition::SceneScore& score) {
                                      return score.scene == candidate;
                                    });
    if (!ranked) ranking.push_back({candidate, 0});
  }
  return ranking;
}

}  // namespace treeline::service
