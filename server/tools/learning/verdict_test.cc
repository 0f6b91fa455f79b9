#include "server/tools/learning/verdict.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::learning {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

HeldOutTrial Trial(int right, int wrong = 0) {
  return {.queries = "colour alone",
          .frames = 100,
          .answered = right + wrong,
          .right = right,
          .wrong = wrong,
          .median_translation_m = 0.013,
          .median_rotation_deg = 0.3,
          .p90_translation_m = 0.03,
          .cpu_ms = 20};
}

TEST(VerdictTest, GradesFollowTheShareThatIsRight) {
  EXPECT_EQ(GradeOf(Trial(95)), Grade::kGood);
  EXPECT_EQ(GradeOf(Trial(89)), Grade::kFair);
  EXPECT_EQ(GradeOf(Trial(59)), Grade::kPoor);
}

TEST(VerdictTest, WrongAnswersSpoilAGoodShare) {
  EXPECT_EQ(GradeOf(Trial(92, 1)), Grade::kGood);
  EXPECT_EQ(GradeOf(Trial(92, 8)), Grade::kFair);
}

TEST(VerdictTest, TheWeakestKindOfQueryGivesTheGrade) {
  EXPECT_EQ(Judge({Trial(95), Trial(40)}, true).grade, Grade::kPoor);
  EXPECT_EQ(Judge({Trial(95), Trial(95)}, true).grade, Grade::kGood);
}

TEST(VerdictTest, SentencesTellTheFigures) {
  EXPECT_THAT(
      Judge({Trial(90, 2)}, true).sentences,
      ElementsAre(
          "Of 100 held-out pictures, asked about with colour alone, 92 "
          "were answered (92 %), 90 of them rightly (90 % of all). Half "
          "of the answers are within 1.3 cm and 0.30 degrees. 2 were "
          "wrong, though the confidence said otherwise."));
}

TEST(VerdictTest, FewPicturesAndNoneAreSaid) {
  HeldOutTrial few = Trial(9);
  few.frames = 9;
  EXPECT_THAT(Judge({few}, true).sentences.back(), HasSubstr("9 pictures"));
  EXPECT_EQ(Judge({}, true).grade, Grade::kPoor);
  EXPECT_THAT(Judge({}, true).sentences.back(), HasSubstr("held out"));
}

TEST(VerdictTest, LengthsAreInTheirUnit) {
  EXPECT_EQ(LengthText(0.0134, true), "1.3 cm");
  EXPECT_EQ(LengthText(2.5, true), "2.5 m");
  EXPECT_EQ(LengthText(0.0134, false), "0.0134 units");
}

}  // namespace
}  // namespace treeline::learning
