// Model files that are damaged or none: the scene is FAILED, the others serve.
#include <string>

#include "common/base/file.h"
#include "gmock/gmock.h"
#include "tests/integration/fixture.h"

namespace treeline {
namespace {

using ::testing::HasSubstr;

class BrokenModels : public ServerTest {
 protected:
  void SetUp() override {
    ServerTest::SetUp();
    const auto bytes = base::ReadFile(RoomModelPath());
    ASSERT_TRUE(bytes.ok()) << bytes.status();
    room_ = *bytes;
    PutRoom();
  }

  // Serves `bytes` as the scene "broken" beside the good one.
  void ExpectFailedWithDataLoss(const std::string& bytes) {
    PutModel("broken", "1", bytes);
    StartServer();
    ASSERT_NE(client_, nullptr);
    const auto scene = client_->GetScene("broken", {});
    ASSERT_TRUE(scene.ok()) << scene.status();
    EXPECT_EQ(scene->state, "FAILED");
    EXPECT_THAT(scene->failure, HasSubstr("DATA_LOSS"));
    EXPECT_FALSE(scene->model.has_value());
    EXPECT_THAT(server_->err(), HasSubstr("scene=broken"));

    const dataset::Dataset frames = HeldOutFrames();
    relocalizer::LocalizeQuery query = QueryOf(frames, 0);
    EXPECT_TRUE(client_->Localize(query, {}).ok());
    query.scene = "broken";
    EXPECT_EQ(client_->Localize(query, {}).status().code(),
              absl::StatusCode::kDataLoss);
  }

  std::string room_;
};

TEST_F(BrokenModels, Truncated) {
  ExpectFailedWithDataLoss(room_.substr(0, room_.size() / 2));
}

TEST_F(BrokenModels, ShortOfOneByte) {
  ExpectFailedWithDataLoss(room_.substr(0, room_.size() - 1));
}

TEST_F(BrokenModels, OneBitFlippedInTheMiddle) {
  room_[room_.size() / 2] = static_cast<char>(room_[room_.size() / 2] ^ 1);
  ExpectFailedWithDataLoss(room_);
}

TEST_F(BrokenModels, AFileOfAnotherKind) {
  ExpectFailedWithDataLoss("\x89PNG\r\n\x1a\n" + std::string(100'000, 'x'));
}

TEST_F(BrokenModels, Empty) { ExpectFailedWithDataLoss(""); }

TEST_F(BrokenModels, ANewVersionThatIsBrokenLeavesTheOldOneServing) {
  PutModel("room", "2", room_.substr(0, 1000));
  StartServer();
  const auto scene = client_->GetScene("room", {});
  ASSERT_TRUE(scene.ok()) << scene.status();
  EXPECT_EQ(scene->state, "READY");
  EXPECT_EQ(scene->model_version, "1");
  EXPECT_THAT(scene->versions, ::testing::ElementsAre("2", "1"));
  const dataset::Dataset frames = HeldOutFrames();
  const auto answer = client_->Localize(QueryOf(frames, 0), {});
  ASSERT_TRUE(answer.ok()) << answer.status();
  EXPECT_EQ(answer->model_version, "1");
}

}  // namespace
}  // namespace treeline
