#include "nav_agent/drivers/hokuyo/scip_parser.h"

#include <string>
#include <vector>

#include "gmock/gmock.h"
#include "gtest/gtest.h"
#include "nav_agent/drivers/hokuyo/scip_replies.h"
#include "nav_agent/drivers/hokuyo/testing_scip.h"
#include "nav_agent/drivers/stream/byte_stream.h"

namespace treeline::hokuyo {
namespace {

using testing::ElementsAre;

// Replies, each as one text.
std::vector<std::string> Parse(ScipParser& parser, absl::string_view text) {
  std::vector<std::string> replies;
  parser.Parse(stream::AsBytes(text), [&](const ScipReply& reply) {
    std::string all = absl::StrCat(reply.echo, "|", reply.status);
    for (const absl::string_view line : reply.lines) {
      absl::StrAppend(&all, "|", line);
    }
    replies.push_back(all);
  });
  return replies;
}

TEST(ScipParserTest, CutsAStreamIntoReplies) {
  ScipParser parser;
  EXPECT_THAT(
      Parse(parser, "BM\n00P\n\nTM1\n00P\n0000@\n\nGD0000108001\n10Q\n\n"),
      ElementsAre("BM|00", "TM1|00|0000@", "GD0000108001|10"));
  EXPECT_EQ(parser.corrupt(), 0);
}

TEST(ScipParserTest, WhereTheStreamIsCutMakesNoDifference) {
  const std::string text = "QT\n00P\n\n" +
                           ReplyText("PP", "00", EncodeParameters({})) +
                           "TM1\n00P\n0000@\n\n";
  ScipParser whole;
  const auto expected = Parse(whole, text);
  ASSERT_EQ(expected.size(), 3u);
  for (size_t first = 0; first <= text.size(); ++first) {
    for (size_t second = first; second <= text.size(); ++second) {
      ScipParser parser;
      auto replies = Parse(parser, text.substr(0, first));
      for (const std::string& part :
           {text.substr(first, second - first), text.substr(second)}) {
        const auto more = Parse(parser, part);
        replies.insert(replies.end(), more.begin(), more.end());
      }
      ASSERT_EQ(replies, expected) << first << " " << second;
    }
  }
}

TEST(ScipParserTest, ForgetsWhatIsNoReplyAndGoesOn) {
  ScipParser parser;
  EXPECT_THAT(
      Parse(parser, "half a line\n\nonly\nXXX\n\nBM\n00Q\n\nBM\n00P\n\n"),
      ElementsAre("BM|00"));
  EXPECT_EQ(parser.corrupt(), 3);
}

TEST(ScipParserTest, EmptyLinesMeanNothing) {
  ScipParser parser;
  EXPECT_THAT(Parse(parser, "\n\n\nBM\n00P\n\n\n\n"), ElementsAre("BM|00"));
  EXPECT_EQ(parser.corrupt(), 0);
}

TEST(ScipParserTest, HasRoomForOneReplyAndNoMore) {
  ScipParser parser;
  // A line without end, then lines without end; each costs one reply.
  EXPECT_TRUE(Parse(parser, std::string(8'000'000, 'x')).empty());
  EXPECT_THAT(Parse(parser, "\n\nBM\n00P\n\n"), ElementsAre("BM|00"));
  std::string lines;
  for (int i = 0; i < 1'000'000; ++i) lines += "x\n";
  EXPECT_TRUE(Parse(parser, lines).empty());
  EXPECT_THAT(Parse(parser, "\nBM\n00P\n\n"), ElementsAre("BM|00"));
  EXPECT_EQ(parser.corrupt(), 2);
  const std::string most(ScipParser::kMaxReplyBytes - 5, 'y');
  EXPECT_EQ(Parse(parser, "VV\n00P\n" + most + "\n\n").size(), 1u);
  EXPECT_EQ(Parse(parser, "VV\n00P\n" + most + "y\n\n").size(), 0u);
  EXPECT_THAT(Parse(parser, "BM\n00P\n\n"), ElementsAre("BM|00"));
}

// The scans that `text` holds for someone who asked for `command`.
std::vector<ScipScan> ScansIn(absl::string_view text,
                              const ScanCommand& command) {
  ScipParser parser;
  std::vector<ScipScan> scans;
  parser.Parse(stream::AsBytes(text), [&](const ScipReply& reply) {
    ScipScan scan;
    if (reply.echo == command.Text() && reply.status == "99" &&
        DecodeScan(reply, command, scan).ok()) {
      scans.push_back(scan);
    }
  });
  return scans;
}

bool Same(const ScipScan& a, const ScipScan& b) {
  return a.time_ms == b.time_ms && a.codes == b.codes &&
         a.intensities == b.intensities;
}

// A small scan between two others, so that every byte can be tried in turn.
class BrokenScanTest : public testing::Test {
 protected:
  BrokenScanTest() {
    for (const int64_t time_ms : {1000, 1025, 1050}) {
      ScipScan scan = ExampleScan(command_.content, time_ms);
      scan.codes.resize(60);
      scan.intensities.resize(60);
      for (uint32_t& code : scan.codes) {
        code += static_cast<uint32_t>(time_ms);
      }
      scans_.push_back(scan);
      texts_.push_back(ScanText(command_, scan));
    }
    text_ = texts_[0] + texts_[1] + texts_[2];
  }

  // The scans of `broken`: only ones that were sent, in their order.
  std::vector<ScipScan> NothingWrongIn(const std::string& broken, size_t at) {
    std::vector<ScipScan> found = ScansIn(broken, command_);
    size_t next = 0;
    for (const ScipScan& scan : found) {
      while (next < scans_.size() && !Same(scan, scans_[next])) ++next;
      EXPECT_LT(next, scans_.size())
          << "a scan that was never sent, byte " << at;
      ++next;
    }
    return found;
  }

  const ScanCommand command_ = {.content = ScanContent::kDistanceAndIntensity,
                                .first_step = 100,
                                .last_step = 159};
  std::vector<ScipScan> scans_{};
  std::vector<std::string> texts_{};
  std::string text_{};
};

TEST_F(BrokenScanTest, AllAreWholeIfNothingIsBroken) {
  EXPECT_EQ(ScansIn(text_, command_).size(), 3u);
}

TEST_F(BrokenScanTest, AnyChangedByteIsFound) {
  const size_t last_begins = texts_[0].size() + texts_[1].size();
  for (size_t at = 0; at < text_.size(); ++at) {
    // Every bit of it, and the end of a line.
    for (const int change : {1, 2, 4, 8, 16, 32, 64, 128, text_[at] ^ '\n'}) {
      if (change == 0) continue;
      std::string broken = text_;
      broken[at] = static_cast<char>(broken[at] ^ change);
      const auto scans = NothingWrongIn(broken, at);
      ASSERT_LT(scans.size(), 3u) << at << " " << change;
      // The last one is whole if its border was not touched.
      if (at + 2 < last_begins) {
        ASSERT_FALSE(scans.empty()) << at << " " << change;
        ASSERT_TRUE(Same(scans.back(), scans_[2])) << at << " " << change;
      }
    }
  }
}

TEST_F(BrokenScanTest, AnyLostStretchIsFound) {
  for (size_t at = 0; at < text_.size(); ++at) {
    // Less than a line: of two that are merged, the length then is wrong.
    // Where more is lost, the check sum of one line is all there is.
    for (size_t size = 1; size < 64 && at + size <= text_.size(); ++size) {
      std::string broken = text_;
      broken.erase(at, size);
      NothingWrongIn(broken, at);
    }
  }
}

TEST_F(BrokenScanTest, AnyAddedByteIsFound) {
  for (size_t at = 0; at <= text_.size(); ++at) {
    for (const char byte : {'\n', '0', 'o', 'x', '\0'}) {
      std::string broken = text_;
      broken.insert(at, 1, byte);
      NothingWrongIn(broken, at);
    }
  }
}

}  // namespace
}  // namespace treeline::hokuyo
