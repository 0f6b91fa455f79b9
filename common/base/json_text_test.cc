#include "common/base/json_text.h"

#include "gtest/gtest.h"

namespace treeline::base {
namespace {

TEST(JsonTextTest, EscapesWhatJsonWantsEscaped) {
  EXPECT_EQ(JsonQuoted(""), R"("")");
  EXPECT_EQ(JsonQuoted("caf\xc3\xa9 / 2"), "\"caf\xc3\xa9 / 2\"");
  EXPECT_EQ(JsonQuoted("a \"b\" \\ \n\x1f"), R"("a \"b\" \\ \u000a\u001f")");
}

}  // namespace
}  // namespace treeline::base
