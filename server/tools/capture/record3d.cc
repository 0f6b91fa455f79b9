#include "server/tools/capture/record3d.h"

#include <array>
#include <bit>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/image/millimetres.h"
#include "server/tools/capture/conventions.h"
#include "server/tools/capture/json_text.h"
#include "server/tools/capture/lzfse.h"
#include "server/tools/capture/picture_files.h"
#include "server/tools/capture/zip_archive.h"

namespace treeline::capture {
namespace {

// Where the parts of a recording are: in an archive, or in a folder.
struct Parts {
  std::function<bool(const std::string& name)> has;
  std::function<absl::StatusOr<std::string>(const std::string& name)> read;
};

absl::StatusOr<Parts> PartsOf(const std::string& path) {
  if (!base::IsFile(path)) {
    const auto in_folder = [path](const std::string& name) {
      return absl::StrCat(path, "/", name);
    };
    return Parts{[in_folder](const std::string& name) {
                   return base::IsFile(in_folder(name));
                 },
                 [in_folder](const std::string& name) {
                   return base::ReadFile(in_folder(name),
                                         ZipArchive::kMaxEntryBytes);
                 }};
  }
  TL_ASSIGN_OR_RETURN(ZipArchive opened, ZipArchive::OpenFile(path));
  const auto archive = std::make_shared<const ZipArchive>(std::move(opened));
  return Parts{
      [archive](const std::string& name) { return archive->Has(name); },
      [archive, path](const std::string& name) {
        auto bytes = archive->Read(name);
        return bytes.ok() ? bytes : base::Annotate(bytes.status(), path);
      }};
}

class Record3dPictures final : public PictureSource {
 public:
  Record3dPictures(Parts parts, std::vector<int> numbers,
                   std::optional<image::ImageSize> depth_size,
                   int min_confidence)
      : parts_(std::move(parts)),
        numbers_(std::move(numbers)),
        depth_size_(depth_size),
        min_confidence_(min_confidence) {}

  absl::StatusOr<Pictures> Load(size_t frame) override {
    const std::string base = absl::StrCat("rgbd/", numbers_[frame]);
    Pictures pictures;
    TL_ASSIGN_OR_RETURN(pictures.encoded_color, parts_.read(base + ".jpg"));
    auto color = image::DecodeColor(pictures.encoded_color);
    if (!color.ok()) return base::Annotate(color.status(), base + ".jpg");
    pictures.color = *std::move(color);
    if (!depth_size_ || !parts_.has(base + ".depth")) return pictures;
    TL_ASSIGN_OR_RETURN(const std::string file, parts_.read(base + ".depth"));
    auto depth = DecodeRecord3dDepth(file, *depth_size_);
    if (!depth.ok()) return base::Annotate(depth.status(), base + ".depth");
    if (min_confidence_ > 0 && parts_.has(base + ".conf")) {
      TL_ASSIGN_OR_RETURN(const std::string packed,
                          parts_.read(base + ".conf"));
      const auto map = DecodeLzfse(packed, depth->values.size());
      if (!map.ok()) return base::Annotate(map.status(), base + ".conf");
      TL_RETURN_IF_ERROR(KeepConfident(*map, min_confidence_, *depth));
    }
    pictures.depth = *std::move(depth);
    return pictures;
  }

 private:
  const Parts parts_;
  const std::vector<int> numbers_;
  const std::optional<image::ImageSize> depth_size_;
  const int min_confidence_;
};

const Json* ArrayOf(const Json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_array() ? &*found : nullptr;
}

}  // namespace

absl::StatusOr<Record3dMetadata> ParseRecord3dMetadata(
    absl::string_view text, const std::string& where) {
  TL_ASSIGN_OR_RETURN(const Json json, ParseJsonObject(text, where));
  image::ImageSize size;
  TL_ASSIGN_OR_RETURN(size.width, SideOf(json, "w", where));
  TL_ASSIGN_OR_RETURN(size.height, SideOf(json, "h", where));
  std::array<double, 9> k{};
  const Json* const matrix = ArrayOf(json, "K");
  if (matrix == nullptr) {
    return absl::InvalidArgumentError(absl::StrCat(where, ": has no \"K\""));
  }
  TL_RETURN_IF_ERROR(NumbersOf(*matrix, "K", where, k));
  const Json* const poses = ArrayOf(json, "poses");
  if (poses == nullptr || poses->empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        where,
        ": has no \"poses\"; record with the LiDAR camera: videos of the "
        "selfie camera have none"));
  }
  Record3dMetadata metadata;
  if (json.contains("dw") && json.contains("dh")) {
    image::ImageSize& depth = metadata.depth_size.emplace();
    TL_ASSIGN_OR_RETURN(depth.width, SideOf(json, "dw", where));
    TL_ASSIGN_OR_RETURN(depth.height, SideOf(json, "dh", where));
  }
  const Json* const own = ArrayOf(json, "perFrameIntrinsicCoeffs");
  for (size_t i = 0; i < poses->size(); ++i) {
    const std::string name = absl::StrCat("poses[", i, "]");
    std::array<double, 7> p{};
    if (!NumbersOf((*poses)[i], "poses", where, p).ok()) {
      metadata.left_out.Add("the pose is no array of 7 finite numbers", name);
      continue;
    }
    const auto pose = geometry::RigidFromQuaternion(p[3], p[0], p[1], p[2],
                                                    {p[4], p[5], p[6]});
    if (!pose.ok()) {
      metadata.left_out.Add("the quaternion is not of unit length", name);
      continue;
    }
    std::array<double, 4> c{k[0], k[4], k[6], k[7]};
    if (own != nullptr && i < own->size()) {
      TL_RETURN_IF_ERROR(
          NumbersOf((*own)[i], "perFrameIntrinsicCoeffs", where, c));
    }
    const auto camera = PinholeFromCorner(size, c[0], c[1], c[2], c[3]);
    if (!camera.ok()) {
      metadata.left_out.Add("its camera is none", name);
      continue;
    }
    metadata.frames.push_back(
        {static_cast<int>(i), *camera, FromOpenGlCamera(*pose)});
  }
  return metadata;
}

absl::StatusOr<image::DepthImage> DecodeRecord3dDepth(absl::string_view file,
                                                      image::ImageSize size) {
  const size_t pixels =
      static_cast<size_t>(size.width) * static_cast<size_t>(size.height);
  if (4 * pixels > ZipArchive::kMaxEntryBytes) {
    return absl::InvalidArgumentError("the depth map is too large");
  }
  TL_ASSIGN_OR_RETURN(const std::vector<uint8_t> bytes,
                      DecodeLzfse(file, 4 * pixels));
  image::DepthImage depth{size.width, size.height, {}, 0.001};
  depth.values.reserve(pixels);
  for (size_t i = 0; i < bytes.size(); i += 4) {
    const uint32_t bits = uint32_t{bytes[i]} | uint32_t{bytes[i + 1]} << 8 |
                          uint32_t{bytes[i + 2]} << 16 |
                          uint32_t{bytes[i + 3]} << 24;
    depth.values.push_back(image::MillimetresOf(std::bit_cast<float>(bits)));
  }
  return depth;
}

bool IsRecord3d(const std::string& path) {
  return (absl::EndsWith(path, ".r3d") && base::IsFile(path)) ||
         (base::IsFile(path + "/metadata") &&
          base::IsFile(path + "/rgbd/0.jpg"));
}

absl::StatusOr<Capture> OpenRecord3d(const std::string& path,
                                     const OpenOptions& options) {
  TL_ASSIGN_OR_RETURN(Parts parts, PartsOf(path));
  TL_ASSIGN_OR_RETURN(const std::string text, parts.read("metadata"));
  TL_ASSIGN_OR_RETURN(
      Record3dMetadata metadata,
      ParseRecord3dMetadata(text, absl::StrCat(path, ": metadata")));
  TL_ASSIGN_OR_RETURN(const geometry::Rotation3 z_up, ZUpFrom(options.up, "y"));
  Capture capture;
  capture.format = "record3d";
  capture.left_out = std::move(metadata.left_out);
  capture.notes = {
      "world turned from y up, and camera axes from OpenGL's (y up, z "
      "backwards); principal point half a pixel less",
      "up is where the top of the first picture is: the world is level if the "
      "phone was when the recording began"};
  if (!metadata.depth_size) {
    capture.notes.push_back("no depth: the metadata have no dw and dh");
  }
  std::vector<int> numbers;
  for (const Record3dFrame& frame : metadata.frames) {
    const std::string name = absl::StrCat("rgbd/", frame.number, ".jpg");
    if (!parts.has(name)) {
      capture.left_out.Add("there is no picture of this number", name);
      continue;
    }
    capture.frames.push_back(
        {name, frame.camera, Rotated(z_up, frame.world_from_camera)});
    numbers.push_back(frame.number);
  }
  capture.pictures = std::make_unique<Record3dPictures>(
      std::move(parts), std::move(numbers), metadata.depth_size,
      options.min_confidence);
  return capture;
}

}  // namespace treeline::capture
