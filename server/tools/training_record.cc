#include "server/tools/training_record.h"

#include "absl/strings/str_cat.h"

namespace treeline::tools {

std::vector<std::pair<std::string, std::string>> RecordedOptions(
    const dataset::DatasetOptions& dataset, const std::string& calibration,
    const training::TrainingOptions& training, const std::string& adapt,
    const std::string& extend) {
  const training::TrainingOptions& t = training;
  return {{"frames", dataset.frame_list},
          {"poses", dataset.pose_file},
          {"calibration", calibration},
          {"adapt", adapt},
          {"extend", extend},
          {"trees", absl::StrCat(t.trees)},
          {"frames-per-tree", absl::StrCat(t.frames_per_tree)},
          {"samples-per-frame", absl::StrCat(t.samples_per_frame)},
          {"balanced-levels", absl::StrCat(t.balanced_levels)},
          {"max-depth", absl::StrCat(t.max_depth)},
          {"min-leaf-samples", absl::StrCat(t.min_leaf_samples)},
          {"min-kept-samples", absl::StrCat(t.min_kept_samples)},
          {"min-spread", absl::StrCat(t.min_spread_m)},
          {"split-candidates", absl::StrCat(t.split_candidates)},
          {"max-offset", absl::StrCat(t.max_offset_px_m)},
          {"split-samples", absl::StrCat(t.max_split_samples)}};
}

std::vector<std::pair<std::string, std::string>> RecordedSiftOptions(
    const dataset::DatasetOptions& dataset,
    const training::TrainingOptions& training,
    const training::SiftTrainingOptions& sift) {
  return {{"frames", dataset.frame_list},
          {"trees", absl::StrCat(training.trees)},
          {"sift-features", absl::StrCat(sift.features.max_features)},
          {"sift-label-radius", absl::StrCat(sift.label_radius_px)},
          {"sift-balanced-levels", absl::StrCat(sift.balanced_levels)},
          {"sift-leaf-samples", absl::StrCat(sift.leaf_samples)},
          {"sift-candidates", absl::StrCat(sift.split_candidates)}};
}

}  // namespace treeline::tools
