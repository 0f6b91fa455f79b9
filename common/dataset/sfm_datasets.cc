#include "common/dataset/sfm_datasets.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <unordered_map>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "common/dataset/colmap.h"
#include "common/dataset/dataset_index.h"
#include "common/dataset/nvm.h"
#include "common/image/decode.h"

namespace treeline::dataset {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxNvmBytes = uint64_t{4} << 30;
constexpr uint64_t kMaxImageBytes = 128u << 20;

bool IsFile(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

// The picture of an image: by its name, or by that with the other ending,
// since pictures are often converted after a model was computed from them.
std::optional<std::string> FindPicture(const std::string& folder,
                                       const std::string& name) {
  const std::string path = absl::StrCat(folder, "/", name);
  if (IsFile(path)) return path;
  const std::string base = path.substr(0, path.rfind('.'));
  for (const char* ending : {".jpg", ".png", ".jpeg", ".JPG", ".PNG"}) {
    if (IsFile(base + ending)) return base + ending;
  }
  return std::nullopt;
}

absl::StatusOr<std::string> PictureOf(const std::string& folder,
                                      const std::string& name) {
  std::optional<std::string> path = FindPicture(folder, name);
  if (path) return *std::move(path);
  return absl::NotFoundError(absl::StrCat("there is no picture ", folder, "/",
                                          name, " of an image of the model"));
}

absl::StatusOr<image::ImageSize> ReadSizeOf(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string bytes,
                      base::ReadFile(path, kMaxImageBytes));
  const absl::StatusOr<image::ImageSize> size = image::ReadImageSize(bytes);
  if (!size.ok()) return base::Annotate(size.status(), path);
  return size;
}

// The images to read, as indices into `names`: those of the list, or all by
// name.
absl::StatusOr<std::vector<int32_t>> SelectImages(
    const IndexRequest& request, const std::vector<std::string>& names,
    const std::string& where) {
  std::vector<int32_t> selected;
  if (request.stems.empty()) {
    for (size_t i = 0; i < names.size(); ++i) {
      selected.push_back(static_cast<int32_t>(i));
    }
    std::ranges::sort(selected, {},
                      [&](int32_t i) { return names[static_cast<size_t>(i)]; });
    return selected;
  }
  std::unordered_map<std::string, int32_t> index_of;
  for (size_t i = 0; i < names.size(); ++i) {
    index_of[names[i]] = static_cast<int32_t>(i);
  }
  for (const ListedStem& listed : request.stems) {
    const auto found = index_of.find(listed.stem);
    if (found == index_of.end()) return StemNotFound(request, listed, where);
    selected.push_back(found->second);
  }
  return selected;
}

template <typename Images>
std::vector<std::string> NamesOf(const Images& images) {
  std::vector<std::string> names;
  for (const auto& image : images) names.push_back(image.name);
  return names;
}

absl::StatusOr<DatasetIndex> IndexOf(std::shared_ptr<const SfmModel> model,
                                     const std::vector<int32_t>& selected,
                                     const std::string& folder) {
  DatasetIndex index;
  index.units_are_metres = false;
  for (const int32_t i : selected) {
    const SfmModel::Image& image = model->images[static_cast<size_t>(i)];
    DatasetFrame frame;
    frame.stem = image.name;
    TL_ASSIGN_OR_RETURN(frame.color_path, PictureOf(folder, image.name));
    frame.world_from_camera = image.camera_from_world.Inverse();
    frame.color_camera = model->cameras[static_cast<size_t>(image.camera)];
    frame.structure_image = i;
    index.frames.push_back(std::move(frame));
  }
  if (index.frames.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat("the model with images in ", folder, " has no images"));
  }
  camera::RgbdCalibration calibration;
  calibration.color = calibration.depth = *index.frames[0].color_camera;
  index.calibration = calibration;
  index.structure = std::move(model);
  return index;
}

}  // namespace

absl::StatusOr<DatasetIndex> IndexColmap(const IndexRequest& request) {
  std::optional<camera::Camera> camera;
  if (!request.color_camera.empty()) {
    // The size is that of the first picture there is.
    TL_ASSIGN_OR_RETURN(const SfmModel named,
                        ReadColmap(request.folder, camera::Camera()));
    TL_ASSIGN_OR_RETURN(
        const std::vector<int32_t> selected,
        SelectImages(request, NamesOf(named.images), request.folder));
    if (!selected.empty()) {
      TL_ASSIGN_OR_RETURN(
          const std::string path,
          PictureOf(request.images,
                    named.images[static_cast<size_t>(selected.front())].name));
      TL_ASSIGN_OR_RETURN(const image::ImageSize size, ReadSizeOf(path));
      TL_ASSIGN_OR_RETURN(
          camera,
          camera::Camera::Parse(request.color_camera, size.width, size.height));
    }
  }
  TL_ASSIGN_OR_RETURN(SfmModel model, ReadColmap(request.folder, camera));
  auto shared = std::make_shared<const SfmModel>(std::move(model));
  TL_ASSIGN_OR_RETURN(
      const std::vector<int32_t> selected,
      SelectImages(request, NamesOf(shared->images), request.folder));
  return IndexOf(std::move(shared), selected, request.images);
}

absl::StatusOr<DatasetIndex> IndexNvm(const IndexRequest& request) {
  const std::string& file = request.folder;
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(file, kMaxNvmBytes));
  TL_ASSIGN_OR_RETURN(const NvmModel nvm, ParseNvm(text, file));
  TL_ASSIGN_OR_RETURN(const std::vector<int32_t> selected,
                      SelectImages(request, NamesOf(nvm.images), file));
  std::string folder = fs::path(file).parent_path().string();
  if (folder.empty()) folder = ".";
  // Pictures that were not selected need not be there.
  std::vector<image::ImageSize> sizes(nvm.images.size(), {1, 1});
  for (const int32_t i : selected) {
    const size_t image = static_cast<size_t>(i);
    TL_ASSIGN_OR_RETURN(const std::string path,
                        PictureOf(folder, nvm.images[image].name));
    TL_ASSIGN_OR_RETURN(const image::ImageSize size, ReadSizeOf(path));
    sizes[image] = {size.width, size.height};
  }
  TL_ASSIGN_OR_RETURN(SfmModel model, ToSfmModel(nvm, sizes, file));
  if (!request.color_camera.empty()) {
    for (size_t i = 0; i < model.cameras.size(); ++i) {
      TL_ASSIGN_OR_RETURN(
          model.cameras[i],
          camera::Camera::Parse(request.color_camera, sizes[i].width,
                                sizes[i].height));
    }
  }
  return IndexOf(std::make_shared<const SfmModel>(std::move(model)), selected,
                 folder);
}

}  // namespace treeline::dataset
