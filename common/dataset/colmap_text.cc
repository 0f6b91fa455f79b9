#include "common/dataset/colmap_text.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"
#include "common/dataset/colmap_builder.h"
#include "common/dataset/text_lines.h"

namespace treeline::dataset {
namespace {

using Words = std::vector<absl::string_view>;

Words SplitWords(absl::string_view line) {
  return absl::StrSplit(line, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
}

// Hands out the lines of a file, counted from 1.
class LineReader {
 public:
  explicit LineReader(const ColmapFile& file) : file_(file) {}

  // The next line as it is; false at the end.
  bool Next(absl::string_view& line) {
    const absl::string_view text = file_.bytes;
    if (at_ >= text.size()) return false;
    const size_t end = std::min(text.find('\n', at_), text.size());
    line = text.substr(at_, end - at_);
    at_ = end + 1;
    ++number_;
    return true;
  }
  // The next line that is neither empty nor a comment.
  bool NextRecord(absl::string_view& line) {
    while (Next(line)) {
      const absl::string_view content = absl::StripAsciiWhitespace(line);
      if (!content.empty() && content[0] != '#') return true;
    }
    return false;
  }
  ColmapPlace place() const { return {&file_, number_}; }
  absl::Status Numbers(std::span<const absl::string_view> words,
                       std::span<double> numbers) const {
    return ParseNumbers(words, file_.path, static_cast<int>(number_), numbers);
  }

 private:
  const ColmapFile& file_;
  size_t at_ = 0;
  uint64_t number_ = 0;
};

template <typename Integer>
absl::Status ParseWhole(const ColmapPlace& place, absl::string_view word,
                        Integer& value) {
  if (absl::SimpleAtoi(word, &value)) return absl::OkStatus();
  return place.Error(absl::StrCat("'", absl::CHexEscape(word.substr(0, 64)),
                                  "' is not a whole number of this range"));
}

absl::Status ParsePointId(const ColmapPlace& place, absl::string_view word,
                          uint64_t& id) {
  id = ColmapBuilder::kNoPoint;
  if (word == "-1") return absl::OkStatus();
  return ParseWhole(place, word, id);
}

// "X Y POINT3D_ID" again and again; -1 is no point.
absl::Status ParseObservations(
    const LineReader& reader, absl::string_view line,
    std::vector<ColmapBuilder::Observation>& observations) {
  const Words words = SplitWords(line);
  if (words.size() % 3 != 0) {
    return reader.place().Error(
        absl::StrCat("expected 'X Y POINT3D_ID' for each keypoint, found ",
                     words.size(), " words"));
  }
  observations.resize(words.size() / 3);
  for (size_t i = 0; i < observations.size(); ++i) {
    std::array<double, 2> at{};
    TL_RETURN_IF_ERROR(reader.Numbers(std::span(words).subspan(3 * i, 2), at));
    observations[i].x = at[0];
    observations[i].y = at[1];
    TL_RETURN_IF_ERROR(ParsePointId(reader.place(), words[3 * i + 2],
                                    observations[i].point_id));
  }
  return absl::OkStatus();
}

// What follows the first nine words of an image's line: names may have spaces.
absl::string_view NameOf(absl::string_view line) {
  for (int word = 0; word < 9; ++word) {
    line = absl::StripLeadingAsciiWhitespace(line);
    line.remove_prefix(std::min(line.find_first_of(" \t"), line.size()));
  }
  return absl::StripAsciiWhitespace(line);
}

}  // namespace

absl::Status ReadCamerasText(const ColmapFile& file, ColmapBuilder& builder) {
  LineReader reader(file);
  absl::string_view line;
  while (reader.NextRecord(line)) {
    const ColmapPlace place = reader.place();
    const Words words = SplitWords(line);
    if (words.size() < 5) {
      return place.Error(
          absl::StrCat("expected 'CAMERA_ID MODEL WIDTH HEIGHT PARAMS', found ",
                       words.size(), " words"));
    }
    uint32_t id = 0;
    uint64_t width = 0;
    uint64_t height = 0;
    TL_RETURN_IF_ERROR(ParseWhole(place, words[0], id));
    const absl::StatusOr<camera::CameraModel> model =
        camera::ParseCameraModel(absl::CHexEscape(words[1].substr(0, 64)));
    if (!model.ok()) return place.Error(model.status().message());
    TL_RETURN_IF_ERROR(ParseWhole(place, words[2], width));
    TL_RETURN_IF_ERROR(ParseWhole(place, words[3], height));
    std::vector<double> parameters(words.size() - 4);
    TL_RETURN_IF_ERROR(reader.Numbers(std::span(words).subspan(4), parameters));
    TL_RETURN_IF_ERROR(
        builder.AddCamera(place, id, *model, width, height, parameters));
  }
  return absl::OkStatus();
}

absl::Status ReadImagesText(const ColmapFile& file, ColmapBuilder& builder) {
  LineReader reader(file);
  absl::string_view line;
  std::vector<ColmapBuilder::Observation> observations;
  while (reader.NextRecord(line)) {
    const ColmapPlace place = reader.place();
    const Words words = SplitWords(line);
    if (words.size() < 10) {
      return place.Error(absl::StrCat(
          "expected 'IMAGE_ID QW QX QY QZ TX TY TZ CAMERA_ID NAME', found ",
          words.size(), " words"));
    }
    uint32_t id = 0;
    uint32_t camera_id = 0;
    std::array<double, 7> pose{};
    TL_RETURN_IF_ERROR(ParseWhole(place, words[0], id));
    TL_RETURN_IF_ERROR(reader.Numbers(std::span(words).subspan(1), pose));
    TL_RETURN_IF_ERROR(ParseWhole(place, words[8], camera_id));
    const absl::string_view name = NameOf(line);
    // The line of keypoints always follows, and may be empty.
    observations.clear();
    if (reader.Next(line)) {
      TL_RETURN_IF_ERROR(ParseObservations(reader, line, observations));
    }
    TL_RETURN_IF_ERROR(
        builder.AddImage(place, id, pose, camera_id, name, observations));
  }
  return absl::OkStatus();
}

absl::Status ReadPointsText(const ColmapFile& file, ColmapBuilder& builder) {
  LineReader reader(file);
  absl::string_view line;
  std::vector<ColmapBuilder::TrackElement> track;
  while (reader.NextRecord(line)) {
    const ColmapPlace place = reader.place();
    const Words words = SplitWords(line);
    if (words.size() < 8 || words.size() % 2 != 0) {
      return place.Error(absl::StrCat(
          "expected 'POINT3D_ID X Y Z R G B ERROR' and pairs 'IMAGE_ID "
          "POINT2D_IDX', found ",
          words.size(), " words"));
    }
    uint64_t id = 0;
    std::array<double, 3> position{};
    TL_RETURN_IF_ERROR(ParseWhole(place, words[0], id));
    TL_RETURN_IF_ERROR(reader.Numbers(std::span(words).subspan(1), position));
    track.resize((words.size() - 8) / 2);
    for (size_t i = 0; i < track.size(); ++i) {
      TL_RETURN_IF_ERROR(
          ParseWhole(place, words[8 + 2 * i], track[i].image_id));
      TL_RETURN_IF_ERROR(
          ParseWhole(place, words[9 + 2 * i], track[i].keypoint));
    }
    TL_RETURN_IF_ERROR(builder.AddPoint(
        place, id, {position[0], position[1], position[2]}, track));
  }
  return absl::OkStatus();
}

}  // namespace treeline::dataset
