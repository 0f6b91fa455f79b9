// Reader of COLMAP's models, text and binary (COLMAP's doc/format.rst).
//
// COLMAP puts the centre of the top left pixel at (0.5, 0.5); principal points
// and keypoints are half a pixel less here.
#ifndef COMMON_DATASET_COLMAP_H_
#define COMMON_DATASET_COLMAP_H_

#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "common/dataset/sfm_model.h"

namespace treeline::dataset {

// One file of a model, in memory.
struct ColmapFile {
  std::string path;  // for errors
  std::string bytes;
  bool binary = false;
};

struct ColmapFiles {
  ColmapFile images;
  // Absent: `camera` below is every image's.
  std::optional<ColmapFile> cameras;
  // Absent: keypoints have no points.
  std::optional<ColmapFile> points;
  std::optional<camera::Camera> camera;
};

// INVALID_ARGUMENT, with the file and the line or byte, for what is malformed:
// truncated files and counts beyond a file's end, numbers that are not finite,
// quaternions that are not of unit length (to 1 %), camera models that COLMAP
// does not have, ids that are defined twice or not at all, images of the same
// name or one that leads out of the folder, tracks that contradict the images.
// Safe on hostile input: memory is at most a small multiple of the files'.
absl::StatusOr<SfmModel> ParseColmap(const ColmapFiles& files);

// Reads the model in `folder`: images.bin or images.txt, and where they exist
// points3D and cameras (.bin before .txt, as COLMAP does). A folder without a
// cameras file is a part of a model whose cameras lie beside it: they are
// looked for in ../sparse, ../sparse/0 and .. . If `camera` is given it is
// taken for every image, and no cameras file is read. NOT_FOUND if there are no
// images or no cameras; errors of ParseColmap.
absl::StatusOr<SfmModel> ReadColmap(
    const std::string& folder, const std::optional<camera::Camera>& camera);

}  // namespace treeline::dataset

#endif  // COMMON_DATASET_COLMAP_H_
