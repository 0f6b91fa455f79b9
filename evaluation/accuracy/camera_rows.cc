#include "evaluation/accuracy/camera_rows.h"

#include <algorithm>
#include <map>
#include <utility>

namespace treeline::accuracy {

std::vector<CameraRow> CameraRows(const EvaluatedMethod& method,
                                  double confidence_threshold) {
  std::map<std::string, std::vector<FrameResult>> by_camera;
  for (const FrameResult& result : method.results) {
    by_camera[result.camera].push_back(result);
  }
  if (by_camera.size() < 2) return {};
  std::vector<std::pair<std::string, std::vector<FrameResult>>> groups(
      by_camera.begin(), by_camera.end());
  std::ranges::stable_sort(groups, [](const auto& a, const auto& b) {
    return a.second.size() > b.second.size();
  });
  while (groups.size() > kMaxCameraRows) {
    std::vector<FrameResult> last = std::move(groups.back().second);
    groups.pop_back();
    auto& [name, results] = groups.back();
    name = kOtherCameras;
    results.insert(results.end(), last.begin(), last.end());
  }
  const PoseThreshold right_within =
      RightWithin(method.results, method.model.units_are_metres);
  std::vector<CameraRow> rows;
  for (const auto& [name, results] : groups) {
    rows.push_back(
        {name, CountAnswers(results, right_within, confidence_threshold)});
  }
  return rows;
}

}  // namespace treeline::accuracy
