#include "common/http/request_head.h"

#include <gtest/gtest.h>

#include <string>

#include "absl/strings/str_cat.h"

namespace treeline::http {
namespace {

using Verdict = HeadScanner::Verdict;

std::optional<RequestHead> Parse(absl::string_view headers,
                                 absl::string_view line = "POST / HTTP/1.1") {
  return ParseRequestHead(absl::StrCat(line, "\r\n", headers, "\r\n"));
}

TEST(RequestHead, SaysWhatTheLinesSay) {
  const auto head = ParseRequestHead(
      "POST /a%20b?c HTTP/1.1\r\nHost: x\r\nX-Two: \t1 2 \r\nX-Two: 3\r\n"
      "Content-Length: 12\r\n\r\n");
  ASSERT_TRUE(head.has_value());
  EXPECT_EQ(head->method, "POST");
  EXPECT_EQ(head->target, "/a%20b?c");
  EXPECT_EQ(head->headers.at("host"), "x");
  EXPECT_EQ(head->headers.at("x-two"), "1 2");
  EXPECT_EQ(head->content_length, 12u);
  EXPECT_FALSE(head->is_chunked);
  EXPECT_TRUE(Parse("Transfer-Encoding: Chunked\r\n")->is_chunked);
  EXPECT_FALSE(Parse("")->has_body());
}

TEST(RequestHead, RefusesLengthsThatAreNoDigits) {
  for (const char* length : {"+2", "-2", "2 2", "0x2", "2,2", "", "%32", "2;",
                             "9999999999999999999", "\v2"}) {
    EXPECT_FALSE(Parse(absl::StrCat("Content-Length: ", length, "\r\n")))
        << length;
  }
  EXPECT_TRUE(Parse("Content-Length:2\r\n"));
  EXPECT_TRUE(Parse("Content-Length: 999999999999999999 \r\n"));
}

TEST(RequestHead, RefusesTwoWaysToSayWhereTheBodyEnds) {
  EXPECT_FALSE(Parse("Content-Length: 2\r\nContent-Length: 2\r\n"));
  EXPECT_FALSE(Parse("Content-Length: 2\r\nTransfer-Encoding: chunked\r\n"));
  EXPECT_FALSE(
      Parse("Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n"));
  for (const char* encoding : {"identity", "gzip, chunked", "chunked, chunked",
                               "xchunked", "\"chunked\""}) {
    EXPECT_FALSE(Parse(absl::StrCat("Transfer-Encoding: ", encoding, "\r\n")))
        << encoding;
  }
  EXPECT_FALSE(Parse("Transfer-Encoding: chunked\r\n", "POST / HTTP/1.0"));
}

TEST(RequestHead, RefusesNamesThatAreNoTokens) {
  EXPECT_FALSE(Parse("Transfer-Encoding : chunked\r\n"));
  EXPECT_FALSE(Parse("Transfer-Encoding\t: chunked\r\n"));
  EXPECT_FALSE(Parse("X: 1\r\n Content-Length: 2\r\n"));
  EXPECT_FALSE(Parse("X: 1\r\n\tcontinued\r\n"));
  EXPECT_FALSE(Parse(" X: 1\r\n"));
  EXPECT_FALSE(Parse(": 1\r\n"));
  EXPECT_FALSE(Parse("no colon\r\n"));
  EXPECT_FALSE(Parse("X(: 1\r\n"));
}

TEST(RequestHead, RefusesControlCharacters) {
  EXPECT_FALSE(Parse(absl::string_view("X: a\0b\r\n", 8)));
  EXPECT_FALSE(Parse("X: a\rb\r\n"));
  EXPECT_FALSE(Parse("X: a\nContent-Length: 2\r\n"));
  EXPECT_FALSE(Parse("X: a\x7f\r\n"));
  EXPECT_TRUE(Parse("X: \xc3\xa9\r\n"));
}

TEST(RequestHead, RefusesTwoOfWhatSaysWhoseItIs) {
  EXPECT_FALSE(Parse("Host: a\r\nhost: b\r\n"));
  EXPECT_FALSE(Parse("Authorization: Bearer a\r\nAuthorization: Bearer b\r\n"));
  EXPECT_FALSE(Parse("Content-Encoding: gzip\r\nContent-Encoding: gzip\r\n"));
}

TEST(RequestHead, RefusesOtherRequestLines) {
  for (const char* line :
       {"POST /", "POST  / HTTP/1.1", "POST / HTTP/2.0", "POST / http/1.1",
        "POST / HTTP/1.1 ", " POST / HTTP/1.1", "P(ST / HTTP/1.1",
        "POST /\x80 HTTP/1.1", "POST /\t/ HTTP/1.1", ""}) {
    EXPECT_FALSE(Parse("", line)) << line;
  }
}

TEST(RequestHead, RefusesMoreThanAHundredHeaders) {
  std::string headers;
  for (int i = 0; i < 100; ++i) absl::StrAppend(&headers, "X", i, ": 1\r\n");
  EXPECT_TRUE(Parse(headers));
  EXPECT_FALSE(Parse(headers + "Y: 1\r\n"));
}

TEST(HeadScanner, FindsTheEndHoweverTheBytesArrive) {
  const std::string bytes = "GET / HTTP/1.1\r\nX: 1\r\n\r\nbody\n";
  const size_t end = bytes.find("body");
  HeadScanner one_at_a_time;
  for (size_t i = 0; i < end; ++i) {
    EXPECT_EQ(one_at_a_time.Scan(bytes.substr(0, i)), Verdict::kIncomplete);
  }
  EXPECT_EQ(one_at_a_time.Scan(bytes), Verdict::kComplete);
  EXPECT_EQ(one_at_a_time.end(), end);
  HeadScanner at_once;
  EXPECT_EQ(at_once.Scan(bytes), Verdict::kComplete);
  EXPECT_EQ(at_once.end(), end);
}

TEST(HeadScanner, DoesNotWaitForTheEndOfWhatIsNoHead) {
  EXPECT_EQ(HeadScanner().Scan("GET / HTTP/1.1\n"), Verdict::kMalformed);
  EXPECT_EQ(HeadScanner().Scan("\n"), Verdict::kMalformed);
  EXPECT_EQ(HeadScanner().Scan("GET / HTTP/1.1\r\nX: 1\n\r\n"),
            Verdict::kMalformed);
  EXPECT_EQ(HeadScanner().Scan(absl::string_view("GE\0", 3)),
            Verdict::kMalformed);
}

}  // namespace
}  // namespace treeline::http
