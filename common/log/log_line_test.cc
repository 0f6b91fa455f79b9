#include "common/log/log_line.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "common/base/random.h"
#include "gtest/gtest.h"

namespace treeline::logging {
namespace {

nlohmann::json Parsed(const LogLine& event) {
  return nlohmann::json::parse("{" + event.fields() + "}");
}

TEST(LogLine, TextIsKeysAndValues) {
  LogLine event(LogFormat::kText);
  event.Word("rpc", "Localize")
      .Text("peer", "a \"b\"'\n")
      .Integer("n", -3)
      .Number("ms", 1.005);
  EXPECT_EQ(event.fields(),
            "rpc=Localize peer=\"a \\\"b\\\"'\\n\" n=-3 ms=1.00");
}

TEST(LogLine, JsonIsTheSameFields) {
  LogLine event(LogFormat::kJson);
  event.Word("rpc", "Localize")
      .Text("peer", "a \"b\"'\n")
      .Integer("n", -3)
      .Number("ms", 1.25)
      .Number("bad", std::nan(""))
      .Message("it stopped");
  const nlohmann::json parsed = Parsed(event);
  EXPECT_EQ(parsed["rpc"], "Localize");
  EXPECT_EQ(parsed["peer"], "a \"b\"'\n");
  EXPECT_EQ(parsed["n"], -3);
  EXPECT_EQ(parsed["ms"], 1.25);
  EXPECT_TRUE(parsed["bad"].is_null());
  EXPECT_EQ(parsed["message"], "it stopped");
}

TEST(LogLine, SentencesStandAloneInTexts) {
  EXPECT_EQ(LogLine(LogFormat::kText).Message("say \"no\"").fields(),
            "say \"no\"");
  EXPECT_EQ(LogLine(LogFormat::kText).Message("a\nb\x1b[0m").fields(),
            "a\\nb\\x1b[0m");
}

// Whatever bytes come, there is one field on one line of plain ASCII.
TEST(LogLine, NoBytesBreakOut) {
  for (uint64_t i = 0; i < 2000; ++i) {
    base::Random random(/*seed=*/7, i);
    std::string bytes(random.NextBelow(40), '\0');
    for (char& byte : bytes) byte = static_cast<char>(random.NextBits());
    LogLine json(LogFormat::kJson);
    json.Text("a", bytes).Text("b", "end");
    for (const char byte : json.fields()) {
      ASSERT_TRUE(byte >= 0x20 && byte < 0x7f);
    }
    ASSERT_EQ(Parsed(json).size(), 2u);
    ASSERT_EQ(Parsed(json)["b"], "end");
    LogLine text(LogFormat::kText);
    text.Text("a", bytes);
    for (const char byte : text.fields()) {
      ASSERT_TRUE(byte >= 0x20 && byte < 0x7f);
    }
  }
}

}  // namespace
}  // namespace treeline::logging
