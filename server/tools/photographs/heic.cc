#include "server/tools/photographs/heic.h"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <system_error>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/child_process.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "server/tools/photographs/photographs.h"

namespace treeline::photographs {
namespace {

// Without loss, 50 megapixels are some 100 MB.
constexpr uint64_t kMaxPngBytes = 256u << 20;

}  // namespace

bool IsHeicName(const std::string& name) {
  const std::string lower = absl::AsciiStrToLower(name);
  return absl::EndsWith(lower, ".heic") || absl::EndsWith(lower, ".heif") ||
         absl::EndsWith(lower, ".hif");
}

absl::StatusOr<image::ColorImage> ReadHeic(const std::string& path,
                                           const std::string& program,
                                           const std::string& work,
                                           const std::stop_token& stop) {
  std::error_code ignored;
  std::filesystem::remove_all(work, ignored);
  TL_ASSIGN_OR_RETURN(
      const std::unique_ptr<base::ChildProcess> child,
      base::ChildProcess::Start({program, path, work + "/picture.png"},
                                work + "/heif-convert.log"));
  const absl::Status converted = child->Wait(stop);
  if (absl::IsCancelled(converted)) return converted;
  // A file of several pictures becomes picture-1.png, picture-2.png, ...
  std::string png = work + "/picture.png";
  if (!base::IsFile(png)) png = work + "/picture-1.png";
  if (!converted.ok() || !base::IsFile(png)) {
    return absl::InvalidArgumentError(
        absl::StrCat(path, ": heif-convert cannot read it: ",
                     absl::StripAsciiWhitespace(child->Log())));
  }
  TL_ASSIGN_OR_RETURN(const std::string bytes,
                      base::ReadFile(png, kMaxPngBytes));
  // It copies EXIF's way up, though the picture has been turned by then.
  absl::StatusOr<image::ColorImage> picture =
      image::DecodeColor(bytes, kPhotographLimits);
  if (!picture.ok()) return base::Annotate(picture.status(), path);
  return picture;
}

}  // namespace treeline::photographs
