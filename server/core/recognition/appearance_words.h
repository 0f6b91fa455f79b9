// What an image looks like, as a set of words out of a fixed vocabulary: the
// same corner of the same thing gives the same word in most images of it.
#ifndef SERVER_CORE_RECOGNITION_APPEARANCE_WORDS_H_
#define SERVER_CORE_RECOGNITION_APPEARANCE_WORDS_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/image/image.h"

namespace treeline::recognition {

// Another vocabulary is another number: words of different vocabularies have
// nothing to do with each other. Model files hold it.
inline constexpr uint32_t kVocabulary = 1;

// A fern is a row of kFernTests comparisons of two pixels near a corner; their
// outcomes, hashed to kWordBits bits, are a word.
inline constexpr int kFerns = 8;
inline constexpr int kFernTests = 18;
inline constexpr int kWordBits = 17;
inline constexpr uint32_t kWordsPerFern = uint32_t{1} << kWordBits;
// Words are numbers below this: fern f has those from f * kWordsPerFern.
inline constexpr uint32_t kWords = kFerns * kWordsPerFern;

// Makes words of images. Holds scratch memory: one for each thread.
//
// The image is reduced to 160 pixels on its longer side and to the logarithm
// of its intensities, so that exposure shifts values and leaves differences.
// At the kCornersPerLevel strongest corners (Foerstner's measure) of each of
// kLevels resolutions, every fern compares pairs of pixels and channels (as in
// Ozuysal et al., Fast Keypoint Recognition Using Random Ferns, 2010). All of
// it is integer arithmetic, the same on every machine.
class AppearanceWords {
 public:
  static constexpr int kLongSide_px = 160;
  static constexpr int kLevels = 3;
  static constexpr int kCornersPerLevel = 200;

  AppearanceWords();

  // The words of an image of at least one pixel, each as often as it occurs,
  // in an order that depends on the image alone. Empty for images without
  // corners and for images of no pixels.
  const std::vector<uint32_t>& Extract(const image::ColorImage& image);

 private:
  struct Test {
    int dx1 = 0, dy1 = 0, channel1 = 0;
    int dx2 = 0, dy2 = 0, channel2 = 0;
    int threshold = 0;
  };
  // Red, green and blue planes, one after the other.
  struct Level {
    int width = 0;
    int height = 0;
    std::vector<uint8_t> planes;
  };
  struct Corner {
    int64_t strength = 0;
    int index = 0;  // y * width + x
  };

  void Shrink(const image::ColorImage& image);
  void Halve(const Level& from, Level& to);
  void FindCorners(const Level& level);
  void AddWords(const Level& level);

  std::array<Test, size_t{kFerns} * kFernTests> tests_;
  std::array<uint8_t, 256> logarithm_{};
  std::array<Level, kLevels> levels_;
  std::vector<uint32_t> column_sums_;
  std::vector<int32_t> gradients_;  // xx, xy, yy of each pixel
  std::vector<int64_t> strengths_;
  std::vector<Corner> corners_;
  std::vector<uint32_t> words_;
};

}  // namespace treeline::recognition

#endif  // SERVER_CORE_RECOGNITION_APPEARANCE_WORDS_H_
