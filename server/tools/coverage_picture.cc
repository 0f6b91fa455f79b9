#include "server/tools/coverage_picture.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "opencv2/imgproc.hpp"

namespace treeline::tools {
namespace {

using geometry::Vec3;
using keyframes::CoverageMap;

// Colours are red, green, blue.
const cv::Scalar kWhite(255, 255, 255);
const cv::Scalar kBlack(30, 30, 30);
const cv::Scalar kQuiet(110, 110, 110);
const cv::Scalar kNoHeading(226, 226, 230);
const cv::Scalar kCameras(214, 39, 120);
const cv::Scalar kMark(200, 30, 30);
// From no heading to all: viridis without its darkest part, which colour-blind
// people and grey copies keep in order.
constexpr std::array<std::array<double, 3>, 5> kRamp = {{{72, 62, 133},
                                                         {49, 104, 142},
                                                         {31, 148, 140},
                                                         {94, 201, 98},
                                                         {253, 231, 37}}};
constexpr int kMargin_px = 28;
constexpr int kTitle_px = 84;
constexpr int kLegend_px = 122;
constexpr int kMinPlan_px = 760;
constexpr double kMaxPlan_px = 1000;
constexpr double kMaxHeight_px = 750;
// Around what is open (m).
constexpr double kSurroundings_m = 0.4;
constexpr int kMinFan_px = 22;
// A line between cameras that are further apart says nothing.
constexpr double kMaxStep_m = 1.0;
// Fractions of a pixel in OpenCV's drawing.
constexpr int kShift = 4;

cv::Scalar RampColor(double share) {
  const double at = std::clamp(share, 0.0, 1.0) * (kRamp.size() - 1);
  const size_t i = std::min(static_cast<size_t>(at), kRamp.size() - 2);
  const double part = at - static_cast<double>(i);
  cv::Scalar color;
  for (int c = 0; c < 3; ++c) {
    const auto channel = static_cast<size_t>(c);
    color[c] = (1 - part) * kRamp[i][channel] + part * kRamp[i + 1][channel];
  }
  return color;
}

void Write(cv::Mat& image, const std::string& text, cv::Point at, double size,
           const cv::Scalar& color = kBlack) {
  cv::putText(image, text, at, cv::FONT_HERSHEY_SIMPLEX, size, color, 1,
              cv::LINE_AA);
}

int WidthOf(const std::string& text, double size) {
  int below = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &below).width;
}

// The part of the plan that is drawn (m), and how large.
struct Frame {
  double min_x = 0;
  double max_x = 0;
  double min_y = 0;
  double max_y = 0;
  double px_per_m = 0;
  int left = 0;
  int top = 0;

  // In 1 / 2^kShift of a pixel.
  cv::Point At(double x, double y) const {
    return {static_cast<int>(
                std::lround((left + (x - min_x) * px_per_m) * (1 << kShift))),
            static_cast<int>(
                std::lround((top + (max_y - y) * px_per_m) * (1 << kShift)))};
  }
  int width() const {
    return static_cast<int>(std::lround((max_x - min_x) * px_per_m));
  }
  int height() const {
    return static_cast<int>(std::lround((max_y - min_y) * px_per_m));
  }
};

Frame FrameOf(const CoverageMap& coverage) {
  int first_column = coverage.columns;
  int last_column = 0;
  int first_row = coverage.rows;
  int last_row = 0;
  for (int r = 0; r < coverage.rows; ++r) {
    for (int c = 0; c < coverage.columns; ++c) {
      if (!coverage.places[static_cast<size_t>(r * coverage.columns + c)]
               .is_open) {
        continue;
      }
      first_column = std::min(first_column, c);
      last_column = std::max(last_column, c);
      first_row = std::min(first_row, r);
      last_row = std::max(last_row, r);
    }
  }
  const auto at = [&](double min, int cells) {
    return min + cells * coverage.cell_m;
  };
  Frame frame{
      .min_x = at(coverage.min_x_m, first_column) - kSurroundings_m,
      .max_x = at(coverage.min_x_m, last_column + 1) + kSurroundings_m,
      .min_y = at(coverage.min_y_m, first_row) - kSurroundings_m,
      .max_y = at(coverage.min_y_m, last_row + 1) + kSurroundings_m,
  };
  frame.px_per_m = std::min(kMaxPlan_px / (frame.max_x - frame.min_x),
                            kMaxHeight_px / (frame.max_y - frame.min_y));
  frame.left = kMargin_px + std::max(0, (kMinPlan_px - frame.width()) / 2);
  frame.top = kTitle_px;
  return frame;
}

template <typename Visit>
void ForEachOpenPlace(const CoverageMap& coverage, const Visit& visit) {
  for (size_t i = 0; i < coverage.places.size(); ++i) {
    const keyframes::CoveragePlace& place = coverage.places[i];
    if (!place.is_open) continue;
    const auto columns = static_cast<size_t>(coverage.columns);
    visit(
        place,
        coverage.min_x_m + static_cast<double>(i % columns) * coverage.cell_m,
        coverage.min_y_m + static_cast<double>(i / columns) * coverage.cell_m);
  }
}

void DrawPlaces(cv::Mat& image, const Frame& frame,
                const CoverageMap& coverage) {
  ForEachOpenPlace(coverage, [&](const keyframes::CoveragePlace& place,
                                 double x, double y) {
    const int good = std::popcount(place.good);
    cv::rectangle(
        image, frame.At(x, y + coverage.cell_m) / (1 << kShift),
        frame.At(x + coverage.cell_m, y) / (1 << kShift),
        good == 0 ? kNoHeading
                  : RampColor(static_cast<double>(good) / coverage.headings),
        cv::FILLED);
  });
}

// A tick towards each heading that is covered, where not all are.
void DrawFans(cv::Mat& image, const Frame& frame, const CoverageMap& coverage) {
  // As many cells share a fan as it needs room.
  const int stride = std::max(
      1, static_cast<int>(
             std::ceil(kMinFan_px / (coverage.cell_m * frame.px_per_m))));
  const double length_m = 0.4 * stride * coverage.cell_m;
  for (int r = stride / 2; r < coverage.rows; r += stride) {
    for (int c = stride / 2; c < coverage.columns; c += stride) {
      const keyframes::CoveragePlace& place =
          coverage.places[static_cast<size_t>(r * coverage.columns + c)];
      const int good = std::popcount(place.good);
      if (good == 0 || good == coverage.headings) continue;
      const double x = coverage.min_x_m + (c + 0.5) * coverage.cell_m;
      const double y = coverage.min_y_m + (r + 0.5) * coverage.cell_m;
      const cv::Scalar color = 2 * good > coverage.headings ? kBlack : kWhite;
      for (int h = 0; h < coverage.headings; ++h) {
        if (((place.good >> h) & 1u) == 0) continue;
        const double heading = coverage.Heading_rad(h);
        cv::line(image, frame.At(x, y),
                 frame.At(x + length_m * std::cos(heading),
                          y + length_m * std::sin(heading)),
                 color, 1, cv::LINE_AA, kShift);
      }
    }
  }
}

// How much structure there is above each pixel; floors and tables count less
// than walls and edges.
void DrawPoints(cv::Mat& image, const Frame& frame,
                const keyframes::KeyframeMap& map,
                const CoverageMap& coverage) {
  constexpr double kLevelSurface = 0.7;
  constexpr float kLevelWeight = 0.25F;
  const geometry::Mat3 matrix = coverage.plan_from_world.Matrix();
  cv::Mat amount(image.rows, image.cols, CV_32F, cv::Scalar(0));
  for (size_t k = 0; k < map.size(); ++k) {
    for (const keyframes::KeyframePoint& point : map.points(k)) {
      const auto& [px, py, pz] = point.position_in_world;
      const auto& [nx, ny, nz] = point.normal_in_world;
      const Vec3 at = matrix * Vec3{px, py, pz};
      const Vec3 normal =
          matrix * (Vec3{static_cast<double>(nx), static_cast<double>(ny),
                         static_cast<double>(nz)} /
                    127.0);
      if (at.x < frame.min_x || at.x > frame.max_x || at.y < frame.min_y ||
          at.y > frame.max_y) {
        continue;
      }
      const cv::Point pixel = frame.At(at.x, at.y) / (1 << kShift);
      amount.at<float>(pixel) +=
          std::abs(normal.z) > kLevelSurface ? kLevelWeight : 1;
    }
  }
  cv::GaussianBlur(amount, amount, {}, std::max(0.8, 0.008 * frame.px_per_m));
  std::vector<float> values;
  for (int v = 0; v < amount.rows; ++v) {
    for (int u = 0; u < amount.cols; ++u) {
      if (amount.at<float>(v, u) > 0) values.push_back(amount.at<float>(v, u));
    }
  }
  if (values.empty()) return;
  const auto strong =
      values.begin() +
      static_cast<std::ptrdiff_t>(values.size() - values.size() / 32 - 1);
  std::nth_element(values.begin(), strong, values.end());
  for (int v = 0; v < amount.rows; ++v) {
    for (int u = 0; u < amount.cols; ++u) {
      const float opacity =
          0.85F * std::min(1.0F, std::sqrt(amount.at<float>(v, u) / *strong));
      auto& pixel = image.at<cv::Vec3b>(v, u);
      for (int c = 0; c < 3; ++c) {
        pixel[c] =
            static_cast<uint8_t>((1 - opacity) * pixel[c] + opacity * 70);
      }
    }
  }
}

void DrawCameras(cv::Mat& image, const Frame& frame,
                 const keyframes::KeyframeMap& map,
                 const CoverageMap& coverage) {
  const geometry::Mat3 matrix = coverage.plan_from_world.Matrix();
  constexpr int kRadius = 3 << kShift;
  for (size_t k = 0; k < map.size(); ++k) {
    const Vec3 at = matrix * map.world_from_camera(k).translation;
    if (k > 0) {
      const Vec3 last = matrix * map.world_from_camera(k - 1).translation;
      if (geometry::Norm(at - last) < kMaxStep_m) {
        cv::line(image, frame.At(last.x, last.y), frame.At(at.x, at.y),
                 kCameras, 2, cv::LINE_AA, kShift);
      }
    }
    cv::circle(image, frame.At(at.x, at.y), kRadius, kCameras, cv::FILLED,
               cv::LINE_AA, kShift);
  }
}

// Above all else, on white, so that they are seen on any colour.
void DrawMarks(cv::Mat& image, const Frame& frame, const CoverageMarks& marks) {
  constexpr int kArm_px = 5;
  constexpr int kCircle_px = 13;
  constexpr double kArrow_px = 34;
  constexpr double kSize = 0.6;
  for (const CoverageMarks::Cross& cross : marks.crosses) {
    const cv::Point at = frame.At(cross.x_m, cross.y_m) / (1 << kShift);
    for (const auto& [color, width] :
         {std::pair{kWhite, 5}, std::pair{kMark, 2}}) {
      cv::line(image, at - cv::Point(kArm_px, kArm_px),
               at + cv::Point(kArm_px, kArm_px), color, width, cv::LINE_AA);
      cv::line(image, at - cv::Point(kArm_px, -kArm_px),
               at + cv::Point(kArm_px, -kArm_px), color, width, cv::LINE_AA);
    }
  }
  for (const CoverageMarks::Letter& letter : marks.letters) {
    const cv::Point at = frame.At(letter.x_m, letter.y_m) / (1 << kShift);
    if (letter.towards_rad) {
      const cv::Point tip =
          at + cv::Point(cvRound(kArrow_px * std::cos(*letter.towards_rad)),
                         cvRound(-kArrow_px * std::sin(*letter.towards_rad)));
      cv::arrowedLine(image, at, tip, kWhite, 6, cv::LINE_AA, 0, 0.3);
      cv::arrowedLine(image, at, tip, kMark, 3, cv::LINE_AA, 0, 0.3);
    }
    cv::circle(image, at, kCircle_px, kMark, cv::FILLED, cv::LINE_AA);
    cv::circle(image, at, kCircle_px, kWhite, 2, cv::LINE_AA);
    Write(image, letter.text,
          at + cv::Point(-WidthOf(letter.text, kSize) / 2, 7), kSize, kWhite);
  }
}

void DrawTitle(cv::Mat& image, const CoverageMap& coverage,
               const std::string& title) {
  const keyframes::CoverageSummary summary = keyframes::Summarize(coverage);
  Write(image, title, {kMargin_px, 34}, 0.75);
  Write(image,
        absl::StrFormat("Of the views from %.1f square metres of open space, "
                        "%.0f %% will be answered",
                        summary.open_m2, 100 * summary.good_share),
        {kMargin_px, 64}, 0.55, kQuiet);
}

// A round length that is about this long.
double ScaleLength_m(double about_m) {
  double length_m = 0.1;
  for (const double next : {0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0}) {
    if (next <= about_m) length_m = next;
  }
  return length_m;
}

void DrawLegend(cv::Mat& image, int top, const Frame& frame,
                const CoverageMap& coverage) {
  constexpr double kSize = 0.45;
  constexpr int kRampWidth = 200;
  constexpr int kBar = 14;
  int x = kMargin_px;
  for (int i = 0; i < kRampWidth; ++i) {
    cv::line(image, {x + i, top}, {x + i, top + kBar},
             RampColor(static_cast<double>(i) / kRampWidth));
  }
  Write(image, "few", {x, top + 32}, kSize);
  Write(image, "all headings",
        {x + kRampWidth - WidthOf("all headings", kSize), top + 32}, kSize);
  x += kRampWidth + 24;
  cv::rectangle(image, {x, top}, {x + 22, top + kBar}, kNoHeading, cv::FILLED);
  Write(image, "none", {x + 28, top + 12}, kSize);
  cv::line(image, {x, top + 26}, {x + 22, top + 26}, kCameras, 2, cv::LINE_AA);
  cv::circle(image, {x + 11, top + 26}, 3, kCameras, cv::FILLED, cv::LINE_AA);
  Write(image, "training cameras", {x + 28, top + 31}, kSize);
  x += 175;
  cv::rectangle(image, {x, top}, {x + 22, top + kBar}, kQuiet, cv::FILLED);
  Write(image, "structure", {x + 28, top + 12}, kSize);
  cv::rectangle(image, {x, top + 19}, {x + 22, top + 19 + kBar}, kQuiet);
  Write(image, "white: not seen to be open", {x + 28, top + 31}, kSize);
  const double length_m = ScaleLength_m(160 / frame.px_per_m);
  const int length_px =
      static_cast<int>(std::lround(length_m * frame.px_per_m));
  const int right = image.cols - kMargin_px;
  cv::rectangle(image, {right - length_px, top}, {right, top + 5}, kBlack,
                cv::FILLED);
  const std::string length = absl::StrFormat("%g m", length_m);
  Write(image, length, {right - WidthOf(length, kSize), top + 24}, kSize);
  Write(image,
        absl::StrFormat("Ticks: the headings answered, where not all are. "
                        "Cells of %.0f cm.",
                        100 * coverage.cell_m),
        {kMargin_px, top + 60}, kSize, kQuiet);
  Write(image,
        absl::StrFormat("Predicted for a camera %.2f m above the ground, "
                        "tilted %+.0f deg.",
                        coverage.height_m - coverage.ground_m,
                        coverage.tilt_rad * 180 / std::numbers::pi),
        {kMargin_px, top + 80}, kSize, kQuiet);
}

}  // namespace

image::ColorImage DrawCoverage(const keyframes::KeyframeMap& map,
                               const CoverageMap& coverage,
                               const std::string& title,
                               const CoverageMarks& marks) {
  const Frame frame = FrameOf(coverage);
  const int legend = frame.top + frame.height() + 24;
  const int width_px = 2 * kMargin_px + std::max(kMinPlan_px, frame.width());
  cv::Mat image(legend + kLegend_px - 24, width_px, CV_8UC3, kWhite);
  DrawPlaces(image, frame, coverage);
  DrawPoints(image, frame, map, coverage);
  DrawFans(image, frame, coverage);
  DrawCameras(image, frame, map, coverage);
  DrawMarks(image, frame, marks);
  DrawTitle(image, coverage, title);
  DrawLegend(image, legend, frame, coverage);
  image::ColorImage picture{
      .width = image.cols, .height = image.rows, .rgb = {}};
  picture.rgb.assign(image.datastart, image.dataend);
  return picture;
}

}  // namespace treeline::tools
