#include "common/dataset/sfm_datasets.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/dataset/colmap.h"
#include "common/dataset/dataset_index.h"
#include "common/dataset/nvm.h"
#include "common/dataset/picture_files.h"
#include "common/image/decode.h"

namespace treeline::dataset {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kMaxNvmBytes = uint64_t{4} << 30;
constexpr uint64_t kMaxUnitsBytes = 1 << 10;

// The picture of an image: by its name, or by that with the other ending,
// since pictures are often converted after a model was computed from them.
std::optional<std::string> FindPicture(const std::string& folder,
                                       const std::string& name) {
  const std::string path = absl::StrCat(folder, "/", name);
  if (base::IsFile(path)) return path;
  const std::string base = path.substr(0, path.rfind('.'));
  for (const char* ending : {".jpg", ".png", ".jpeg", ".JPG", ".PNG"}) {
    if (base::IsFile(base + ending)) return base + ending;
  }
  return std::nullopt;
}

// One picture of hundreds is lost easily; where most are, it is the wrong
// folder.
constexpr double kMaxMissingShare = 0.5;

// Takes images whose pictures are not in `folder` out of `selected`, as indices
// into `images`. NOT_FOUND: more than half are missing.
template <typename Images>
absl::StatusOr<Dataset::MissingPictures> DropMissing(
    const std::string& folder, const Images& images,
    std::vector<int32_t>& selected) {
  Dataset::MissingPictures missing;
  const size_t before = selected.size();
  std::erase_if(selected, [&](int32_t i) {
    const std::string& name = images[static_cast<size_t>(i)].name;
    if (FindPicture(folder, name)) return false;
    if (missing.count++ == 0) missing.first = name;
    return true;
  });
  if (static_cast<double>(missing.count) <=
      kMaxMissingShare * static_cast<double>(before)) {
    return missing;
  }
  return absl::NotFoundError(
      absl::StrCat(missing.count, " of ", before,
                   " pictures of the model's images are not "
                   "in ",
                   folder, ", the first: ", missing.first,
                   "; is it the folder that the model was made of?"));
}

// Whether a model is in metres, which its folder's units.txt says: structure
// from motion itself knows no unit.
absl::StatusOr<bool> IsInMetres(const std::string& folder) {
  const std::string path = folder + "/units.txt";
  if (!base::IsFile(path)) return false;
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(path, kMaxUnitsBytes));
  if (absl::StripAsciiWhitespace(text) == "metres") return true;
  return absl::InvalidArgumentError(absl::StrCat(
      path, ": the unit of the model must be metres, or the file missing"));
}

// The images to read, as indices into `images`: those of the list, or all by
// name.
template <typename Images>
absl::StatusOr<std::vector<int32_t>> SelectImages(const IndexRequest& request,
                                                  const Images& images,
                                                  const std::string& where) {
  std::vector<std::string> names;
  for (const auto& image : images) names.push_back(image.name);
  TL_ASSIGN_OR_RETURN(std::vector<int32_t> selected,
                      SelectFrames(request, names, where));
  if (request.stems.empty()) {
    std::ranges::sort(selected, {},
                      [&](int32_t i) { return names[static_cast<size_t>(i)]; });
  }
  return selected;
}

absl::StatusOr<DatasetIndex> IndexOf(std::shared_ptr<const SfmModel> model,
                                     const std::vector<int32_t>& selected,
                                     Dataset::MissingPictures missing,
                                     const std::string& folder) {
  DatasetIndex index;
  index.missing_pictures = std::move(missing);
  index.units_are_metres = false;
  for (const int32_t i : selected) {
    const SfmModel::Image& image = model->images[static_cast<size_t>(i)];
    DatasetFrame frame;
    frame.stem = image.name;
    const std::optional<std::string> path = FindPicture(folder, image.name);
    if (!path) continue;  // it has gone since it was looked for
    frame.color_path = *path;
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
  index.cameras = calibration;
  index.structure = std::move(model);
  return index;
}

}  // namespace

absl::StatusOr<DatasetIndex> IndexColmap(const IndexRequest& request) {
  std::optional<camera::Camera> camera;
  if (!request.color_camera.empty()) {
    // The size is that of the first picture there is.
    TL_ASSIGN_OR_RETURN(const SfmModel named,
                        ReadColmap(request.path, camera::Camera()));
    TL_ASSIGN_OR_RETURN(const std::vector<int32_t> selected,
                        SelectImages(request, named.images, request.path));
    for (const int32_t i : selected) {
      const std::optional<std::string> path = FindPicture(
          request.image_folder, named.images[static_cast<size_t>(i)].name);
      if (!path) continue;
      TL_ASSIGN_OR_RETURN(const image::ImageSize size, ReadPictureSize(*path));
      TL_ASSIGN_OR_RETURN(
          camera,
          camera::Camera::Parse(request.color_camera, size.width, size.height));
      break;
    }
  }
  TL_ASSIGN_OR_RETURN(SfmModel model, ReadColmap(request.path, camera));
  auto shared = std::make_shared<const SfmModel>(std::move(model));
  TL_ASSIGN_OR_RETURN(std::vector<int32_t> selected,
                      SelectImages(request, shared->images, request.path));
  TL_ASSIGN_OR_RETURN(
      Dataset::MissingPictures missing,
      DropMissing(request.image_folder, shared->images, selected));
  TL_ASSIGN_OR_RETURN(DatasetIndex index,
                      IndexOf(std::move(shared), selected, std::move(missing),
                              request.image_folder));
  TL_ASSIGN_OR_RETURN(index.units_are_metres, IsInMetres(request.path));
  return index;
}

absl::StatusOr<DatasetIndex> IndexNvm(const IndexRequest& request) {
  const std::string& file = request.path;
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(file, kMaxNvmBytes));
  TL_ASSIGN_OR_RETURN(const NvmModel nvm, ParseNvm(text, file));
  TL_ASSIGN_OR_RETURN(std::vector<int32_t> selected,
                      SelectImages(request, nvm.images, file));
  std::string folder = fs::path(file).parent_path().string();
  if (folder.empty()) folder = ".";
  TL_ASSIGN_OR_RETURN(Dataset::MissingPictures missing,
                      DropMissing(folder, nvm.images, selected));
  // Pictures that were not selected need not be there.
  std::vector<image::ImageSize> sizes(nvm.images.size(), {1, 1});
  for (const int32_t i : selected) {
    const size_t image = static_cast<size_t>(i);
    const std::optional<std::string> path =
        FindPicture(folder, nvm.images[image].name);
    if (!path) continue;
    TL_ASSIGN_OR_RETURN(const image::ImageSize size, ReadPictureSize(*path));
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
                 std::move(missing), folder);
}

}  // namespace treeline::dataset
