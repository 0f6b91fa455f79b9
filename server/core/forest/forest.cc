#include "server/core/forest/forest.h"

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"

namespace treeline::forest {
namespace {

absl::Status ValidateTree(std::span<const Node> tree, int t, size_t modes,
                          bool sift) {
  const auto corrupt = [&](size_t node, absl::string_view what) {
    return absl::DataLossError(
        absl::StrCat("forest: tree ", t, ", node ", node, ": ", what));
  };
  if (tree.empty() || tree.size() > Node::kMaxNodesPerTree) {
    return corrupt(0, "the tree has no nodes or too many");
  }
  for (size_t i = 0; i < tree.size(); ++i) {
    const Node& node = tree[i];
    if (node.is_leaf()) {
      if (node.leaf() + node.modes() > modes) {
        return corrupt(i, "no such leaf");
      }
      continue;
    }
    if (node.right_offset() < 2 || i + node.right_offset() >= tree.size()) {
      return corrupt(i, "a child lies outside the tree");
    }
    const features::PixelDifference feature = node.feature();
    if (sift) {
      if (feature.dx < 0 ||
          feature.dx >= features::SiftDescriptor::kDimensions) {
        return corrupt(i, "no such descriptor dimension");
      }
      continue;
    }
    if (feature.c1 > 2 || feature.c2 > 2) {
      return corrupt(i, "no such colour channel");
    }
  }
  return absl::OkStatus();
}

}  // namespace

geometry::Vec3 ForestView::LeafMean(uint32_t leaf) const {
  const std::array<uint16_t, 3>& mean = payloads[leaf].mean;
  const geometry::Vec3 extent = bounds_max_in_world - bounds_min_in_world;
  return {bounds_min_in_world.x + mean[0] * (extent.x / 65535),
          bounds_min_in_world.y + mean[1] * (extent.y / 65535),
          bounds_min_in_world.z + mean[2] * (extent.z / 65535)};
}

absl::Status ForestView::Validate() const {
  if (tree_offsets.size() < 2 || tree_offsets.front() != 0 ||
      tree_offsets.back() != nodes.size()) {
    return absl::DataLossError("forest: bad tree offsets");
  }
  const size_t described = descriptors.size() + sift_descriptors.size();
  if (described != payloads.size() ||
      (!descriptors.empty() && !sift_descriptors.empty())) {
    return absl::DataLossError(absl::StrCat("forest: ", described,
                                            " leaf descriptors but ",
                                            payloads.size(), " leaf payloads"));
  }
  if (!geometry::IsFinite(bounds_min_in_world) ||
      !geometry::IsFinite(bounds_max_in_world)) {
    return absl::DataLossError("forest: bounds are not finite");
  }
  for (size_t t = 0; t + 1 < tree_offsets.size(); ++t) {
    if (tree_offsets[t] >= tree_offsets[t + 1] ||
        tree_offsets[t + 1] > nodes.size()) {
      return absl::DataLossError("forest: bad tree offsets");
    }
  }
  for (int t = 0; t < trees(); ++t) {
    TL_RETURN_IF_ERROR(
        ValidateTree(tree(t), t, payloads.size(), !sift_descriptors.empty()));
  }
  return absl::OkStatus();
}

}  // namespace treeline::forest
