#include "client/bench/workload.h"

#include <algorithm>
#include <array>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "client/bench/truth_file.h"
#include "client/relocalizer/convert.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/image/decode.h"

namespace treeline::bench {
namespace {

constexpr uint64_t kOrderStream = 2;
constexpr int kJpegQuality = 90;

// In the order of the enumerations.
constexpr std::array<const char*, 4> kColorNames = {"file", "jpeg", "png",
                                                    "raw"};
constexpr std::array<const char*, 3> kDepthNames = {"png", "raw", "none"};

std::string Text(absl::string_view text) { return {text.data(), text.size()}; }

template <size_t N>
absl::StatusOr<int> IndexOf(absl::string_view name,
                            const std::array<const char*, N>& names) {
  const auto* found =
      std::find_if(names.begin(), names.end(),
                   [&](const char* known) { return name == known; });
  if (found == names.end()) {
    return absl::InvalidArgumentError(
        absl::StrCat("no encoding \"", name, "\""));
  }
  return static_cast<int>(found - names.begin());
}

absl::Status Reencode(FrameEncoding encoding, wire::QueryFrame& frame) {
  const std::string file = std::get<wire::EncodedImage>(frame.color).bytes;
  if (encoding.color != FrameEncoding::Color::kAsRecorded) {
    TL_ASSIGN_OR_RETURN(image::ColorImage image, image::DecodeColor(file));
    if (encoding.color == FrameEncoding::Color::kRaw) {
      frame.color = std::move(image);
    } else {
      wire::EncodedImage encoded;
      TL_ASSIGN_OR_RETURN(encoded.bytes,
                          encoding.color == FrameEncoding::Color::kJpeg
                              ? image::EncodeJpeg(image, kJpegQuality)
                              : image::EncodePng(image));
      frame.color = std::move(encoded);
    }
  }
  if (encoding.depth == FrameEncoding::Depth::kNone) frame.depth.reset();
  if (encoding.depth == FrameEncoding::Depth::kRaw && frame.depth) {
    TL_ASSIGN_OR_RETURN(
        image::DepthImage depth,
        image::DecodeDepthPng(
            std::get<wire::EncodedImage>(frame.depth->image).bytes,
            frame.depth->unit_m));
    frame.depth->image = std::move(depth);
  }
  return absl::OkStatus();
}

absl::StatusOr<WorkItem> MakeItem(const SceneFrames& source,
                                  const relocalizer::FrameFiles& files,
                                  FrameEncoding encoding,
                                  const WorkloadOptions& options) {
  relocalizer::LocalizeQuery query;
  query.scene = source.scene;
  query.seed = options.seed;
  TL_ASSIGN_OR_RETURN(query.frame,
                      relocalizer::ReadFrame(files, options.frames));
  const absl::Status encoded = Reencode(encoding, query.frame);
  if (!encoded.ok()) return base::Annotate(encoded, files.color);
  WorkItem item{.scene = source.scene,
                .stem = files.stem,
                .encoding = encoding.Name(),
                .request = {},
                .world_from_camera = {}};
  TL_ASSIGN_OR_RETURN(item.world_from_camera,
                      ReadTruth(source.root, files.stem));
  const grpc::Slice bytes(relocalizer::ToProto(query).SerializeAsString());
  item.request = grpc::ByteBuffer(&bytes, 1);
  return item;
}

absl::Status AddScene(const SceneFrames& source, const WorkloadOptions& options,
                      std::vector<WorkItem>& items) {
  TL_ASSIGN_OR_RETURN(const std::vector<relocalizer::FrameFiles> list,
                      relocalizer::ReadFrameList(source.list, source.root));
  const size_t count =
      std::min(list.size(), static_cast<size_t>(options.max_frames));
  for (size_t i = 0; i < count; ++i) {
    const relocalizer::FrameFiles& files = list[i * list.size() / count];
    for (const FrameEncoding& encoding : options.encodings) {
      TL_ASSIGN_OR_RETURN(WorkItem item,
                          MakeItem(source, files, encoding, options));
      items.push_back(std::move(item));
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SceneFrames> SceneFrames::Parse(absl::string_view text) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits('=', 1));
  const std::pair<absl::string_view, absl::string_view> place =
      absl::StrSplit(parts.second, absl::MaxSplits(',', 1));
  if (parts.first.empty() || place.first.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", text, "\" is not NAME=ROOT or NAME=ROOT,LIST"));
  }
  return SceneFrames{.scene = Text(parts.first),
                     .root = Text(place.first),
                     .list = place.second.empty()
                                 ? absl::StrCat(place.first, "/test.txt")
                                 : Text(place.second)};
}

absl::StatusOr<FrameEncoding> FrameEncoding::Parse(absl::string_view text) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits('+', 1));
  TL_ASSIGN_OR_RETURN(const int color, IndexOf(parts.first, kColorNames));
  int depth = 0;
  if (!parts.second.empty()) {
    TL_ASSIGN_OR_RETURN(depth, IndexOf(parts.second, kDepthNames));
  }
  return FrameEncoding{.color = static_cast<Color>(color),
                       .depth = static_cast<Depth>(depth)};
}

std::string FrameEncoding::Name() const {
  return absl::StrCat(kColorNames[static_cast<size_t>(color)], "+",
                      kDepthNames[static_cast<size_t>(depth)]);
}

absl::StatusOr<std::vector<WorkItem>> LoadWorkload(
    const WorkloadOptions& options) {
  std::vector<WorkItem> items;
  for (const SceneFrames& scene : options.scenes) {
    TL_RETURN_IF_ERROR(AddScene(scene, options, items));
  }
  base::Random random(options.seed, kOrderStream);
  for (size_t i = items.size(); i > 1; --i) {
    const size_t j = random.NextBelow(static_cast<uint32_t>(i));
    // gRPC 1.51's ByteBuffer leaks when it is assigned to itself.
    if (j != i - 1) std::swap(items[i - 1], items[j]);
  }
  return items;
}

}  // namespace treeline::bench
