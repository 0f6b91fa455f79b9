#include "evaluation/lost/lost_suite_picture.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "absl/strings/str_format.h"
#include "opencv2/imgproc.hpp"

namespace treeline::lost {
namespace {

constexpr int kWidth = 900;
constexpr int kHeight = 400;
constexpr double kFewest = 0.05;
constexpr double kMax = 500;
const cv::Scalar kBlack(30, 30, 30);
const cv::Scalar kGrey(215, 215, 215);
const cv::Scalar kBlue(30, 90, 220);
const cv::Scalar kRed(210, 40, 30);

void Write(cv::Mat& image, const std::string& text, int x, int y) {
  cv::putText(image, text, {x, y}, cv::FONT_HERSHEY_SIMPLEX, 0.42, kBlack, 1,
              cv::LINE_AA);
}

// A part of the picture with axes.
class Diagram {
 public:
  Diagram(cv::Mat& image, int left, const std::string& title)
      : image_(&image), left_(left) {
    Write(image, title, left, 24);
    cv::rectangle(image, {left, kTop}, {left + kSide, kTop + kSide}, kBlack);
    for (int i = 0; i <= 5; ++i) {
      const int y = kTop + kSide - i * kSide / 5;
      cv::line(image, {left, y}, {left + kSide, y}, kGrey);
      Write(image, absl::StrFormat("%d %%", 20 * i), left - 45, y + 4);
    }
  }
  // x and y in [0, 1].
  cv::Point At(double x, double y) const {
    return {left_ + static_cast<int>(x * kSide),
            kTop + static_cast<int>((1 - y) * kSide)};
  }
  void MarkX(double x, const std::string& text) {
    cv::line(*image_, At(x, 0), At(x, 1), kGrey);
    Write(*image_, text, At(x, 0).x - 8, kTop + kSide + 18);
  }
  void Line(cv::Point from, cv::Point to, const cv::Scalar& color) {
    cv::line(*image_, from, to, color, 2, cv::LINE_AA);
  }
  void NameX(const std::string& text) {
    Write(*image_, text, left_ + 40, kTop + kSide + 40);
  }

 private:
  static constexpr int kTop = 40;
  static constexpr int kSide = 300;
  cv::Mat* image_;
  int left_;
};

double LogShare(double per_h) {
  return std::clamp(
      std::log(std::max(per_h, kFewest) / kFewest) / std::log(kMax / kFewest),
      0.0, 1.0);
}

}  // namespace

image::ColorImage DrawLostReport(const LostReport& report) {
  const double threshold = report.threshold_log_odds();
  cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(255, 255, 255));
  Diagram roc(image, 60, "kidnaps declared within 3 s");
  for (const double per_h : {0.1, 1.0, 10.0, 100.0}) {
    roc.MarkX(LogShare(per_h), absl::StrFormat("%g", per_h));
  }
  roc.NameX("false alarms per hour (left edge: none)");
  cv::Point last = roc.At(1, 1);
  for (const RocPoint& point : report.Roc()) {
    const cv::Point next =
        roc.At(LogShare(point.false_alarms_per_h), point.detection);
    roc.Line(last, next, kBlue);
    last = next;
  }
  const double hours = std::max(1e-9, report.Hours(""));
  cv::circle(image,
             roc.At(LogShare(static_cast<double>(
                                 report.FalseAlarms(threshold, "").size()) /
                             hours),
                    report.Kidnaps(threshold, "").Share()),
             5, kRed, cv::FILLED, cv::LINE_AA);

  Diagram delay(image, 520, "declared after (s): warm blue, cold red");
  for (int s = 0; s <= 3; ++s) {
    delay.MarkX(s / kDeclareWithin_s, absl::StrFormat("%d", s));
  }
  delay.NameX("seconds since the kidnap");
  for (const KidnapStart start : {KidnapStart::kWarm, KidnapStart::kCold}) {
    KidnapTally tally = report.KidnapsOf(threshold, start, true);
    const KidnapTally standing = report.KidnapsOf(threshold, start, false);
    tally.kidnaps += standing.kidnaps;
    tally.delays_s.insert(tally.delays_s.end(), standing.delays_s.begin(),
                          standing.delays_s.end());
    std::ranges::sort(tally.delays_s);
    cv::Point from = delay.At(0, 0);
    for (size_t i = 0; i < tally.delays_s.size(); ++i) {
      const cv::Point to = delay.At(tally.delays_s[i] / kDeclareWithin_s,
                                    static_cast<double>(i + 1) / tally.kidnaps);
      delay.Line(from, to, start == KidnapStart::kWarm ? kBlue : kRed);
      from = to;
    }
  }
  image::ColorImage picture{.width = kWidth, .height = kHeight, .rgb = {}};
  picture.rgb.assign(image.datastart, image.dataend);
  return picture;
}

}  // namespace treeline::lost
