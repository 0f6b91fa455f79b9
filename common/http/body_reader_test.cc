#include "common/http/body_reader.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <string>
#include <utility>

#include "absl/strings/str_cat.h"

namespace treeline::http {
namespace {

class TextSource final : public ByteSource {
 public:
  // Gives up to `most` bytes at a time.
  TextSource(std::string text, size_t most)
      : text_(std::move(text)), most_(most) {}
  ssize_t Read(char* to, size_t size) override {
    const size_t taken = std::min({size, most_, text_.size() - read_});
    std::copy_n(text_.data() + read_, taken, to);
    read_ += taken;
    return static_cast<ssize_t>(taken);
  }
  std::string rest() const { return text_.substr(read_); }

 private:
  const std::string text_;
  const size_t most_;
  size_t read_ = 0;
};

std::string Gzip(const std::string& bytes) {
  std::string out(bytes.size() + 1000, '\0');
  z_stream stream = {};
  EXPECT_EQ(deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, 15 + 16, 9,
                         Z_DEFAULT_STRATEGY),
            Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

constexpr size_t kMaxBytes = 1 << 20;

class BodyReaderTest : public testing::Test {
 protected:
  int Read(const RequestHead& head, const std::string& bytes) {
    TextSource source(bytes, 7);
    BodyReader reader(source, options_, lease_);
    const int status = reader.Read(head, body_);
    rest_ = source.rest();
    return status;
  }
  int ReadChunked(const std::string& bytes) {
    return Read({.is_chunked = true}, bytes);
  }
  int ReadGzip(const std::string& bytes) {
    return Read({.headers = {{"content-encoding", "gzip"}},
                 .content_length = bytes.size()},
                bytes);
  }

  BodyOptions options_{.max_bytes = kMaxBytes,
                       .patience = std::chrono::milliseconds(0)};
  base::ByteBudget budget_{4 * kMaxBytes};
  base::ByteLease lease_{&budget_};
  std::string body_;
  std::string rest_;
};

TEST_F(BodyReaderTest, ReadsAsMuchAsTheLengthSays) {
  EXPECT_EQ(Read({.content_length = 5}, "hellothere"), 0);
  EXPECT_EQ(body_, "hello");
  EXPECT_EQ(rest_, "there");
  EXPECT_EQ(Read({.content_length = 5}, "hell"), 400);
  EXPECT_EQ(
      Read({.content_length = kMaxBytes + 1}, std::string(kMaxBytes + 1, 'x')),
      413);
}

TEST_F(BodyReaderTest, JoinsChunks) {
  EXPECT_EQ(ReadChunked("3\r\nabc\r\n00a;x=\"y\"\r\n0123456789\r\n0\r\n"
                        "Trailer: 1\r\n\r\nnext"),
            0);
  EXPECT_EQ(body_, "abc0123456789");
  EXPECT_EQ(rest_, "next");
}

TEST_F(BodyReaderTest, RefusesChunksThatProxiesReadInAnotherWay) {
  for (const char* bytes :
       {"+3\r\nabc\r\n0\r\n\r\n", "-1\r\n", "0x3\r\nabc\r\n0\r\n\r\n",
        " 3\r\nabc\r\n0\r\n\r\n", "3\nabc\n0\n\n", "3\r\nabcd\r\n0\r\n\r\n",
        "\r\n", "100000000\r\n", "3\r\nabc\r\n0\r\n", "g\r\n",
        "3\r\nabc0\r\n\r\n", "3 3\r\nabc\r\n0\r\n\r\n", "3\rx\r\nabc\r\n",
        "0\r\nA: b\n\r\n\r\n"}) {
    EXPECT_EQ(ReadChunked(bytes), 400) << bytes;
  }
  EXPECT_EQ(ReadChunked(std::string("3\0\r\nabc\r\n0\r\n\r\n", 14)), 400);
  EXPECT_EQ(ReadChunked("3;" + std::string(1000, 'x') + "\r\n"), 400);
  EXPECT_EQ(ReadChunked("200000\r\n"), 413);
}

TEST_F(BodyReaderTest, RefusesTrailersWithoutEnd) {
  std::string bytes = "0\r\n";
  for (int i = 0; i < 1000; ++i) absl::StrAppend(&bytes, "A: b\r\n");
  EXPECT_EQ(ReadChunked(bytes), 400);
}

TEST_F(BodyReaderTest, InflatesGzip) {
  std::string text;
  for (int i = 0; i < 20000; ++i) absl::StrAppend(&text, i, " ");
  EXPECT_EQ(ReadGzip(Gzip(text)), 0);
  EXPECT_EQ(body_, text);
  EXPECT_EQ(ReadGzip(""), 0);
  EXPECT_EQ(body_, "");
}

TEST_F(BodyReaderTest, RefusesGzipThatIsBrokenOrGoesOn) {
  const std::string whole = Gzip("hello");
  EXPECT_EQ(ReadGzip(whole.substr(0, whole.size() - 1)), 400);
  EXPECT_EQ(ReadGzip(whole + "x"), 400);
  EXPECT_EQ(ReadGzip("hello"), 400);
  EXPECT_EQ(ReadGzip("\x78\x9c\x03\x00"), 400);
}

TEST_F(BodyReaderTest, RefusesWhatInflatesBeyondTheLimits) {
  const std::string bomb = Gzip(std::string(kMaxBytes + 1, '\0'));
  EXPECT_EQ(ReadGzip(bomb), 413);
  EXPECT_LE(budget_.used_bytes(), kMaxBytes);
  EXPECT_LE(body_.capacity(), lease_.bytes());
  // Far smaller than what is allowed, and far larger than what came.
  options_.inflation = {.floor_bytes = 1000, .ratio = 64};
  EXPECT_EQ(ReadGzip(Gzip(std::string(100000, '\0'))), 413);
}

TEST_F(BodyReaderTest, HoldsWhatItKeepsAndStopsWhereNothingIsLeft) {
  base::ByteLease others(&budget_);
  ASSERT_TRUE(others.Resize(4 * kMaxBytes - 60000));
  EXPECT_EQ(Read({.content_length = 40000}, std::string(40000, 'x')), 0);
  EXPECT_GE(lease_.bytes(), 40000u);
  lease_.Release();
  EXPECT_EQ(Read({.content_length = 60001}, std::string(60001, 'x')), 503);
  EXPECT_EQ(ReadChunked("9c40\r\n" + std::string(40000, 'x') + "\r\n0\r\n\r\n"),
            503);
  EXPECT_LE(lease_.bytes(), 60000u);
}

}  // namespace
}  // namespace treeline::http
