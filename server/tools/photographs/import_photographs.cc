#include "server/tools/photographs/import_photographs.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>
#include <system_error>
#include <utility>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/file.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "common/dataset/frame_use.h"
#include "server/tools/output_folder.h"
#include "server/tools/photographs/structure_from_motion.h"

namespace treeline::photographs {
namespace {

namespace fs = std::filesystem;

// A structure of fewer is of a corner of the place.
constexpr double kFewestShare = 0.3;
constexpr int kFewestRegistered = 8;
constexpr double kFullShare = 0.9;  // from here on, nothing is said
// Photographs are further apart than frames of a video: single ones are held
// out.
constexpr int kHeldOutPeriod = 5;

struct KnownDistance {
  std::string image_a;
  std::string image_b;
  double metres = 0;
};

absl::StatusOr<KnownDistance> ParseDistance(const std::string& text) {
  const std::vector<std::string> parts = absl::StrSplit(text, ',');
  KnownDistance distance;
  if (parts.size() != 3 || !absl::SimpleAtod(parts[2], &distance.metres) ||
      !(distance.metres > 0) || !std::isfinite(distance.metres)) {
    return absl::InvalidArgumentError(absl::StrCat(
        "--distance takes A.jpg,B.jpg,METRES: two pictures, and how far apart "
        "they were taken; not '",
        text, "'"));
  }
  distance.image_a = parts[0];
  distance.image_b = parts[1];
  return distance;
}

// What a picture that was given by its name in the capture is called now: all
// are JPEG files. Error: there is none.
absl::StatusOr<std::string> NameOfCopy(const std::vector<std::string>& copies,
                                       const std::string& name) {
  for (const std::string& copy :
       {name, name + ".jpg", name.substr(0, name.rfind('.')) + ".jpg"}) {
    if (std::ranges::find(copies, copy) != copies.end()) return copy;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("--distance: there is no picture ", name,
                   " among those that could be read; the first is ",
                   copies.empty() ? "none" : copies.front()));
}

class PhotographImporter {
 public:
  PhotographImporter(std::string source, const PhotographOptions& options,
                     tools::OutputFolder output, const std::stop_token& stop)
      : source_(std::move(source)),
        options_(options),
        output_(std::move(output)),
        stop_(stop) {}

  absl::StatusOr<ImportedPhotographs> Run(const std::string& colmap) {
    for (const char* folder : {"images/", "model/", "work/"}) {
      TL_RETURN_IF_ERROR(base::MakeParentFolder(output_.Path(folder)));
    }
    TL_RETURN_IF_ERROR(Copy());
    TL_RETURN_IF_ERROR(FindDistance());
    structure_options_ = {.colmap = colmap,
                          .images = output_.Path("images"),
                          .work = output_.Path("work"),
                          .pictures = result_.pictures,
                          .is_sequence = IsVideo(source_),
                          .is_one_camera = is_one_camera_,
                          .longest_side_px = longest_side_px_,
                          .quiet = options_.quiet};
    TL_ASSIGN_OR_RETURN(structure_,
                        ComputeStructure(structure_options_, stop_));
    TL_RETURN_IF_ERROR(CheckRegistered());
    TL_RETURN_IF_ERROR(WriteModel());
    TL_RETURN_IF_ERROR(WriteLists());
    std::error_code ignored;
    fs::remove_all(output_.Path("work"), ignored);
    TL_RETURN_IF_ERROR(
        base::WriteNewFile(output_.Path("recording.txt"), Description()));
    result_.uri = absl::StrCat("colmap:", output_.Path("model"), ",",
                               output_.Path("images"));
    output_.Keep();
    return std::move(result_);
  }

 private:
  absl::Status Copy() {
    TL_ASSIGN_OR_RETURN(const int total,
                        CountPictures(source_, options_.pictures));
    base::Progress progress("reading", total, options_.quiet);
    TL_ASSIGN_OR_RETURN(const CopiedPictures copied,
                        CopyPictures(
                            source_, output_.Path("images"), options_.pictures,
                            [&] { progress.Add(1); }, stop_));
    copies_ = copied.names;
    result_.pictures = static_cast<int>(copies_.size());
    is_one_camera_ = copied.is_one_size;
    longest_side_px_ = copied.longest_side_px;
    for (const std::string& why : copied.left_out) {
      result_.notes.push_back("left out: " + why);
    }
    if (!is_one_camera_) {
      result_.notes.push_back(
          "the pictures have several sizes: each is taken to be of a camera of "
          "its own");
    }
    if (result_.pictures > 0) return absl::OkStatus();
    return absl::FailedPreconditionError(absl::StrCat(
        source_, ": no picture could be read",
        copied.left_out.empty() ? "" : ". " + copied.left_out.front()));
  }

  // Before the structure, which takes minutes.
  absl::Status FindDistance() {
    if (options_.distance.empty()) return absl::OkStatus();
    TL_ASSIGN_OR_RETURN(KnownDistance known, ParseDistance(options_.distance));
    TL_ASSIGN_OR_RETURN(known.image_a, NameOfCopy(copies_, known.image_a));
    TL_ASSIGN_OR_RETURN(known.image_b, NameOfCopy(copies_, known.image_b));
    distance_ = std::move(known);
    return absl::OkStatus();
  }

  absl::Status CheckRegistered() {
    result_.registered = static_cast<int>(structure_.model.images.size());
    result_.points = static_cast<int>(structure_.model.points.size());
    const double share =
        static_cast<double>(result_.registered) / result_.pictures;
    if (result_.registered < kFewestRegistered || share < kFewestShare) {
      return absl::FailedPreconditionError(absl::StrFormat(
          "%s: COLMAP placed only %d of the %d pictures. Take more between "
          "them, so that each shows half of what the one before shows; move "
          "sideways instead of turning on the spot; avoid blur and bare walls",
          source_, result_.registered, result_.pictures));
    }
    if (share < kFullShare) {
      result_.notes.push_back(absl::StrFormat(
          "%d of the %d pictures could not be placed: what only they show is "
          "not learnt",
          result_.pictures - result_.registered, result_.pictures));
    }
    if (structure_.other_models > 0) {
      result_.notes.push_back(absl::StrFormat(
          "%d pictures make %d structures of their own: take some that show "
          "both parts",
          structure_.other_pictures, structure_.other_models));
    }
    return absl::OkStatus();
  }

  absl::Status WriteModel() {
    double scale = options_.scale;
    if (distance_) {
      TL_ASSIGN_OR_RETURN(
          scale, ScaleOfDistance(structure_.model, distance_->image_a,
                                 distance_->image_b, distance_->metres));
    }
    result_.is_metric = scale > 0;
    if (result_.is_metric) {
      result_.notes.push_back(
          absl::StrFormat("scaled by %.6g to metres, as told", scale));
      TL_RETURN_IF_ERROR(
          base::WriteNewFile(output_.Path("model/units.txt"), "metres\n"));
    } else {
      result_.notes.push_back(
          "pictures alone do not tell how large the place is: lengths are in "
          "an arbitrary unit. --distance A.jpg,B.jpg,METRES or --scale makes "
          "them metres");
    }
    return TransformModel(structure_options_, structure_.model_folder,
                          output_.Path("model"), result_.is_metric ? scale : 1,
                          UprightFromModel(structure_.model), stop_);
  }

  absl::Status WriteLists() {
    std::set<std::string> names;
    for (const dataset::SfmModel::Image& image : structure_.model.images) {
      names.insert(image.name);
    }
    std::string train;
    std::string test;
    int i = 0;
    for (const std::string& name : names) {
      const dataset::FrameUse use = UseOf(i++);
      if (use == dataset::FrameUse::kTrain) {
        ++result_.train;
        absl::StrAppend(&train, name, "\n");
      } else if (use == dataset::FrameUse::kTest) {
        ++result_.test;
        absl::StrAppend(&test, name, "\n");
      }
    }
    TL_RETURN_IF_ERROR(base::WriteNewFile(output_.Path("train.txt"), train));
    return base::WriteNewFile(output_.Path("test.txt"), test);
  }

  dataset::FrameUse UseOf(int i) const {
    if (structure_options_.is_sequence) {
      return dataset::UseOfFrame(i, result_.registered);
    }
    return i % kHeldOutPeriod == kHeldOutPeriod / 2 ? dataset::FrameUse::kTest
                                                    : dataset::FrameUse::kTrain;
  }

  std::string Description() const {
    std::string text = absl::StrFormat(
        "imported from %s\nformat %s\nframes %d\nregistered %d\npoints %d\n",
        source_, IsVideo(source_) ? "video" : "photographs", result_.pictures,
        result_.registered, result_.points);
    for (const std::string& note : result_.notes) {
      absl::StrAppend(&text, "# ", note, "\n");
    }
    return text;
  }

  const std::string source_;
  const PhotographOptions& options_;
  tools::OutputFolder output_;
  const std::stop_token& stop_;
  std::vector<std::string> copies_;
  std::optional<KnownDistance> distance_;  // between two of copies_
  bool is_one_camera_ = true;
  int longest_side_px_ = 0;
  StructureOptions structure_options_;
  Structure structure_;
  ImportedPhotographs result_;
};

}  // namespace

absl::Status PhotographOptions::Validate() const {
  if (!std::isfinite(scale) || scale < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("--scale of ", scale, " metres per unit is not positive"));
  }
  if (scale > 0 && !distance.empty()) {
    return absl::InvalidArgumentError("give --scale or --distance, not both");
  }
  if (!distance.empty()) TL_RETURN_IF_ERROR(ParseDistance(distance).status());
  return absl::OkStatus();
}

absl::StatusOr<ImportedPhotographs> ImportPhotographs(
    const std::string& source, const PhotographOptions& options,
    const std::stop_token& stop) {
  TL_RETURN_IF_ERROR(options.Validate());
  std::string trimmed = source;
  while (trimmed.size() > 1 && trimmed.back() == '/') trimmed.pop_back();
  TL_ASSIGN_OR_RETURN(const std::string colmap, FindColmap(options.colmap));
  TL_ASSIGN_OR_RETURN(tools::OutputFolder output,
                      tools::OutputFolder::Create(options.folder));
  return PhotographImporter(trimmed, options, std::move(output), stop)
      .Run(colmap);
}

}  // namespace treeline::photographs
