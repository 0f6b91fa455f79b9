#include "common/dataset/seven_scenes.h"

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/dataset_cameras.h"
#include "common/dataset/frame_files.h"

namespace treeline::dataset {
namespace {

constexpr FrameFileFormat kFiles = {
    .color_endings = {".color.png", ".color.jpg"}};

std::vector<ListedStem> ScanStems(const std::string& folder) {
  std::vector<ListedStem> stems;
  for (const std::string& sequence : base::SortedNamesIn(folder)) {
    if (!absl::StartsWith(sequence, "seq-")) continue;
    for (const std::string& name :
         FrameNamesIn(absl::StrCat(folder, "/", sequence), kFiles)) {
      stems.push_back({absl::StrCat(sequence, "/", name), 0});
    }
  }
  return stems;
}

}  // namespace

absl::StatusOr<DatasetIndex> IndexSevenScenes(const IndexRequest& request) {
  DatasetIndex index;
  // The usual values for the Kinect of 7-Scenes; its authors gave only the
  // depth camera's.
  index.cameras = DefaultCameras{.color = "PINHOLE,525,525,320,240",
                                 .depth = "PINHOLE,585,585,320,240",
                                 .pose_sensor = camera::RgbdSensor::kDepth};
  TL_RETURN_IF_ERROR(ReadCamerasFile(request.path, index));
  index.depth_unit_m = 0.001;
  const std::vector<ListedStem> stems =
      request.stems.empty() ? ScanStems(request.path) : request.stems;
  if (stems.empty()) {
    return absl::NotFoundError(
        absl::StrCat(request.path,
                     ": no frames in seq-*/frame-*.color.png (or .jpg); "
                     "is this the folder that holds the folders seq-01, ...?"));
  }
  index.frames.reserve(stems.size());
  for (const ListedStem& listed : stems) {
    TL_ASSIGN_OR_RETURN(DatasetFrame frame,
                        IndexFrameFiles(request, request.path, kFiles, listed));
    index.frames.push_back(std::move(frame));
  }
  return index;
}

}  // namespace treeline::dataset
