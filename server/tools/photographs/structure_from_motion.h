// Structure from motion by the program COLMAP 3.8: cameras and points of a
// folder of pictures.
#ifndef SERVER_TOOLS_PHOTOGRAPHS_STRUCTURE_FROM_MOTION_H_
#define SERVER_TOOLS_PHOTOGRAPHS_STRUCTURE_FROM_MOTION_H_

#include <stop_token>
#include <string>

#include "absl/status/statusor.h"
#include "common/dataset/sfm_model.h"

namespace treeline::photographs {

// The path of `program`: a path, or a name that is looked for in $PATH.
// FAILED_PRECONDITION, with what to install, if it is not there.
absl::StatusOr<std::string> FindColmap(const std::string& program);

struct StructureOptions {
  std::string colmap{};  // the program's path
  std::string images{};  // the folder of the pictures
  std::string work{};    // a folder for what is only needed meanwhile
  int pictures = 0;
  // Pictures are neighbours in time, as those of a video: each is matched with
  // those after it. Else each is matched with each.
  bool is_sequence = false;
  // All pictures are of one camera.
  bool is_one_camera = true;
  // Small ones are looked at twice as large: slow, and more features.
  int longest_side_px = 0;
  bool quiet = false;
};

struct Structure {
  std::string model_folder;  // below `work`
  dataset::SfmModel model;
  // Others that COLMAP could not join with it, and their pictures.
  int other_models = 0;
  int other_pictures = 0;
};

// Finds features, matches them and maps, on the processor alone; shows progress
// for each. The largest of the models that come out. FAILED_PRECONDITION: none
// does, with what to do; UNKNOWN, with the end of its log: COLMAP fails;
// CANCELLED.
absl::StatusOr<Structure> ComputeStructure(const StructureOptions& options,
                                           const std::stop_token& stop);

// Writes the model, turned, moved and scaled, to `output`, a folder that is
// there. COLMAP does it.
absl::Status TransformModel(const StructureOptions& options,
                            const std::string& model_folder,
                            const std::string& output, double scale,
                            const geometry::Rotation3& output_from_model,
                            const std::stop_token& stop);

// The rotation that turns "up" to z: up is what is up in most pictures, which
// people take about level. Identity if there is no image.
geometry::Rotation3 UprightFromModel(const dataset::SfmModel& model);

// Metres per unit of the model: `distance_m` between the cameras of two of its
// images. INVALID_ARGUMENT: there is no such image, or they are in one place.
absl::StatusOr<double> ScaleOfDistance(const dataset::SfmModel& model,
                                       const std::string& image_a,
                                       const std::string& image_b,
                                       double distance_m);

}  // namespace treeline::photographs

#endif  // SERVER_TOOLS_PHOTOGRAPHS_STRUCTURE_FROM_MOTION_H_
