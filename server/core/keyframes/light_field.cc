#include "server/core/keyframes/light_field.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "Eigen/Cholesky"
#include "Eigen/Core"
#include "server/core/keyframes/brightness_moments.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {
namespace {

// Darker points say little of a ratio, and brighter ones are cut off.
constexpr float kDark = 8;
constexpr float kWhite = 250;
// Parts that a field is drawn through, at least.
constexpr int kMinParts = 4;
// Standard deviations of what is expected: of a part's ratio (its logarithm),
// and of the field's slopes and bends, where parts say nothing of them.
constexpr double kPartSigma = 0.1;
constexpr std::array<double, 6> kTermSigma = {3, 1, 1, 0.3, 0.3, 0.3};

// What is seen in one part of the picture.
struct Part {
  BrightnessMoments moments;
  float u = 0;
  float v = 0;
  std::vector<float> ratios;
};

}  // namespace

LightField::Terms LightField::TermsAt(float u, float v) const {
  const float x = 2 * u / static_cast<float>(width_) - 1;
  const float y = 2 * v / static_cast<float>(height_) - 1;
  return {1, x, y, x * x, x * y, y * y};
}

float LightField::At(float u, float v) const {
  const Terms terms = TermsAt(u, v);
  float logarithm = 0;
  for (size_t k = 0; k < kTerms; ++k) logarithm += coefficients_[k] * terms[k];
  return std::exp(logarithm);
}

std::optional<LightField> LightField::Fit(std::span<const float> reference,
                                          const VisiblePoints& seen, size_t end,
                                          int width, int height) {
  const auto place = [](float at, int size) {
    return static_cast<size_t>(std::clamp(
        static_cast<int>(at) * kExposureCells / size, 0, kExposureCells - 1));
  };
  std::vector<Part> parts(static_cast<size_t>(kExposureCells) * kExposureCells);
  for (size_t i = 0; i < end; ++i) {
    if (seen.seen[i] == 0 || reference[i] < kDark || seen.brightness[i] < 1 ||
        seen.brightness[i] >= kWhite) {
      continue;
    }
    Part& part = parts[place(seen.v[i], height) * kExposureCells +
                       place(seen.u[i], width)];
    part.moments.Add(reference[i], seen.brightness[i]);
    part.u += seen.u[i];
    part.v += seen.v[i];
    part.ratios.push_back(seen.brightness[i] / reference[i]);
  }
  LightField field(width, height);
  Eigen::Matrix<double, kTerms, kTerms> information =
      Eigen::Matrix<double, kTerms, kTerms>::Zero();
  Eigen::Matrix<double, kTerms, 1> sums =
      Eigen::Matrix<double, kTerms, 1>::Zero();
  for (size_t k = 0; k < kTerms; ++k) {
    information(static_cast<int>(k), static_cast<int>(k)) =
        1 / (kTermSigma[k] * kTermSigma[k]);
  }
  int used = 0;
  for (Part& part : parts) {
    const float n = part.moments.sums.w;
    if (n < kMinExposurePoints ||
        part.moments.Correlation() < kMinExposureCorrelation) {
      continue;
    }
    ++used;
    const auto middle = part.ratios.begin() +
                        static_cast<std::ptrdiff_t>(part.ratios.size() / 2);
    std::nth_element(part.ratios.begin(), middle, part.ratios.end());
    const Terms terms = field.TermsAt(part.u / n, part.v / n);
    for (size_t a = 0; a < kTerms; ++a) {
      for (size_t b = 0; b < kTerms; ++b) {
        information(static_cast<int>(a), static_cast<int>(b)) +=
            static_cast<double>(terms[a]) * static_cast<double>(terms[b]) /
            (kPartSigma * kPartSigma);
      }
      sums(static_cast<int>(a)) += static_cast<double>(terms[a]) *
                                   std::log(static_cast<double>(*middle)) /
                                   (kPartSigma * kPartSigma);
    }
  }
  if (used < kMinParts) return std::nullopt;
  const Eigen::Matrix<double, kTerms, 1> solved =
      information.ldlt().solve(sums);
  for (size_t k = 0; k < kTerms; ++k) {
    field.coefficients_[k] = static_cast<float>(solved(static_cast<int>(k)));
  }
  return field;
}

int LightField::Even(size_t end, VisiblePoints& seen) const {
  const auto& c = coefficients_;
  int count = 0;
  for (size_t i = 0; i < end; ++i) {
    if (seen.seen[i] == 0) continue;
    const bool is_white = seen.brightness[i] >= kWhite;
    const Terms at = TermsAt(seen.u[i], seen.v[i]);
    const float factor = is_white ? 0 : 1 / At(seen.u[i], seen.v[i]);
    seen.seen[i] = is_white ? 0.0F : 1.0F;
    seen.brightness[i] *= factor;
    // Of the quotient; the field changes by a share of it a pixel.
    const float share_x = (c[1] + 2 * c[3] * at[1] + c[4] * at[2]) * 2 /
                          static_cast<float>(width_);
    const float share_y = (c[2] + c[4] * at[1] + 2 * c[5] * at[2]) * 2 /
                          static_cast<float>(height_);
    seen.gradient_x[i] =
        seen.gradient_x[i] * factor - seen.brightness[i] * share_x;
    seen.gradient_y[i] =
        seen.gradient_y[i] * factor - seen.brightness[i] * share_y;
    count += is_white ? 0 : 1;
  }
  return count;
}

float LightField::Unevenness() const {
  // The terms' own standard deviations over the picture.
  const auto& c = coefficients_;
  return std::sqrt((c[1] * c[1] + c[2] * c[2]) / 3 + c[4] * c[4] / 9 +
                   (c[3] * c[3] + c[5] * c[5]) * 4 / 45);
}

}  // namespace treeline::keyframes
