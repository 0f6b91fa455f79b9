#include "client/bench/truth_file.h"

#include <array>
#include <cmath>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::bench {

absl::StatusOr<std::optional<geometry::Rigid3>> ReadTruth(
    const std::string& root, const std::string& stem) {
  const std::string path = absl::StrCat(root, "/", stem, ".pose.txt");
  const absl::StatusOr<std::string> text = base::ReadFile(path, 1 << 16);
  if (absl::IsNotFound(text.status())) return std::nullopt;
  TL_RETURN_IF_ERROR(text.status());
  const std::vector<absl::string_view> words =
      absl::StrSplit(*text, absl::ByAnyChar(" \t\r\n"), absl::SkipEmpty());
  std::array<double, 16> matrix{};
  bool finite = true;
  for (size_t i = 0; i < matrix.size(); ++i) {
    if (words.size() != matrix.size() ||
        !absl::SimpleAtod(words[i], &matrix[i])) {
      return absl::InvalidArgumentError(
          absl::StrCat(path, ": not a matrix of 4 x 4 numbers"));
    }
    finite = finite && std::isfinite(matrix[i]);
  }
  if (!finite) return std::nullopt;
  const absl::StatusOr<geometry::Rigid3> pose =
      geometry::RigidFromMatrix4(matrix);
  if (!pose.ok()) return base::Annotate(pose.status(), path);
  return *pose;
}

}  // namespace treeline::bench
