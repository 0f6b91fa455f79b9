#include "common/dataset/dataset_index.h"

#include <numeric>
#include <unordered_map>

#include "absl/strings/str_cat.h"

namespace treeline::dataset {

absl::Status StemNotFound(const IndexRequest& request, const ListedStem& stem,
                          const std::string& where) {
  std::string message = absl::StrCat("no frame '", stem.stem, "' in ", where);
  if (!request.frame_list.empty()) {
    message = absl::StrCat(request.frame_list, ":", stem.line, ": ", message);
  }
  return absl::NotFoundError(message);
}

absl::StatusOr<std::vector<int32_t>> SelectFrames(
    const IndexRequest& request, std::span<const std::string> stems,
    const std::string& where) {
  if (request.stems.empty()) {
    std::vector<int32_t> all(stems.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
  }
  std::unordered_map<std::string, int32_t> index_of;
  for (size_t i = 0; i < stems.size(); ++i) {
    index_of[stems[i]] = static_cast<int32_t>(i);
  }
  std::vector<int32_t> selected;
  for (const ListedStem& listed : request.stems) {
    const auto found = index_of.find(listed.stem);
    if (found == index_of.end()) return StemNotFound(request, listed, where);
    selected.push_back(found->second);
  }
  return selected;
}

}  // namespace treeline::dataset
