#include "server/access/base64url.h"

#include <optional>
#include <string>

#include "gtest/gtest.h"

namespace treeline::access {
namespace {

TEST(Base64Url, EncodesTheVectorsOfTheStandard) {
  // RFC 4648, section 10, without padding.
  EXPECT_EQ(EncodeBase64Url(""), "");
  EXPECT_EQ(EncodeBase64Url("f"), "Zg");
  EXPECT_EQ(EncodeBase64Url("fo"), "Zm8");
  EXPECT_EQ(EncodeBase64Url("foo"), "Zm9v");
  EXPECT_EQ(EncodeBase64Url("foob"), "Zm9vYg");
  EXPECT_EQ(EncodeBase64Url("fooba"), "Zm9vYmE");
  EXPECT_EQ(EncodeBase64Url("foobar"), "Zm9vYmFy");
  EXPECT_EQ(EncodeBase64Url("\xff\xef\xbe"), "_---");
}

TEST(Base64Url, GivesEveryByteBack) {
  std::string bytes;
  for (int i = 0; i < 256; ++i) bytes.push_back(static_cast<char>(255 - i));
  for (size_t size = 0; size <= bytes.size(); ++size) {
    const std::string part = bytes.substr(0, size);
    EXPECT_EQ(DecodeBase64Url(EncodeBase64Url(part)), part);
  }
}

TEST(Base64Url, RefusesWhatIsNotItsOwn) {
  EXPECT_EQ(DecodeBase64Url("Zg=="), std::nullopt);
  EXPECT_EQ(DecodeBase64Url("Zm9v\n"), std::nullopt);
  EXPECT_EQ(DecodeBase64Url("Z+9v"), std::nullopt);
  EXPECT_EQ(DecodeBase64Url("Z/9v"), std::nullopt);
  EXPECT_EQ(DecodeBase64Url("Z"), std::nullopt);
  EXPECT_EQ(DecodeBase64Url(absl::string_view("Zg\0A", 4)), std::nullopt);
}

TEST(Base64Url, RefusesASecondTextForTheSameBytes) {
  EXPECT_EQ(DecodeBase64Url("Zg"), "f");
  EXPECT_EQ(DecodeBase64Url("Zh"), std::nullopt);
  EXPECT_EQ(DecodeBase64Url("Zm9"), std::nullopt);
}

}  // namespace
}  // namespace treeline::access
