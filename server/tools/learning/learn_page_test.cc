#include "server/tools/learning/learn_page.h"

#include "absl/strings/str_cat.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::learning {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

LearnPage Page() {
  LearnPage page;
  page.scene = "office";
  page.source = "captures/<office> & more";
  page.right_within = "5 cm and 5 degrees";
  page.trials = {{.queries = "colour and depth",
                  .frames = 200,
                  .answered = 198,
                  .right = 196,
                  .wrong = 1,
                  .median_translation_m = 0.011,
                  .median_rotation_deg = 0.25},
                 {.queries = "colour alone",
                  .frames = 200,
                  .answered = 150,
                  .right = 140,
                  .wrong = 3,
                  .median_translation_m = 0.02,
                  .median_rotation_deg = 0.5}};
  page.foreign_pictures = 80;
  page.coverage = PageCoverage{.summary = {.open_m2 = 20, .good_share = 0.7},
                               .png = "png bytes",
                               .weak_spots = {}};
  page.steps = {{"Import", "200 frames", 1.5}, {"Train", "5 trees", 40}};
  return page;
}

TEST(LearnPageTest, SaysHowGoodItIsByTheWeakestKindOfQuery) {
  const std::string html = LearnPageHtml(Page());
  EXPECT_THAT(html, HasSubstr("It will work, with gaps."));
  EXPECT_THAT(html, HasSubstr("<b>70 %</b><span>of new pictures placed within "
                              "5 cm and 5 degrees, with colour alone"));
  EXPECT_THAT(html, HasSubstr("<b>2.0 cm</b>"));
  EXPECT_THAT(html, HasSubstr("<b>3</b><span>wrong among 150 answers"));
  EXPECT_THAT(html, HasSubstr("<td>In all</td><td></td><td class=\"number\">"
                              "41.5 s"));
  EXPECT_THAT(html, HasSubstr("80 queries were of nothing at all (blank walls, "
                              "noise, darkness): 0 of them were answered, as "
                              "it should be"));
}

// Names of files and messages come from outside.
TEST(LearnPageTest, TextsCannotBecomeMarkup) {
  LearnPage page = Page();
  page.notes = {"<script>alert(1)</script>"};
  page.missed = 1;
  page.missed_pictures = {{"a\"b", "<b>", "jpeg"}};
  const std::string html = LearnPageHtml(page);
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("captures/&lt;office&gt; &amp; more"));
  EXPECT_THAT(html, HasSubstr("a&quot;b: &lt;b&gt;"));
}

TEST(LearnPageTest, PicturesAreInThePage) {
  EXPECT_THAT(LearnPageHtml(Page()),
              AllOf(HasSubstr("data:image/png;base64,cG5nIGJ5dGVz"),
                    Not(HasSubstr("src=\"http"))));
}

TEST(LearnPageTest, WeakSpotsBecomeAdvice) {
  LearnPage page = Page();
  EXPECT_THAT(AdviceOf(page), IsEmpty());
  EXPECT_THAT(LearnPageHtml(page), HasSubstr("Nowhere in particular"));
  page.coverage->weak_spots = {
      {.x_m = 1, .y_m = 2, .radius_m = 0.5, .missing_share = 0.9},
      {.radius_m = 0.5, .missing_share = 0.5, .towards_rad = 0}};
  EXPECT_THAT(
      AdviceOf(page),
      ElementsAre("A: stand there and turn round once, slowly. Of the views "
                  "from within 0.5 m, 90 % are missing.",
                  "B: stand there and look towards the right of the plan. Of "
                  "the views from within 0.5 m, 50 % are missing."));
  EXPECT_THAT(LearnPageHtml(page), HasSubstr("<li>B: stand there"));
}

TEST(LearnPageTest, WithoutCoverageItSaysWhy) {
  LearnPage page = Page();
  page.coverage.reset();
  page.no_coverage_because = "The model has no keyframes.";
  EXPECT_THAT(LearnPageHtml(page), HasSubstr("The model has no keyframes."));
  EXPECT_THAT(LearnPageHtml(page), Not(HasSubstr("<img class=\"plan\"")));
}

}  // namespace
}  // namespace treeline::learning
