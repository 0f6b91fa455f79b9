#include "server/tools/photographs/structure_from_motion.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/child_process.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/dataset/colmap.h"

namespace treeline::photographs {
namespace {

namespace fs = std::filesystem;

constexpr auto kLook = std::chrono::milliseconds(200);
// Matching without a GPU compares each feature with each: more make it slow
// (8192, COLMAP's own limit, take seven times as long).
constexpr const char* kMaxFeatures = "3000";
// From here on, pictures have enough features as they are.
constexpr int kLargePicture_px = 1200;
// A picture of a video is matched with so many after it, and with some further
// ones.
constexpr const char* kOverlap = "12";
// Below it, features of pictures that are not of the same thing match too.
constexpr size_t kFewestImages = 3;

int CountOf(const std::string& text, const std::string& marker) {
  int count = 0;
  if (marker.empty()) return 0;  // a step that is over at once
  for (size_t at = text.find(marker); at != std::string::npos;
       at = text.find(marker, at + marker.size())) {
    ++count;
  }
  return count;
}

// One command of COLMAP, from beginning to end. Its progress is read from its
// log, where each unit of the work writes `marker`.
class ColmapStep {
 public:
  ColmapStep(const StructureOptions& options, std::string command)
      : options_(options), command_(std::move(command)) {
    argv_ = {options.colmap, command_};
  }
  ColmapStep& With(const std::string& flag, const std::string& value) {
    argv_.push_back("--" + flag);
    argv_.push_back(value);
    return *this;
  }
  absl::Status Run(const std::string& label, const std::string& marker,
                   int total, const std::stop_token& stop) {
    const std::string log = absl::StrCat(options_.work, "/", command_, ".log");
    TL_ASSIGN_OR_RETURN(const std::unique_ptr<base::ChildProcess> child,
                        base::ChildProcess::Start(argv_, log));
    base::Progress progress(label, std::max(1, total), options_.quiet);
    int done = 0;
    while (!child->ExitCode().has_value() && !stop.stop_requested()) {
      std::this_thread::sleep_for(kLook);
      const int count = std::min(total, CountOf(child->Log(), marker));
      if (count > done) progress.Add(count - done);
      done = std::max(done, count);
    }
    return child->Wait(stop);
  }

 private:
  const StructureOptions& options_;
  const std::string command_;
  std::vector<std::string> argv_;
};

absl::Status FindFeatures(const StructureOptions& options,
                          const std::string& database,
                          const std::stop_token& stop) {
  return ColmapStep(options, "feature_extractor")
      .With("database_path", database)
      .With("image_path", options.images)
      .With("ImageReader.single_camera", options.is_one_camera ? "1" : "0")
      .With("ImageReader.camera_model", "SIMPLE_RADIAL")
      .With("SiftExtraction.use_gpu", "0")
      .With("SiftExtraction.max_num_features", kMaxFeatures)
      .With("SiftExtraction.first_octave",
            options.longest_side_px < kLargePicture_px ? "-1" : "0")
      .Run("features", "Processed file [", options.pictures, stop);
}

absl::Status MatchFeatures(const StructureOptions& options,
                           const std::string& database,
                           const std::stop_token& stop) {
  // A block of the exhaustive matcher is of 50 x 50 pictures.
  constexpr int kBlock = 50;
  const int blocks = (options.pictures + kBlock - 1) / kBlock;
  ColmapStep step(options, options.is_sequence ? "sequential_matcher"
                                               : "exhaustive_matcher");
  step.With("database_path", database).With("SiftMatching.use_gpu", "0");
  if (!options.is_sequence) {
    return step.Run("matching", "Matching block [", blocks * blocks, stop);
  }
  step.With("SequentialMatching.overlap", kOverlap);
  return step.Run("matching", "Matching image [", options.pictures, stop);
}

absl::Status NoStructure(const StructureOptions& options) {
  return absl::FailedPreconditionError(absl::StrCat(
      "COLMAP found nothing that relates the ", options.pictures,
      " pictures to each other. Take more, so that each shows half of what the "
      "one before shows; move sideways between them instead of turning on the "
      "spot; avoid blur, bare walls and mirrors"));
}

}  // namespace

absl::StatusOr<std::string> FindColmap(const std::string& program) {
  std::string found = base::FindProgram(program);
  if (!found.empty()) return found;
  return absl::FailedPreconditionError(absl::StrCat(
      "photographs and videos need COLMAP, and there is no ", program,
      ". On Debian 12: apt install colmap. Or compute the structure elsewhere: "
      "docs/how-to/learn-from-photographs.md"));
}

absl::StatusOr<Structure> ComputeStructure(const StructureOptions& options,
                                           const std::stop_token& stop) {
  const std::string database = options.work + "/database.db";
  const std::string models = options.work + "/models";
  TL_RETURN_IF_ERROR(base::MakeParentFolder(models + "/x"));
  TL_RETURN_IF_ERROR(FindFeatures(options, database, stop));
  TL_RETURN_IF_ERROR(MatchFeatures(options, database, stop));
  const absl::Status mapped =
      ColmapStep(options, "mapper")
          .With("database_path", database)
          .With("image_path", options.images)
          .With("output_path", models)
          .Run("mapping", "Registering image #", options.pictures, stop);
  if (absl::IsCancelled(mapped)) return mapped;
  Structure best;
  int all_images = 0;
  int all_models = 0;
  for (const std::string& name : base::SortedNamesIn(models)) {
    const std::string folder = absl::StrCat(models, "/", name);
    TL_ASSIGN_OR_RETURN(dataset::SfmModel model,
                        dataset::ReadColmap(folder, std::nullopt));
    ++all_models;
    all_images += static_cast<int>(model.images.size());
    if (model.images.size() > best.model.images.size()) {
      best.model_folder = folder;
      best.model = std::move(model);
    }
  }
  // COLMAP's mapper fails where it finds no pair to begin with.
  if (best.model.images.size() < kFewestImages) return NoStructure(options);
  best.other_models = all_models - 1;
  best.other_pictures = all_images - static_cast<int>(best.model.images.size());
  return best;
}

absl::Status TransformModel(const StructureOptions& options,
                            const std::string& model_folder,
                            const std::string& output, double scale,
                            const geometry::Rotation3& output_from_model,
                            const std::stop_token& stop) {
  const geometry::Mat3 r = output_from_model.Matrix();
  std::string text;
  for (int row = 0; row < 3; ++row) {
    absl::StrAppendFormat(&text, "%.17g %.17g %.17g 0\n", scale * r(row, 0),
                          scale * r(row, 1), scale * r(row, 2));
  }
  const std::string path = options.work + "/transform.txt";
  TL_RETURN_IF_ERROR(base::WriteFileAtomically(path, text + "0 0 0 1\n"));
  StructureOptions silent = options;
  silent.quiet = true;
  return ColmapStep(silent, "model_transformer")
      .With("input_path", model_folder)
      .With("output_path", output)
      .With("transform_path", path)
      .Run("", "", 1, stop);
}

geometry::Rotation3 UprightFromModel(const dataset::SfmModel& model) {
  geometry::Vec3 up{0, 0, 0};
  for (const dataset::SfmModel::Image& image : model.images) {
    up = up +
         image.camera_from_world.rotation.Inverse() * geometry::Vec3{0, -1, 0};
  }
  const double norm = geometry::Norm(up);
  if (norm < 1e-9) return {};
  up = up / norm;
  // The shortest turn from `up` to z; from -z any half turn does.
  const geometry::Vec3 z{0, 0, 1};
  const double cosine = geometry::Dot(up, z);
  if (cosine < -1 + 1e-9) return {0, 1, 0, 0};
  const geometry::Vec3 axis = geometry::Cross(up, z);
  const double w = 1 + cosine;
  const double length = std::sqrt(w * w + geometry::Dot(axis, axis));
  return {w / length, axis.x / length, axis.y / length, axis.z / length};
}

absl::StatusOr<double> ScaleOfDistance(const dataset::SfmModel& model,
                                       const std::string& image_a,
                                       const std::string& image_b,
                                       double distance_m) {
  std::vector<geometry::Vec3> centres;
  for (const std::string& name : {image_a, image_b}) {
    const auto found =
        std::ranges::find(model.images, name, &dataset::SfmModel::Image::name);
    if (found == model.images.end()) {
      return absl::InvalidArgumentError(
          absl::StrCat("--distance: there is no picture ", name,
                       " in the structure; the first is ",
                       model.images.empty() ? "none" : model.images[0].name));
    }
    centres.push_back(found->camera_from_world.Inverse().translation);
  }
  const double units = geometry::Norm(centres[1] - centres[0]);
  if (!(units > 0) || !std::isfinite(units)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--distance: ", image_a, " and ", image_b, " are in one place"));
  }
  return distance_m / units;
}

}  // namespace treeline::photographs
