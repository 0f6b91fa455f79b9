#include "server/tools/capture/picture_files.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/picture_files.h"
#include "common/image/decode.h"

namespace treeline::capture {
namespace {

bool IsDigit(char c) {
  return absl::ascii_isdigit(static_cast<unsigned char>(c));
}

// The number at the front of `text`, without leading zeros; taken off it.
absl::string_view TakeDigits(absl::string_view& text) {
  size_t length = 0;
  while (length < text.size() && IsDigit(text[length])) ++length;
  absl::string_view digits = text.substr(0, length);
  text.remove_prefix(length);
  while (digits.size() > 1 && digits.front() == '0') digits.remove_prefix(1);
  return digits;
}

}  // namespace

absl::StatusOr<image::DepthImage> DecodeDepth_mm(absl::string_view png,
                                                 double unit_m) {
  TL_ASSIGN_OR_RETURN(image::DepthImage depth,
                      image::DecodeDepthPng(png, unit_m));
  return ToMillimetres(std::move(depth));
}

image::DepthImage ToMillimetres(image::DepthImage depth) {
  const double unit_mm = 1000 * depth.unit_m;
  for (uint16_t& value : depth.values) {
    const double depth_mm =
        image::IsMeasured(value) ? std::round(unit_mm * value) : 0;
    value = depth_mm < 65535 ? static_cast<uint16_t>(depth_mm) : uint16_t{0};
  }
  depth.unit_m = 0.001;
  return depth;
}

absl::Status KeepConfident(std::span<const uint8_t> confidence, int min_value,
                           image::DepthImage& depth) {
  if (confidence.size() != depth.values.size()) {
    return absl::InvalidArgumentError(
        absl::StrCat("the confidence map has ", confidence.size(),
                     " pixels, the depth map ", depth.values.size()));
  }
  for (size_t i = 0; i < confidence.size(); ++i) {
    if (confidence[i] < min_value) depth.values[i] = 0;
  }
  return absl::OkStatus();
}

absl::Status KeepConfident(absl::string_view confidence_png, int min_value,
                           image::DepthImage& depth) {
  TL_ASSIGN_OR_RETURN(const image::ColorImage map,
                      image::DecodeColor(confidence_png));
  if (map.width != depth.width || map.height != depth.height) {
    return absl::InvalidArgumentError(absl::StrCat(
        "the confidence map has ", map.width, " x ", map.height,
        " pixels, the depth map ", depth.width, " x ", depth.height));
  }
  std::vector<uint8_t> confidence;
  for (size_t i = 0; i < map.rgb.size(); i += 3) {
    confidence.push_back(map.rgb[i]);
  }
  return KeepConfident(confidence, min_value, depth);
}

absl::StatusOr<std::optional<image::DepthImage>> ReadDepth_mm(
    const FrameFiles& files, const DepthRules& rules) {
  if (files.depth.empty()) return std::nullopt;
  TL_ASSIGN_OR_RETURN(const std::string png, dataset::ReadPicture(files.depth));
  absl::StatusOr<image::DepthImage> depth = DecodeDepth_mm(png, rules.unit_m);
  if (!depth.ok()) return base::Annotate(depth.status(), files.depth);
  if (!files.confidence.empty() && rules.min_confidence_value > 0) {
    TL_ASSIGN_OR_RETURN(const std::string map,
                        dataset::ReadPicture(files.confidence));
    const absl::Status kept =
        KeepConfident(map, rules.min_confidence_value, *depth);
    if (!kept.ok()) return base::Annotate(kept, files.confidence);
  }
  return *std::move(depth);
}

absl::StatusOr<Pictures> PictureFiles::Load(size_t frame) {
  const FrameFiles& files = frames_[frame];
  Pictures pictures;
  TL_ASSIGN_OR_RETURN(pictures.encoded_color,
                      dataset::ReadPicture(files.color));
  absl::StatusOr<image::ColorImage> color =
      image::DecodeColor(pictures.encoded_color);
  if (!color.ok()) return base::Annotate(color.status(), files.color);
  pictures.color = *std::move(color);
  TL_ASSIGN_OR_RETURN(pictures.depth, ReadDepth_mm(files, rules_));
  return pictures;
}

std::string IfFile(std::string path) {
  return base::IsFile(path) ? std::move(path) : std::string();
}

std::string FindPicture(const std::string& path) {
  for (const char* ending : {".jpg", ".jpeg", ".png", ".JPG", ".PNG"}) {
    if (base::IsFile(path + ending)) return path + ending;
  }
  return "";
}

std::string PhotographFolderIn(const std::string& capture) {
  constexpr size_t kFewest = 3;
  const std::string top =
      base::IsFile(capture)
          ? std::filesystem::path(capture).parent_path().string()
          : capture;
  std::string best;
  size_t most = kFewest - 1;
  const auto look_into = [&](const std::string& folder) {
    size_t count = 0;
    for (const std::string& name : base::SortedNamesIn(folder)) {
      const std::string lower = absl::AsciiStrToLower(name);
      count += absl::EndsWith(lower, ".jpg") ||
               absl::EndsWith(lower, ".jpeg") ||
               absl::EndsWith(lower, ".png") || absl::EndsWith(lower, ".heic");
    }
    if (count > most) {
      most = count;
      best = folder;
    }
  };
  look_into(top.empty() ? "." : top);
  for (const std::string& name : base::SortedNamesIn(top)) {
    look_into(absl::StrCat(top, "/", name));
  }
  return best;
}

bool NaturalLess(absl::string_view a, absl::string_view b) {
  while (!a.empty() && !b.empty()) {
    if (IsDigit(a.front()) && IsDigit(b.front())) {
      const absl::string_view x = TakeDigits(a);
      const absl::string_view y = TakeDigits(b);
      if (x.size() != y.size()) return x.size() < y.size();
      if (x != y) return x < y;
    } else if (a.front() != b.front()) {
      return a.front() < b.front();
    } else {
      a.remove_prefix(1);
      b.remove_prefix(1);
    }
  }
  return a.size() < b.size();
}

std::vector<std::string> StemsIn(const std::string& folder,
                                 absl::string_view ending) {
  std::vector<std::string> stems;
  for (const std::string& name : base::SortedNamesIn(folder)) {
    absl::string_view stem = name;
    if (absl::ConsumeSuffix(&stem, ending)) stems.emplace_back(stem);
  }
  std::ranges::stable_sort(stems, NaturalLess);
  return stems;
}

}  // namespace treeline::capture
