#include "server/tools/photographs/photographs.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <system_error>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/child_process.h"
#include "common/base/file.h"
#include "common/base/folder.h"
#include "common/base/status_macros.h"
#include "common/image/exif.h"
#include "common/image/quarter_turn.h"
#include "server/tools/capture/picture_files.h"
#include "server/tools/capture/video_reader.h"
#include "server/tools/photographs/heic.h"

namespace treeline::photographs {
namespace {

// Fewer make no structure that is worth its name.
constexpr size_t kFewestPhotographs = 3;
// Of a video: neighbours still overlap, and matching them takes minutes.
constexpr int kVideoFrames = 200;
constexpr int kJpegQuality = 95;
constexpr uint64_t kMaxPictureBytes = 256u << 20;

bool HasEnding(const std::string& path,
               std::initializer_list<const char*> endings) {
  const std::string lower = absl::AsciiStrToLower(path);
  return std::ranges::any_of(endings, [&](const char* ending) {
    return absl::EndsWith(lower, ending);
  });
}

std::vector<std::string> PhotographsIn(const std::string& folder) {
  std::vector<std::string> names;
  for (const std::string& name : base::SortedNamesIn(folder)) {
    if (HasEnding(name, {".jpg", ".jpeg", ".png"}) || IsHeicName(name)) {
      names.push_back(name);
    }
  }
  std::ranges::sort(names, capture::NaturalLess);
  return names;
}

image::ColorImage NotLongerThan(image::ColorImage picture, int max_side_px) {
  const int longer = std::max(picture.width, picture.height);
  if (max_side_px == 0 || longer <= max_side_px) return picture;
  const double factor = static_cast<double>(max_side_px) / longer;
  const cv::Mat large(picture.height, picture.width, CV_8UC3,
                      picture.rgb.data());
  cv::Mat small;
  cv::resize(large, small,
             {std::max(1, cvRound(factor * picture.width)),
              std::max(1, cvRound(factor * picture.height))},
             0, 0, cv::INTER_AREA);
  return {small.cols, small.rows, {small.datastart, small.dataend}};
}

// What has been written so far.
class Copier {
 public:
  Copier(std::string folder, int max_side_px)
      : folder_(std::move(folder)), max_side_px_(max_side_px) {}

  absl::Status Add(const std::string& name, image::ColorImage picture) {
    picture = NotLongerThan(std::move(picture), max_side_px_);
    const image::ImageSize size{picture.width, picture.height};
    if (size_ && !(*size_ == size)) result_.is_one_size = false;
    size_ = size;
    result_.longest_side_px =
        std::max({result_.longest_side_px, size.width, size.height});
    TL_ASSIGN_OR_RETURN(const std::string jpeg,
                        image::EncodeJpeg(picture, kJpegQuality));
    TL_RETURN_IF_ERROR(
        base::WriteNewFile(absl::StrCat(folder_, "/", name), jpeg));
    result_.names.push_back(name);
    return absl::OkStatus();
  }
  void LeaveOut(absl::string_view why) { result_.left_out.emplace_back(why); }
  CopiedPictures Take() { return std::move(result_); }

 private:
  const std::string folder_;
  const int max_side_px_;
  std::optional<image::ImageSize> size_;
  CopiedPictures result_;
};

// Upright.
absl::StatusOr<image::ColorImage> ReadPhotograph(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string bytes,
                      base::ReadFile(path, kMaxPictureBytes));
  absl::StatusOr<image::ColorImage> picture =
      image::DecodeColor(bytes, kPhotographLimits);
  if (!picture.ok()) return base::Annotate(picture.status(), path);
  return image::Turned(*picture, image::ReadExifUprightTurn(bytes).value_or(
                                     image::QuarterTurn::kNone));
}

// JPEG and PNG by ourselves, HEIC by heif-convert, where it is installed.
class PhotographReader {
 public:
  PhotographReader(const std::string& heif_convert, std::string work,
                   const std::stop_token& stop)
      : heif_convert_(base::FindProgram(heif_convert)),
        work_(std::move(work)),
        stop_(stop) {}
  ~PhotographReader() {
    std::error_code ignored;
    std::filesystem::remove_all(work_, ignored);
  }
  PhotographReader(const PhotographReader&) = delete;
  PhotographReader& operator=(const PhotographReader&) = delete;

  bool CanRead(const std::string& name) const {
    return !heif_convert_.empty() || !IsHeicName(name);
  }
  absl::StatusOr<image::ColorImage> Read(const std::string& path) const {
    return IsHeicName(path) ? ReadHeic(path, heif_convert_, work_, stop_)
                            : ReadPhotograph(path);
  }

 private:
  const std::string heif_convert_;
  const std::string work_;
  const std::stop_token& stop_;
};

std::string HeicNotice(int64_t count) {
  return absl::StrCat(
      count, count == 1 ? " picture is" : " pictures are",
      " HEIC, and there is no heif-convert to read them. On Debian 12: apt "
      "install libheif-examples. Or let the phone take JPEG: on an iPhone, "
      "Settings > Camera > Formats > Most Compatible");
}

absl::Status CopyPhotographs(const std::string& source,
                             const std::string& folder,
                             const PictureOptions& options, Copier& copier,
                             const std::function<void()>& done,
                             const std::stop_token& stop) {
  const PhotographReader reader(options.heif_convert, folder + "-heic", stop);
  int64_t unreadable = 0;
  std::string last;
  for (const std::string& name : PhotographsIn(source)) {
    if (stop.stop_requested()) return absl::CancelledError("import stopped");
    if (!reader.CanRead(name)) {
      ++unreadable;
      done();
      continue;
    }
    absl::StatusOr<image::ColorImage> picture =
        reader.Read(absl::StrCat(source, "/", name));
    if (absl::IsCancelled(picture.status())) return picture.status();
    if (picture.ok()) {
      // "a.png" and "a.jpg" are two pictures.
      const std::string stem = name.substr(0, name.rfind('.'));
      const std::string written = stem == last ? name + ".jpg" : stem + ".jpg";
      last = stem;
      TL_RETURN_IF_ERROR(copier.Add(written, *std::move(picture)));
    } else {
      copier.LeaveOut(picture.status().message());
    }
    done();
  }
  if (unreadable > 0) copier.LeaveOut(HeicNotice(unreadable));
  return absl::OkStatus();
}

absl::Status CopyFrames(const std::string& source, int every, Copier& copier,
                        const std::function<void()>& done,
                        const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<capture::VideoReader> video,
                      capture::VideoReader::Open(source));
  for (int frame = 0;; frame += every) {
    if (stop.stop_requested()) return absl::CancelledError("import stopped");
    absl::StatusOr<image::ColorImage> picture = video->Read(frame);
    if (absl::IsDataLoss(picture.status())) {
      // Every video ends; what it says of its length is a guess.
      if (frame == 0) return picture.status();
      return absl::OkStatus();
    }
    TL_RETURN_IF_ERROR(picture.status());
    TL_RETURN_IF_ERROR(copier.Add(absl::StrFormat("frame-%06d.jpg", frame),
                                  image::Turned(*picture, video->ShownTurn())));
    done();
  }
}

absl::StatusOr<int> Every(const std::string& source, int every) {
  if (every > 0) return every;
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<capture::VideoReader> video,
                      capture::VideoReader::Open(source));
  return std::max(1, video->FrameCount() / kVideoFrames);
}

}  // namespace

bool IsPhotographs(const std::string& path) {
  return PhotographsIn(path).size() >= kFewestPhotographs;
}

bool IsVideo(const std::string& path) {
  return base::IsFile(path) && HasEnding(path, {".mp4", ".mov", ".m4v"});
}

absl::StatusOr<int> CountPictures(const std::string& source,
                                  const PictureOptions& options) {
  if (!IsVideo(source)) {
    return std::max(1, static_cast<int>(PhotographsIn(source).size()));
  }
  TL_ASSIGN_OR_RETURN(const std::unique_ptr<capture::VideoReader> video,
                      capture::VideoReader::Open(source));
  TL_ASSIGN_OR_RETURN(const int every, Every(source, options.every));
  return std::max(1, video->FrameCount() / every);
}

absl::StatusOr<CopiedPictures> CopyPictures(const std::string& source,
                                            const std::string& folder,
                                            const PictureOptions& options,
                                            const std::function<void()>& done,
                                            const std::stop_token& stop) {
  Copier copier(folder, options.max_side_px);
  if (IsVideo(source)) {
    TL_ASSIGN_OR_RETURN(const int every, Every(source, options.every));
    TL_RETURN_IF_ERROR(CopyFrames(source, every, copier, done, stop));
  } else {
    TL_RETURN_IF_ERROR(
        CopyPhotographs(source, folder, options, copier, done, stop));
  }
  return copier.Take();
}

}  // namespace treeline::photographs
