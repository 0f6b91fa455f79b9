#include "nav_agent/app/calibrate/calibration_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "absl/strings/str_format.h"
#include "common/base/sample_statistics.h"
#include "nav_agent/calibration/trajectories.h"
#include "opencv2/imgproc.hpp"

namespace treeline::calibrate_app {
namespace {

constexpr int kWidth_px = 1400;
constexpr int kHeight_px = 720;
constexpr int kMap_px = 700;
constexpr int kMargin_px = 40;
constexpr int kLegend_px = 60;
constexpr double kDegPerRad = 180 / std::numbers::pi;
const cv::Scalar kBlack(30, 30, 30);
const cv::Scalar kGrid(225, 225, 225);
const cv::Scalar kBefore(230, 120, 20);
const cv::Scalar kAfter(30, 90, 210);
const cv::Scalar kScans(150, 150, 150);

void Write(cv::Mat& image, const std::string& text, int x, int y,
           const cv::Scalar& color = kBlack) {
  cv::putText(image, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, 0.45, color, 1,
              cv::LINE_AA);
}

// Metres to pixels, the same scale for both axes.
struct View {
  double px_per_m = 1;
  geometry::Vec2 middle_m;

  cv::Point At(geometry::Vec2 p) const {
    const double middle_y = (kHeight_px - kLegend_px) / 2.0;
    return {static_cast<int>(
                std::lround(kMap_px / 2.0 + px_per_m * (p.x - middle_m.x))),
            static_cast<int>(
                std::lround(middle_y - px_per_m * (p.y - middle_m.y)))};
  }
};

View ViewOf(const calibration::Trajectories& all) {
  geometry::Vec2 low = {-0.5, -0.5};
  geometry::Vec2 high = {0.5, 0.5};
  for (const auto* way : {&all.before, &all.after, &all.by_scans}) {
    for (const geometry::Vec2& p : *way) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y)};
    }
  }
  const double wide_px = kMap_px - 2 * kMargin_px;
  const double high_px = kHeight_px - kLegend_px - 2 * kMargin_px;
  return {std::min(wide_px / (high.x - low.x), high_px / (high.y - low.y)),
          0.5 * (low + high)};
}

void DrawWay(const std::vector<geometry::Vec2>& way, const View& view,
             const cv::Scalar& color, int thick, cv::Mat& image) {
  cv::Point last = view.At({});
  for (const geometry::Vec2& p : way) {
    const cv::Point next = view.At(p);
    cv::line(image, last, next, color, thick, cv::LINE_AA);
    last = next;
  }
}

void DrawMap(const calibration::Trajectories& all, cv::Mat& image) {
  const View view = ViewOf(all);
  DrawWay(all.by_scans, view, kScans, 4, image);
  DrawWay(all.before, view, kBefore, 1, image);
  DrawWay(all.after, view, kAfter, 1, image);
  cv::circle(image, view.At({}), 4, kBlack, -1, cv::LINE_AA);
  // A scale of 1, 2 or 5 times a power of ten.
  double length_m = std::pow(10, std::floor(std::log10(200 / view.px_per_m)));
  if (5 * length_m * view.px_per_m < 200) {
    length_m *= 5;
  } else if (2 * length_m * view.px_per_m < 200) {
    length_m *= 2;
  }
  const int y = kHeight_px - kLegend_px;
  cv::line(image, {kMargin_px, y},
           {kMargin_px + static_cast<int>(length_m * view.px_per_m), y}, kBlack,
           2);
  Write(image, absl::StrFormat("%g m", length_m), kMargin_px, y - 8);
  int x = kMargin_px;
  for (const auto& [text, color] : {std::pair{"wheels as assumed", kBefore},
                                    {"calibrated", kAfter},
                                    {"by scans", kScans}}) {
    Write(image, text, x, kHeight_px - 18, color);
    x += 180;
  }
}

// One row: a difference over the drive.
void DrawResiduals(const std::string& name, const std::vector<double>& before,
                   const std::vector<double>& after, int top, int height,
                   cv::Mat& image) {
  const int left = kMap_px + kMargin_px;
  const int width = kWidth_px - left - kMargin_px;
  std::vector<double> sizes;
  for (const double value : before) sizes.push_back(std::abs(value));
  for (const double value : after) sizes.push_back(std::abs(value));
  const double largest = std::max(base::Quantile(sizes, 0.99), 1e-3);
  const int middle = top + height / 2;
  const auto at = [&](size_t i, double value) {
    const double share = std::clamp(value / largest, -1.0, 1.0);
    return cv::Point(
        left + static_cast<int>(static_cast<double>(i) * width /
                                static_cast<double>(before.size())),
        middle - static_cast<int>(share * (height / 2 - 14)));
  };
  cv::rectangle(image, {left, top}, {left + width, top + height}, kGrid);
  cv::line(image, {left, middle}, {left + width, middle}, kGrid);
  for (size_t i = 0; i < before.size(); ++i) {
    cv::circle(image, at(i, before[i]), 2, kBefore, -1, cv::LINE_AA);
  }
  for (size_t i = 0; i < after.size(); ++i) {
    cv::circle(image, at(i, after[i]), 2, kAfter, -1, cv::LINE_AA);
  }
  Write(image, absl::StrFormat("%s, up to +-%.1f", name, largest), left + 4,
        top + 14);
}

}  // namespace

image::ColorImage DrawCalibration(const calibration::Drive& drive,
                                  const calibration::Calibration& found) {
  image::ColorImage picture;
  picture.width = kWidth_px;
  picture.height = kHeight_px;
  picture.rgb.assign(size_t{3} * kWidth_px * kHeight_px, 255);
  cv::Mat image(kHeight_px, kWidth_px, CV_8UC3, picture.rgb.data());
  DrawMap(calibration::TrajectoriesOf(drive, found), image);
  std::vector<double> rows[2][3];
  for (const calibration::CheckedMotion& motion : found.motions) {
    const geometry::Rigid2& by_scans = motion.laser.begin_from_end;
    const geometry::Rigid2* by_wheels[] = {&motion.before, &motion.after};
    for (int i = 0; i < 2; ++i) {
      const geometry::Vec2 off =
          by_wheels[i]->translation - by_scans.translation;
      rows[i][0].push_back(1000 * off.x);
      rows[i][1].push_back(1000 * off.y);
      rows[i][2].push_back(kDegPerRad *
                           geometry::NormalizedAngle_rad(by_wheels[i]->yaw_rad -
                                                         by_scans.yaw_rad));
    }
  }
  const char* const names[] = {"wheels beside scans, laser's x (mm)",
                               "laser's y (mm)", "yaw (deg)"};
  const int height = (kHeight_px - 4 * 20) / 3;
  for (int i = 0; i < 3; ++i) {
    DrawResiduals(names[i], rows[0][i], rows[1][i], 20 + i * (height + 20),
                  height, image);
  }
  return picture;
}

}  // namespace treeline::calibrate_app
