#include "common/dataset/text_formats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <unordered_map>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/status_macros.h"
#include "common/dataset/text_lines.h"

namespace treeline::dataset {
namespace {

constexpr Time_ns kSecond_ns = 1'000'000'000;

// The words of one line, and where it stands.
struct Line {
  std::vector<absl::string_view> words;
  int number = 0;
};

// Notepad and spreadsheets begin UTF-8 with it.
absl::string_view WithoutByteOrderMark(absl::string_view text) {
  absl::ConsumePrefix(&text, "\xef\xbb\xbf");
  return text;
}

std::vector<Line> SplitLines(absl::string_view text) {
  std::vector<Line> lines;
  int number = 0;
  for (absl::string_view raw :
       absl::StrSplit(WithoutByteOrderMark(text), '\n')) {
    ++number;
    const absl::string_view content = raw.substr(0, raw.find('#'));
    std::vector<absl::string_view> words =
        absl::StrSplit(content, absl::ByAnyChar(" \t\r"), absl::SkipEmpty());
    if (!words.empty()) lines.push_back({std::move(words), number});
  }
  return lines;
}

// A line of a frame list without blanks at its ends and its comment, which
// begins it or follows a blank: names of pictures may have both inside.
absl::string_view WithoutComment(absl::string_view line) {
  for (size_t at = line.find('#'); at != absl::string_view::npos;
       at = line.find('#', at + 1)) {
    if (at == 0 ||
        absl::ascii_isspace(static_cast<unsigned char>(line[at - 1]))) {
      line = line.substr(0, at);
      break;
    }
  }
  return absl::StripAsciiWhitespace(line);
}

// Reports a name that was there before.
class Duplicates {
 public:
  explicit Duplicates(const std::string& file) : file_(file) {}

  absl::Status Add(const std::string& name, int line) {
    const auto [entry, added] = lines_.emplace(name, line);
    if (added) return absl::OkStatus();
    return LineError(
        file_, line,
        absl::StrCat("'", name, "' was already in line ", entry->second));
  }

 private:
  const std::string& file_;
  std::unordered_map<std::string, int> lines_;
};

// "1.305031241529758e+09", as NumPy and printf write it, without its exponent:
// "1305031241.529758". Other texts stay as they are. Such a number was a
// double, which knows a time of this epoch to a quarter of a microsecond: it is
// rounded to a whole one, the finest that recordings have.
std::string WithoutExponent(absl::string_view text) {
  constexpr int kMaxExponent = 9;
  const size_t e = text.find_first_of("eE");
  double seconds = 0;
  int exponent = 0;
  if (e == absl::string_view::npos || e + 4 != text.size() ||
      (text[e + 1] != '+' && text[e + 1] != '-') ||
      !absl::SimpleAtoi(text.substr(e + 1), &exponent) ||
      exponent > kMaxExponent || !absl::SimpleAtod(text, &seconds)) {
    return std::string(text);
  }
  return absl::StrFormat("%.6f", seconds);
}

}  // namespace

absl::StatusOr<Time_ns> ParseTime_ns(absl::string_view written) {
  const std::string text_without_exponent = WithoutExponent(written);
  const absl::string_view text = text_without_exponent;
  const size_t point = std::min(text.find('.'), text.size());
  const absl::string_view seconds = text.substr(0, point);
  const absl::string_view decimals =
      point < text.size() ? text.substr(point + 1) : absl::string_view();
  const auto is_digits = [](absl::string_view digits) {
    return std::all_of(digits.begin(), digits.end(), absl::ascii_isdigit);
  };
  int64_t whole = 0;
  if (seconds.empty() || !is_digits(seconds) || !is_digits(decimals) ||
      !absl::SimpleAtoi(seconds, &whole) || whole > 9'000'000'000) {
    const bool is_large = !seconds.empty() && is_digits(seconds);
    return absl::InvalidArgumentError(absl::StrCat(
        "'", absl::CHexEscape(written), "' is not a time stamp in seconds",
        is_large ? "; are these milliseconds or nanoseconds?" : ""));
  }
  Time_ns fraction = 0;
  Time_ns unit = kSecond_ns / 10;
  for (const char digit : decimals.substr(0, 9)) {
    fraction += (digit - '0') * unit;
    unit /= 10;
  }
  return whole * kSecond_ns + fraction;
}

absl::StatusOr<std::vector<ListedStem>> ParseFrameList(
    absl::string_view text, const std::string& file) {
  std::vector<ListedStem> stems;
  Duplicates duplicates(file);
  int number = 0;
  for (const absl::string_view line :
       absl::StrSplit(WithoutByteOrderMark(text), '\n')) {
    ++number;
    const std::string stem(WithoutComment(line));
    if (stem.empty()) continue;
    if (LeadsOutside(stem) ||
        absl::StrContains(stem, absl::string_view("\0", 1))) {
      return LineError(file, number,
                       absl::StrCat("'", absl::CHexEscape(stem),
                                    "' is not a frame stem of the data set"));
    }
    TL_RETURN_IF_ERROR(duplicates.Add(stem, number));
    stems.push_back({stem, number});
  }
  if (stems.empty()) {
    return absl::InvalidArgumentError(
        absl::StrCat(file, ": the frame list names no frame"));
  }
  return stems;
}

absl::StatusOr<std::vector<StemPose>> ParseStemPoses(absl::string_view text,
                                                     const std::string& file) {
  std::vector<StemPose> poses;
  Duplicates duplicates(file);
  for (const Line& line : SplitLines(text)) {
    if (line.words.size() != 8 && line.words.size() != 9) {
      return LineError(
          file, line.number,
          absl::StrCat("expected 'stem qw qx qy qz tx ty tz [f]', found ",
                       line.words.size(), " words"));
    }
    absl::string_view stem = line.words[0];
    for (const char* ending : {".color.png", ".color.jpg"}) {
      if (absl::ConsumeSuffix(&stem, ending)) break;
    }
    std::array<double, 8> n{};
    const std::span<double> numbers(n.data(), line.words.size() - 1);
    TL_RETURN_IF_ERROR(ParseNumbers(std::span(line.words).subspan(1), file,
                                    line.number, numbers));
    const absl::StatusOr<geometry::Rigid3> camera_from_world =
        geometry::RigidFromQuaternion(n[0], n[1], n[2], n[3],
                                      {n[4], n[5], n[6]});
    if (!camera_from_world.ok()) {
      return LineError(file, line.number, camera_from_world.status().message());
    }
    StemPose pose{.stem = std::string(stem),
                  .world_from_camera = camera_from_world->Inverse(),
                  .focal_length_px = std::nullopt};
    if (numbers.size() == 8) {
      if (!(n[7] > 0)) {
        return LineError(
            file, line.number,
            absl::StrCat("focal length ", n[7], " px is not positive"));
      }
      pose.focal_length_px = n[7];
    }
    TL_RETURN_IF_ERROR(duplicates.Add(pose.stem, line.number));
    poses.push_back(std::move(pose));
  }
  return poses;
}

absl::StatusOr<geometry::Rigid3> ParsePoseMatrix(absl::string_view text,
                                                 const std::string& file) {
  const std::vector<Line> lines = SplitLines(text);
  if (lines.size() != 4) {
    return absl::InvalidArgumentError(absl::StrCat(
        file, ": expected 4 lines of a 4x4 matrix, found ", lines.size()));
  }
  std::array<double, 16> matrix{};
  for (size_t row = 0; row < 4; ++row) {
    const Line& line = lines[row];
    if (line.words.size() != 4) {
      return LineError(file, line.number,
                       absl::StrCat("expected 4 numbers, found ",
                                    line.words.size(), " words"));
    }
    TL_RETURN_IF_ERROR(ParseNumbers(line.words, file, line.number,
                                    std::span(matrix).subspan(4 * row, 4)));
  }
  const absl::StatusOr<geometry::Rigid3> pose =
      geometry::RigidFromMatrix4(matrix);
  if (!pose.ok()) return base::Annotate(pose.status(), file);
  return pose;
}

absl::StatusOr<std::vector<TimedFile>> ParseTimedFiles(
    absl::string_view text, const std::string& file) {
  std::vector<TimedFile> entries;
  for (const Line& line : SplitLines(text)) {
    if (line.words.size() != 2) {
      return LineError(file, line.number,
                       absl::StrCat("expected 'timestamp path', found ",
                                    line.words.size(), " words"));
    }
    const absl::StatusOr<Time_ns> time = ParseTime_ns(line.words[0]);
    if (!time.ok()) {
      return LineError(file, line.number, time.status().message());
    }
    std::string path(line.words[1]);
    if (LeadsOutside(path) ||
        absl::StrContains(path, absl::string_view("\0", 1))) {
      return LineError(file, line.number,
                       absl::StrCat("'", absl::CHexEscape(path),
                                    "' leads out of the sequence"));
    }
    entries.push_back(
        {*time, std::string(line.words[0]), std::move(path), line.number});
  }
  std::stable_sort(
      entries.begin(), entries.end(),
      [](const TimedFile& a, const TimedFile& b) { return a.time < b.time; });
  for (size_t i = 1; i < entries.size(); ++i) {
    if (entries[i].time == entries[i - 1].time) {
      return LineError(
          file, entries[i].line,
          absl::StrCat("the time ", entries[i].stem, " was already in line ",
                       entries[i - 1].line));
    }
  }
  return entries;
}

absl::StatusOr<std::vector<TimedPose>> ParseTimedPoses(
    absl::string_view text, const std::string& file) {
  std::vector<TimedPose> poses;
  for (const Line& line : SplitLines(text)) {
    if (line.words.size() != 8) {
      return LineError(
          file, line.number,
          absl::StrCat("expected 'timestamp tx ty tz qx qy qz qw', found ",
                       line.words.size(), " words"));
    }
    const absl::StatusOr<Time_ns> time = ParseTime_ns(line.words[0]);
    if (!time.ok()) {
      return LineError(file, line.number, time.status().message());
    }
    std::array<double, 7> n{};
    TL_RETURN_IF_ERROR(
        ParseNumbers(std::span(line.words).subspan(1), file, line.number, n));
    const absl::StatusOr<geometry::Rigid3> pose = geometry::RigidFromQuaternion(
        n[6], n[3], n[4], n[5], {n[0], n[1], n[2]});
    if (!pose.ok()) {
      return LineError(file, line.number, pose.status().message());
    }
    poses.push_back({*time, *pose});
  }
  std::stable_sort(
      poses.begin(), poses.end(),
      [](const TimedPose& a, const TimedPose& b) { return a.time < b.time; });
  return poses;
}

std::string FormatPoseMatrix(const geometry::Rigid3& world_from_camera) {
  const geometry::Mat3 r = world_from_camera.rotation.Matrix();
  const geometry::Vec3& t = world_from_camera.translation;
  std::string text;
  for (int row = 0; row < 3; ++row) {
    absl::StrAppendFormat(&text, "%.12f %.12f %.12f %.12f\n", r(row, 0),
                          r(row, 1), r(row, 2), t[row]);
  }
  return text + "0 0 0 1\n";
}

std::string FormatTimedPoses(std::span<const TimedPose> poses) {
  std::string text = "# timestamp tx ty tz qx qy qz qw\n";
  for (const TimedPose& pose : poses) {
    const geometry::Vec3& t = pose.world_from_camera.translation;
    const geometry::Rotation3 q =
        geometry::Normalized(pose.world_from_camera.rotation);
    absl::StrAppendFormat(&text,
                          "%d.%09d %.9f %.9f %.9f %.12f %.12f %.12f %.12f\n",
                          pose.time / kSecond_ns, pose.time % kSecond_ns, t.x,
                          t.y, t.z, q.x, q.y, q.z, q.w);
  }
  return text;
}

}  // namespace treeline::dataset
