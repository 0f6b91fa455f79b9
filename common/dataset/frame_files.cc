#include "common/dataset/frame_files.h"

#include <algorithm>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"

namespace treeline::dataset {
namespace {

constexpr uint64_t kMaxPoseBytes = 1u << 16;

}  // namespace

std::vector<std::string> FrameNamesIn(const std::string& folder,
                                      const FrameFileFormat& format) {
  std::vector<std::string> names;
  for (const std::string& file : base::SortedNamesIn(folder)) {
    absl::string_view name = file;
    if (absl::StartsWith(name, "frame-") &&
        (absl::ConsumeSuffix(&name, format.color_endings[0]) ||
         absl::ConsumeSuffix(&name, format.color_endings[1]))) {
      names.emplace_back(name);
    }
  }
  std::ranges::sort(names);
  names.erase(std::unique(names.begin(), names.end()), names.end());
  return names;
}

absl::StatusOr<DatasetFrame> IndexFrameFiles(const IndexRequest& request,
                                             const std::string& folder,
                                             const FrameFileFormat& format,
                                             const ListedStem& listed) {
  const std::string base = absl::StrCat(folder, "/", listed.stem);
  DatasetFrame frame;
  frame.stem = listed.stem;
  for (const char* ending : format.color_endings) {
    if (frame.color_path.empty() && base::IsFile(base + ending)) {
      frame.color_path = base + ending;
    }
  }
  if (frame.color_path.empty()) {
    return StemNotFound(request, listed,
                        absl::StrCat(base, format.color_endings[0], " nor ",
                                     format.color_endings[1]));
  }
  const std::string depth_path = base + ".depth.png";
  if (base::IsFile(depth_path)) frame.depth_path = depth_path;
  const std::string pose_path = base + ".pose.txt";
  if (!request.read_poses || !base::IsFile(pose_path)) return frame;
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(pose_path, kMaxPoseBytes));
  if (format.infinite_pose_is_none && absl::StrContains(text, "inf")) {
    return frame;
  }
  TL_ASSIGN_OR_RETURN(frame.world_from_camera,
                      ParsePoseMatrix(text, pose_path));
  return frame;
}

}  // namespace treeline::dataset
