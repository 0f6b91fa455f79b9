#include "server/service/scene_recognizer.h"

#include <memory>
#include <string>

#include "common/base/random.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "server/core/recognition/appearance_words.h"
#include "server/service/service_test_util.h"

namespace treeline::service {
namespace {

using ::testing::ElementsAre;
using ::testing::Field;

// A picture with corners that are those of no other seed.
image::Frame Picture(uint64_t seed) {
  image::Frame frame;
  frame.color = {.width = 160, .height = 120, .rgb = {}};
  base::Random random(seed, 0);
  std::vector<uint8_t> blocks(20 * 15);
  for (uint8_t& block : blocks) {
    block = static_cast<uint8_t>(random.NextUniform(0, 256));
  }
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const uint8_t value = blocks[static_cast<size_t>(y / 8 * 20 + x / 8)];
      frame.color.rgb.insert(frame.color.rgb.end(), 3, value);
    }
  }
  return frame;
}

recognition::SceneDescriptor DescriptorOf(const image::Frame& frame) {
  recognition::AppearanceWords words;
  recognition::SceneDescriptor descriptor;
  descriptor.Add(words.Extract(frame.color));
  return descriptor;
}

class SceneRecognizerTest : public testing::Test {
 protected:
  SceneRecognizerTest()
      : scenes_({{"attic", nullptr}, {"cellar", nullptr}, {"kitchen", nullptr}},
                /*keep_files=*/true),
        recognizer_(scenes_.repository(),
                    [](const std::string& path) { return Read(path); }) {}

  static absl::StatusOr<recognition::SceneDescriptor> Read(
      const std::string& path) {
    if (path.find("/attic/") != std::string::npos) {
      return DescriptorOf(Picture(1));
    }
    if (path.find("/cellar/") != std::string::npos) {
      return DescriptorOf(Picture(2));
    }
    return absl::NotFoundError("no descriptor");
  }

  FakeScenes scenes_;
  SceneRecognizer recognizer_;
};

TEST_F(SceneRecognizerTest, TheSceneThatLooksLikeTheFrameComesFirst) {
  EXPECT_THAT(recognizer_.Rank(Picture(1), {}),
              ElementsAre(Field(&recognition::SceneScore::scene, "attic"),
                          Field(&recognition::SceneScore::scene, "cellar")));
  EXPECT_THAT(recognizer_.Rank(Picture(2), {}),
              ElementsAre(Field(&recognition::SceneScore::scene, "cellar"),
                          Field(&recognition::SceneScore::scene, "attic")));
}

TEST_F(SceneRecognizerTest, OnlyCandidatesAreRanked) {
  const std::string candidates[] = {"attic"};
  EXPECT_THAT(recognizer_.Rank(Picture(2), candidates),
              ElementsAre(Field(&recognition::SceneScore::scene, "attic")));
}

TEST_F(SceneRecognizerTest, CandidatesWithoutADescriptorComeLast) {
  const std::string candidates[] = {"kitchen", "cellar"};
  EXPECT_THAT(recognizer_.Rank(Picture(2), candidates),
              ElementsAre(Field(&recognition::SceneScore::scene, "cellar"),
                          recognition::SceneScore{"kitchen", 0}));
}

}  // namespace
}  // namespace treeline::service
