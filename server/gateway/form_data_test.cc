#include "server/gateway/form_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace treeline::gateway {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr char kType[] = "multipart/form-data; boundary=xyz";

std::string Part(const std::string& name, const std::string& bytes) {
  return "--xyz\r\nContent-Disposition: form-data; name=\"" + name +
         "\"; filename=\"a b.jpg\"\r\nContent-Type: image/jpeg\r\n\r\n" +
         bytes + "\r\n";
}

TEST(FormData, HasItsPartsByteForByte) {
  const std::string picture("\xff\xd8\r\n\0--xy\r\n\r\n--", 15);
  const std::string body =
      Part("image", picture) + Part("scene", "kitchen") + "--xyz--\r\n";
  for (const char* before : {"", "a preamble\r\n"}) {
    const std::string all = before + body;
    const auto parts = ParseFormData(kType, all);
    ASSERT_TRUE(parts.ok()) << parts.status();
    ASSERT_EQ(parts->size(), 2u);
    EXPECT_EQ(parts->at(0).name, "image");
    EXPECT_EQ(parts->at(0).bytes, picture);
    EXPECT_EQ(parts->at(1).name, "scene");
    EXPECT_EQ(parts->at(1).bytes, "kitchen");
  }
}

TEST(FormData, ReadsWhatClientsWriteInOtherWays) {
  const auto parts = ParseFormData(
      "multipart/form-data; charset=utf-8; Boundary=\"xyz\"",
      "--xyz  \r\ncontent-disposition:form-data;name=a\r\n\r\n\r\n--xyz--");
  ASSERT_TRUE(parts.ok()) << parts.status();
  ASSERT_EQ(parts->size(), 1u);
  EXPECT_EQ(parts->at(0).name, "a");
  EXPECT_THAT(parts->at(0).bytes, IsEmpty());
  EXPECT_THAT(*ParseFormData(kType, "--xyz--"), IsEmpty());
}

TEST(FormData, SaysWhatIsWrong) {
  const auto wrong = [](const std::string& type, const std::string& body) {
    const auto parts = ParseFormData(type, body);
    EXPECT_TRUE(absl::IsInvalidArgument(parts.status())) << body;
    return std::string(parts.status().message());
  };
  EXPECT_THAT(wrong("multipart/form-data", "--xyz--"),
              HasSubstr("no boundary"));
  EXPECT_THAT(wrong("multipart/form-data; boundary=\"xyz", "--xyz--"),
              HasSubstr("no boundary"));
  EXPECT_THAT(wrong(kType, ""), HasSubstr("does not contain"));
  EXPECT_THAT(wrong(kType, "--abc--"), HasSubstr("does not contain"));
  EXPECT_THAT(wrong(kType, "--xyz"), HasSubstr("line end"));
  EXPECT_THAT(wrong(kType, "--xyz\r\nno headers"), HasSubstr("its headers"));
  EXPECT_THAT(wrong(kType, "--xyz\r\nA: b\r\n\r\n\r\n--xyz--"),
              HasSubstr("without a name"));
  EXPECT_THAT(wrong(kType, Part("image", "cut")), HasSubstr("'image'"));
  std::string many;
  for (int i = 0; i < 33; ++i) many += Part("a", "b");
  EXPECT_THAT(wrong(kType, many + "--xyz--"), HasSubstr("more than 32"));
}

}  // namespace
}  // namespace treeline::gateway
