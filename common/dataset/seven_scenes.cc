#include "common/dataset/seven_scenes.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/dataset/dataset_index.h"

namespace treeline::dataset {
namespace {

namespace fs = std::filesystem;

constexpr const char* kColorEndings[] = {".color.png", ".color.jpg"};

bool IsFile(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

// The names in `folder`, sorted. A folder that cannot be read has none.
std::vector<std::string> SortedNames(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    names.push_back(entry->path().filename().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

std::vector<ListedStem> ScanStems(const std::string& folder) {
  std::vector<ListedStem> stems;
  for (const std::string& sequence : SortedNames(folder)) {
    if (!absl::StartsWith(sequence, "seq-")) continue;
    std::string last;
    for (const std::string& name :
         SortedNames(absl::StrCat(folder, "/", sequence))) {
      absl::string_view stem = name;
      if (!absl::StartsWith(stem, "frame-") ||
          !(absl::ConsumeSuffix(&stem, kColorEndings[0]) ||
            absl::ConsumeSuffix(&stem, kColorEndings[1])) ||
          stem == last) {
        continue;
      }
      last = std::string(stem);
      stems.push_back({absl::StrCat(sequence, "/", last), 0});
    }
  }
  return stems;
}

absl::StatusOr<DatasetFrame> IndexFrame(const IndexRequest& request,
                                        const ListedStem& listed) {
  const std::string base = absl::StrCat(request.folder, "/", listed.stem);
  DatasetFrame frame;
  frame.stem = listed.stem;
  for (const char* ending : kColorEndings) {
    if (frame.color_path.empty() && IsFile(base + ending)) {
      frame.color_path = base + ending;
    }
  }
  if (frame.color_path.empty()) {
    return StemNotFound(
        request, listed,
        absl::StrCat(base, kColorEndings[0], " nor ", kColorEndings[1]));
  }
  if (IsFile(base + ".depth.png")) frame.depth_path = base + ".depth.png";
  const std::string pose_path = base + ".pose.txt";
  if (request.read_poses && IsFile(pose_path)) {
    TL_ASSIGN_OR_RETURN(const std::string text,
                        base::ReadFile(pose_path, 1 << 16));
    TL_ASSIGN_OR_RETURN(frame.world_from_camera,
                        ParsePoseMatrix(text, pose_path));
  }
  return frame;
}

}  // namespace

absl::StatusOr<DatasetIndex> IndexSevenScenes(const IndexRequest& request) {
  DatasetIndex index;
  // The usual values for the Kinect of 7-Scenes; its authors gave only the
  // depth camera's.
  index.color_camera = "PINHOLE,525,525,320,240";
  index.depth_camera = "PINHOLE,585,585,320,240";
  index.depth_unit_m = 0.001;
  index.pose_sensor = camera::RgbdSensor::kDepth;
  const std::vector<ListedStem> stems =
      request.stems.empty() ? ScanStems(request.folder) : request.stems;
  if (stems.empty()) {
    return absl::NotFoundError(
        absl::StrCat(request.folder,
                     ": no frames in seq-*/frame-*.color.png (or .jpg); "
                     "is this the folder that holds the folders seq-01, ...?"));
  }
  index.frames.reserve(stems.size());
  for (const ListedStem& listed : stems) {
    TL_ASSIGN_OR_RETURN(DatasetFrame frame, IndexFrame(request, listed));
    index.frames.push_back(std::move(frame));
  }
  return index;
}

}  // namespace treeline::dataset
