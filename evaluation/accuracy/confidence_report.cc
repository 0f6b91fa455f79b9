#include "evaluation/accuracy/confidence_report.h"

#include <algorithm>
#include <cmath>

namespace treeline::accuracy {
namespace {

constexpr int kBins = 10;

std::optional<double> Share(int part, int whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / whole;
}

}  // namespace

std::optional<double> ConfidenceReport::Precision() const {
  return stated ? Share(confident_correct, confident) : std::nullopt;
}

std::optional<double> ConfidenceReport::Recall() const {
  return stated ? Share(confident_correct, correct) : std::nullopt;
}

ConfidenceReport AssessConfidence(const std::vector<FrameResult>& results,
                                  const PoseThreshold& correct_within,
                                  double threshold) {
  ConfidenceReport report;
  report.threshold = threshold;
  for (int i = 0; i < kBins; ++i) {
    report.bins.push_back({.low = static_cast<double>(i) / kBins,
                           .high = static_cast<double>(i + 1) / kBins});
  }
  for (const FrameResult& result : results) {
    if (!result.error) continue;
    const double confidence = std::clamp(result.estimate.confidence, 0.0, 1.0);
    const bool correct = IsWithin(result, correct_within);
    ++report.frames;
    report.stated |= confidence > 0;
    report.correct += correct;
    if (confidence >= threshold) {
      ++report.confident;
      report.confident_correct += correct;
    }
    const int bin = std::min(static_cast<int>(confidence * kBins), kBins - 1);
    ReliabilityBin& into = report.bins[static_cast<size_t>(bin)];
    ++into.frames;
    into.confidence += confidence;
    into.correct += correct;
  }
  double error = 0;
  for (ReliabilityBin& bin : report.bins) {
    if (bin.frames == 0) continue;
    // The sums of confidences and of correct frames become means.
    error += std::abs(bin.confidence - bin.correct) / report.frames;
    bin.confidence /= bin.frames;
    bin.correct /= bin.frames;
  }
  if (report.stated) report.expected_calibration_error = error;
  return report;
}

}  // namespace treeline::accuracy
