// Light that differs over a picture from that in which its place was learnt: a
// lamp or a window on one side.
#ifndef SERVER_CORE_KEYFRAMES_LIGHT_FIELD_H_
#define SERVER_CORE_KEYFRAMES_LIGHT_FIELD_H_

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "server/core/keyframes/alignment_kernels.h"

namespace treeline::keyframes {

// How many times as bright a picture is as its keyframes say:
//   exp(c0 + c1 x + c2 y + c3 x^2 + c4 x y + c5 y^2),
// x and y from -1 to 1 over the picture's width and height.
class LightField {
 public:
  // Through the median ratios of parts of the picture in which brightness goes
  // with what the keyframes say; reference[i] belongs to point i of `seen`, of
  // which the first `end` are looked at. nullopt: hardly a part does.
  static std::optional<LightField> Fit(std::span<const float> reference,
                                       const VisiblePoints& seen, size_t end,
                                       int width, int height);

  // Makes brightness and gradients of the first `end` points what they would be
  // in even light. What is as white as it gets tells nothing, and is not seen
  // any more. Returns how many are.
  int Even(size_t end, VisiblePoints& seen) const;

  // Standard deviation of its logarithm over the picture.
  float Unevenness() const;

  // At a pixel.
  float At(float u, float v) const;

 private:
  static constexpr size_t kTerms = 6;
  using Terms = std::array<float, kTerms>;

  LightField(int width, int height) : width_(width), height_(height) {}
  Terms TermsAt(float u, float v) const;

  int width_;
  int height_;
  Terms coefficients_{};
};

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_LIGHT_FIELD_H_
