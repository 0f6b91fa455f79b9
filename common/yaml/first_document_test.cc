#include "common/yaml/first_document.h"

#include "gtest/gtest.h"

namespace treeline::yaml {
namespace {

TEST(FirstDocumentTest, IsTheOnlyOne) {
  const FirstDocument document = LoadFirstDocument("a: 1\nb: 2\n");
  ASSERT_TRUE(document.node.has_value());
  EXPECT_EQ((*document.node)["b"].as<int>(), 2);
  EXPECT_FALSE(document.second.has_value());
}

TEST(FirstDocumentTest, ThereIsNoneInComments) {
  EXPECT_FALSE(LoadFirstDocument("").node.has_value());
  EXPECT_FALSE(LoadFirstDocument("# nothing\n").node.has_value());
}

TEST(FirstDocumentTest, ASecondOneIsSaid) {
  const FirstDocument document = LoadFirstDocument("a: 1\n---\nb: 2\n");
  ASSERT_TRUE(document.second.has_value());
  EXPECT_GE(document.second->line, 1);
  EXPECT_LE(document.second->line, 2);
}

// Of these yaml-cpp finds no end of documents.
TEST(FirstDocumentTest, DocumentsWithoutEndAreTwo) {
  for (const char* text : {",", ", a: 1", ",ike: rmp1", "]", "}"}) {
    try {
      const FirstDocument document = LoadFirstDocument(text);
      EXPECT_TRUE(document.second.has_value()) << text;
    } catch (const YAML::Exception&) {
      // Or it is no YAML.
    }
  }
}

}  // namespace
}  // namespace treeline::yaml
