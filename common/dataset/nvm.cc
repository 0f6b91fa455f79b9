#include "common/dataset/nvm.h"

#include <algorithm>
#include <array>
#include <unordered_map>
#include <utility>

#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"
#include "common/dataset/text_lines.h"

namespace treeline::dataset {
namespace {

// The least characters that a line of each kind takes.
constexpr size_t kImageChars = 22;
constexpr size_t kPointChars = 14;

class NvmParser {
 public:
  NvmParser(absl::string_view text, const std::string& file)
      : text_(text), file_(file) {}

  absl::StatusOr<NvmModel> Parse() {
    TL_RETURN_IF_ERROR(ParseHeader());
    size_t images = 0;
    TL_RETURN_IF_ERROR(ParseCount("images", kImageChars, images));
    for (size_t i = 0; i < images; ++i) TL_RETURN_IF_ERROR(ParseImage());
    size_t points = 0;
    TL_RETURN_IF_ERROR(ParseCount("points", kPointChars, points));
    for (size_t i = 0; i < points; ++i) TL_RETURN_IF_ERROR(ParsePoint());
    return std::move(model_);
  }

 private:
  absl::Status Error(absl::string_view what) const {
    return LineError(file_, line_, what);
  }

  // The words of the next line that has some.
  absl::Status NextLine() {
    words_.clear();
    while (words_.empty()) {
      if (at_ >= text_.size()) return Error("the file ends here");
      const size_t end = std::min(text_.find('\n', at_), text_.size());
      words_ = absl::StrSplit(text_.substr(at_, end - at_),
                              absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
      at_ = end + 1;
      ++line_;
    }
    return absl::OkStatus();
  }

  absl::Status Numbers(size_t first, std::span<double> numbers) const {
    if (words_.size() < first + numbers.size()) {
      return Error(absl::StrCat("expected ", first + numbers.size(),
                                " words, found ", words_.size()));
    }
    return ParseNumbers(std::span(words_).subspan(first), file_, line_,
                        numbers);
  }

  absl::Status Whole(size_t word, int32_t& value) const {
    if (absl::SimpleAtoi(words_[word], &value) && value >= 0) {
      return absl::OkStatus();
    }
    return Error(absl::StrCat("'", absl::CHexEscape(words_[word].substr(0, 64)),
                              "' is not a count or an index"));
  }

  absl::Status ParseCount(const char* what, size_t chars, size_t& count) {
    TL_RETURN_IF_ERROR(NextLine());
    int32_t value = 0;
    TL_RETURN_IF_ERROR(Whole(0, value));
    if (words_.size() != 1) {
      return Error(absl::StrCat("expected the number of ", what, " alone"));
    }
    count = static_cast<size_t>(value);
    const size_t left = text_.size() - std::min(at_, text_.size());
    if (count > left / chars + 1) {
      return Error(absl::StrCat(
          count, " ", what, " do not fit into the remaining ", left, " bytes"));
    }
    return absl::OkStatus();
  }

  absl::Status ParseHeader() {
    TL_RETURN_IF_ERROR(NextLine());
    if (words_[0] != "NVM_V3") {
      return Error(
          "expected NVM_V3: not a model of VisualSFM, or of an old "
          "version");
    }
    if (words_.size() < 2 || words_[1] != "FixedK") return absl::OkStatus();
    std::array<double, 4> k{};
    TL_RETURN_IF_ERROR(Numbers(2, k));
    model_.fixed_k = {k[0], k[1], k[2], k[3]};
    return absl::OkStatus();
  }

  // NAME FOCAL QW QX QY QZ CX CY CZ RADIAL 0: rotation from world to camera,
  // and the camera's centre.
  absl::Status ParseImage() {
    TL_RETURN_IF_ERROR(NextLine());
    std::array<double, 9> n{};
    TL_RETURN_IF_ERROR(Numbers(1, n));
    NvmModel::Image image;
    // VisualSFM writes spaces as quotation marks, and on Windows backslashes.
    image.name = absl::StrReplaceAll(words_[0], {{"\"", " "}, {"\\", "/"}});
    if (LeadsOutside(image.name) ||
        absl::StrContains(image.name, absl::string_view("\0", 1))) {
      return Error(absl::StrCat("'", absl::CHexEscape(image.name),
                                "' leads out of the folder of the model"));
    }
    if (!line_of_name_.emplace(image.name, line_).second) {
      return Error(absl::StrCat("'", image.name, "' was already in line ",
                                line_of_name_[image.name]));
    }
    image.focal_px = n[0];
    if (!(image.focal_px > 0)) {
      return Error(
          absl::StrCat("focal length ", image.focal_px, " px is not positive"));
    }
    const absl::StatusOr<geometry::Rigid3> turned =
        geometry::RigidFromQuaternion(n[1], n[2], n[3], n[4], {});
    if (!turned.ok()) return Error(turned.status().message());
    image.camera_from_world =
        *turned * geometry::Rigid3{{}, -geometry::Vec3{n[5], n[6], n[7]}};
    image.radial = n[8];
    model_.images.push_back(std::move(image));
    return absl::OkStatus();
  }

  // X Y Z R G B COUNT, and IMAGE FEATURE X Y for each measurement.
  absl::Status ParsePoint() {
    TL_RETURN_IF_ERROR(NextLine());
    std::array<double, 3> position{};
    TL_RETURN_IF_ERROR(Numbers(0, position));
    int32_t count = 0;
    if (words_.size() < 7) return Error("expected X Y Z R G B COUNT");
    TL_RETURN_IF_ERROR(Whole(6, count));
    if (words_.size() != 7 + 4 * static_cast<size_t>(count)) {
      return Error(absl::StrCat(count, " measurements are ",
                                7 + 4 * static_cast<size_t>(count),
                                " words, found ", words_.size()));
    }
    const int32_t point = static_cast<int32_t>(model_.points.size());
    model_.points.push_back({position[0], position[1], position[2]});
    for (size_t word = 7; word < words_.size(); word += 4) {
      NvmModel::Measurement measurement{.image = 0, .point = point};
      TL_RETURN_IF_ERROR(Whole(word, measurement.image));
      if (static_cast<size_t>(measurement.image) >= model_.images.size()) {
        return Error(absl::StrCat("there is no image ", measurement.image));
      }
      std::array<double, 2> at{};
      TL_RETURN_IF_ERROR(Numbers(word + 2, at));
      measurement.x = at[0];
      measurement.y = at[1];
      model_.measurements.push_back(measurement);
    }
    return absl::OkStatus();
  }

  const absl::string_view text_;
  const std::string& file_;
  size_t at_ = 0;
  int line_ = 0;
  std::vector<absl::string_view> words_;  // of the line read last
  std::unordered_map<std::string, int> line_of_name_;
  NvmModel model_;
};

// With n the measurement over f and u = n (1 + r |n|^2) the ray,
// n = u (1 - r |u|^2 + 3 r^2 |u|^4 - 12 r^3 |u|^6 + ...).
absl::StatusOr<camera::Camera> CameraOf(const NvmModel& nvm,
                                        const NvmModel::Image& image,
                                        image::ImageSize size,
                                        camera::Pixel center) {
  const double fx = nvm.fixed_k ? nvm.fixed_k->fx : image.focal_px;
  const double fy = nvm.fixed_k ? nvm.fixed_k->fy : image.focal_px;
  if (image.radial == 0) {
    const double pinhole[] = {fx, fy, center.x, center.y};
    return camera::Camera::Create(camera::CameraModel::kPinhole, size.width,
                                  size.height, pinhole, 4);
  }
  const double r = image.radial;
  const double full[] = {fx, fy, center.x,        center.y, -r, 3 * r * r,
                         0,  0,  -12 * r * r * r, 0,        0,  0};
  return camera::Camera::Create(camera::CameraModel::kFullOpenCv, size.width,
                                size.height, full, 12);
}

}  // namespace

absl::StatusOr<NvmModel> ParseNvm(absl::string_view text,
                                  const std::string& file) {
  return NvmParser(text, file).Parse();
}

absl::StatusOr<SfmModel> ToSfmModel(const NvmModel& nvm,
                                    std::span<const image::ImageSize> sizes,
                                    const std::string& file) {
  SfmModel model;
  for (size_t i = 0; i < nvm.images.size(); ++i) {
    // SiftGPU, too, has the centre of the top left pixel at (0.5, 0.5).
    const camera::Pixel center =
        nvm.fixed_k
            ? camera::Pixel{nvm.fixed_k->cx - 0.5, nvm.fixed_k->cy - 0.5}
            : camera::Pixel{0.5 * sizes[i].width - 0.5,
                            0.5 * sizes[i].height - 0.5};
    const absl::StatusOr<camera::Camera> camera =
        CameraOf(nvm, nvm.images[i], sizes[i], center);
    if (!camera.ok()) {
      return base::Annotate(
          camera.status(),
          absl::StrCat(file, ": image '", nvm.images[i].name, "'"));
    }
    model.cameras.push_back(*camera);
    model.images.push_back(
        {.name = nvm.images[i].name,
         .camera = static_cast<int32_t>(i),
         .camera_from_world = nvm.images[i].camera_from_world,
         .keypoints = {}});
  }
  for (const geometry::Vec3& point : nvm.points)
    model.points.push_back({point, 0});
  for (const NvmModel::Measurement& seen : nvm.measurements) {
    const size_t i = static_cast<size_t>(seen.image);
    const camera::Camera& camera = model.cameras[i];
    model.images[i].keypoints.push_back(
        {{camera.cx() + seen.x, camera.cy() + seen.y}, seen.point});
    ++model.points[static_cast<size_t>(seen.point)].track_length;
  }
  return model;
}

}  // namespace treeline::dataset
