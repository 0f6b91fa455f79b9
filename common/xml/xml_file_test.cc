#include "common/xml/xml_file.h"

#include <limits>
#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::xml {
namespace {

using ::testing::HasSubstr;

constexpr XmlKind kKind = {.name = "SDF", .max_bytes = size_t{1} << 20};

std::string Refusal(const std::string& text) {
  tinyxml2::XMLDocument document;
  return std::string(ParseXml(text, "file", kKind, document).message());
}

TEST(XmlFile, ReadsWhatIsXml) {
  tinyxml2::XMLDocument document;
  ASSERT_TRUE(ParseXml("<sdf>\n<a/></sdf>", "file", kKind, document).ok());
  const tinyxml2::XMLElement* child =
      document.RootElement()->FirstChildElement();
  EXPECT_EQ(ErrorAt(*child, "file", "why").message(), "file:2: why");
}

TEST(XmlFile, SaysWhyItIsNot) {
  EXPECT_THAT(Refusal("<sdf>\n<pose frame=>0</pose></sdf>"),
              HasSubstr("file:2: this is no XML (XML_ERROR_PARSING_ATTRIBUTE"));
  EXPECT_THAT(Refusal(std::string((size_t{1} << 20) + 1, ' ')),
              HasSubstr("longer than 1 MiB; is it SDF?"));
  EXPECT_THAT(Refusal("<!DOCTYPE a [<!ENTITY b \"c\">]><sdf/>"),
              HasSubstr("document types and entities"));
  std::string deep;
  for (int i = 0; i < 1000; ++i) deep += "<a>";
  EXPECT_THAT(Refusal(deep), HasSubstr("deeper than any SDF"));
}

TEST(XmlFile, NumbersAreFiniteWithinBoundsAndAllThere) {
  double three[3];
  EXPECT_TRUE(ParseNumbers(" .5\t2e0\n-3 ", -3, 3, three));
  EXPECT_EQ(three[0], 0.5);
  EXPECT_EQ(three[1], 2);
  EXPECT_EQ(three[2], -3);
  for (const char* text :
       {"", "1 2", "1 2 3 4", "1 2 nan", "1 2 inf", "1 2 4", "1 2 x"}) {
    EXPECT_FALSE(ParseNumbers(text, -3, 3, three)) << text;
  }
}

}  // namespace
}  // namespace treeline::xml
