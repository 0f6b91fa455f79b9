#include "server/core/training/tree_part.h"

#include <xxhash.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/status_macros.h"
#include "common/camera/calibration_json.h"
#include "server/core/forest/model_file.h"
#include "server/core/training/quantize_forest.h"

namespace treeline::training {
namespace {

// The exact position of a mode: what forests store depends on the bounds of all
// their trees, which a part does not know.
struct LeafMean {
  double x;
  double y;
  double z;
};
static_assert(sizeof(LeafMean) == 24);

constexpr double kFarthest_m = 1e9;

// Options that say where files lie, which differs from machine to machine.
bool IsPlace(absl::string_view option) {
  return option == "frames" || option == "poses" || option == "calibration";
}

std::string OptionsOf(const forest::ModelInfo& info) {
  std::string text;
  for (const auto& [name, value] : info.options) {
    if (!IsPlace(name)) absl::StrAppend(&text, "--", name, " ", value, " ");
  }
  return text;
}

// Empty: both are of one scene.
std::string DifferenceBetween(const forest::ModelInfo& a,
                              const forest::ModelInfo& b) {
  const auto differs = [](absl::string_view what, absl::string_view x,
                          absl::string_view y) {
    return absl::StrCat(what, ": ", x, " and ", y);
  };
  if (a.method != b.method) return differs("method", a.method, b.method);
  if (a.software_version != b.software_version) {
    return differs("version", a.software_version, b.software_version);
  }
  if (a.seed != b.seed) {
    return differs("seed", absl::StrCat(a.seed), absl::StrCat(b.seed));
  }
  if (a.part->trees != b.part->trees) {
    return differs("trees of the scene", absl::StrCat(a.part->trees),
                   absl::StrCat(b.part->trees));
  }
  if (OptionsOf(a) != OptionsOf(b)) {
    return differs("options", OptionsOf(a), OptionsOf(b));
  }
  if (a.part->frames_checksum != b.part->frames_checksum) {
    return "frames or their poses";
  }
  if (camera::CalibrationToJson(a.calibration) !=
      camera::CalibrationToJson(b.calibration)) {
    return "calibration (estimate it once, with `treeline calibrate`, and give "
           "it to each part with --calibration FILE)";
  }
  return "";
}

}  // namespace

absl::Status WriteTreePart(const std::string& path, const TreePart& part) {
  std::vector<forest::Forest> forests;
  std::vector<LeafMean> means;
  for (const GrownTree& tree : part.trees) {
    for (const GrownLeaf& leaf : tree.leaves) {
      const geometry::Vec3& mean = leaf.mean_in_world;
      means.push_back({mean.x, mean.y, mean.z});
    }
    forests.push_back(QuantizeForest({tree}));
  }
  std::vector<forest::ForestView> views;
  for (const forest::Forest& forest : forests) views.push_back(forest.View());
  const forest::ModelExtraBytes extra{
      forest::ModelExtra::kLeafMeans,
      {reinterpret_cast<const char*>(means.data()),
       means.size() * sizeof(LeafMean)}};
  return forest::WriteModel(path, part.info, views, std::span(&extra, 1));
}

absl::StatusOr<TreePart> ReadTreePart(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<const forest::ModelFile> file,
                      forest::ModelFile::Open(path));
  if (!file->info().part) {
    return absl::FailedPreconditionError(absl::StrCat(
        path,
        ": a whole scene, no part of one; parts are made by `treeline "
        "train --tree`"));
  }
  const auto corrupt = [&](absl::string_view why) {
    return absl::DataLossError(absl::StrCat(path, ": corrupt part: ", why));
  };
  TL_ASSIGN_OR_RETURN(const std::span<const LeafMean> means,
                      file->Extra<LeafMean>(forest::ModelExtra::kLeafMeans));
  TreePart part{file->info(), {}};
  size_t next_mean = 0;
  for (size_t f = 0; f < file->forests(); ++f) {
    const forest::ForestView& forest = file->forest(f);
    if (forest.trees() != 1) return corrupt("a forest has more than its tree");
    if (forest.descriptors.size() != forest.payloads.size()) {
      return corrupt("leaves without descriptors");
    }
    GrownTree& tree = part.trees.emplace_back(GrownTreeOf(forest, 0));
    if (tree.leaves.size() > means.size() - next_mean) {
      return corrupt("leaves without positions");
    }
    for (GrownLeaf& leaf : tree.leaves) {
      const LeafMean& mean = means[next_mean++];
      leaf.mean_in_world = {mean.x, mean.y, mean.z};
      if (!(geometry::Norm(leaf.mean_in_world) < kFarthest_m)) {
        return corrupt("a leaf's position is nowhere");
      }
    }
  }
  if (next_mean != means.size()) return corrupt("positions without leaves");
  return part;
}

absl::StatusOr<std::vector<TreePart>> ReadTreeParts(
    const std::vector<std::string>& paths) {
  if (paths.empty()) return absl::InvalidArgumentError("no parts to merge");
  std::vector<std::optional<TreePart>> by_tree;
  std::vector<std::string> path_of_tree;
  std::optional<forest::ModelInfo> first;
  for (const std::string& path : paths) {
    TL_ASSIGN_OR_RETURN(TreePart part, ReadTreePart(path));
    if (!first) {
      first = part.info;
      by_tree.resize(static_cast<size_t>(first->part->trees));
      path_of_tree.resize(by_tree.size());
    }
    if (const std::string difference = DifferenceBetween(*first, part.info);
        !difference.empty()) {
      return absl::InvalidArgumentError(absl::StrCat(
          paths.front(), " and ", path,
          " are no parts of one scene; they differ in ", difference));
    }
    const size_t tree = static_cast<size_t>(part.info.part->tree);
    if (by_tree[tree]) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, " and ", path_of_tree[tree], " are both tree ",
                       tree, " of ", by_tree.size()));
    }
    path_of_tree[tree] = path;
    by_tree[tree] = std::move(part);
  }
  std::vector<TreePart> parts;
  for (size_t t = 0; t < by_tree.size(); ++t) {
    if (!by_tree[t]) {
      return absl::InvalidArgumentError(absl::StrCat(
          "tree ", t, " of ", by_tree.size(),
          " is missing; make it with `treeline train --tree ", t, "`"));
    }
    parts.push_back(std::move(*by_tree[t]));
    if (parts.back().trees.size() != parts.front().trees.size()) {
      return absl::DataLossError(
          absl::StrCat(path_of_tree[t], ": has another number of forests than ",
                       path_of_tree.front()));
    }
  }
  return parts;
}

std::string FramesChecksum(const dataset::Dataset& dataset) {
  std::string text;
  for (int i = 0; i < dataset.size(); ++i) {
    const dataset::DatasetFrame& frame = dataset.frame(i);
    absl::StrAppend(&text, frame.stem,
                    frame.depth_path.empty() ? "" : " depth");
    if (frame.world_from_camera) {
      const geometry::Rigid3& pose = *frame.world_from_camera;
      const geometry::Vec3& t = pose.translation;
      const geometry::Vec3 r = geometry::ToAxisAngle(pose.rotation);
      absl::StrAppendFormat(&text, " %.6f %.6f %.6f %.6f %.6f %.6f", t.x, t.y,
                            t.z, r.x, r.y, r.z);
    }
    text += '\n';
  }
  return absl::StrFormat("%016x", XXH3_64bits(text.data(), text.size()));
}

}  // namespace treeline::training
