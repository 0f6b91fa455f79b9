#include "common/yaml/yaml_node.h"

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::yaml {
namespace {

using testing::ElementsAre;

YamlNode Parsed(absl::string_view text) {
  absl::StatusOr<YamlNode> node = YamlNode::Parse(text, "file.yaml");
  EXPECT_TRUE(node.ok()) << node.status();
  return *node;
}

template <typename T>
std::string ErrorOf(const absl::StatusOr<T>& result) {
  EXPECT_EQ(result.status().code(), absl::StatusCode::kInvalidArgument);
  return std::string(result.status().message());
}

TEST(YamlNode, ReadsValuesOfEachType) {
  const YamlNode node = Parsed(
      "size: [3, 4.5, -1]\n"
      "count: 7\n"
      "name: a b\n"
      "open: true\n"
      "parts:\n"
      "  - kind: wall\n"
      "  - kind: door\n");
  EXPECT_THAT(*node.Numbers("size", 3, -10, 10), ElementsAre(3, 4.5, -1));
  EXPECT_EQ(*node.Integer("count", 0, 10), 7);
  EXPECT_EQ(*node.Number("count", 0, 10), 7);
  EXPECT_EQ(*node.Text("name"), "a b");
  EXPECT_TRUE(*node.Boolean("open"));
  EXPECT_EQ(node.Items("parts")->at(1).Choice("kind", {"wall", "door"}).value(),
            1);
  EXPECT_TRUE(node.Items("others")->empty());
  EXPECT_EQ(*node.NumberOr("height", 2.5, 0, 9), 2.5);
  EXPECT_EQ(*node.TextOr("color", "white"), "white");
  EXPECT_EQ(*node.IntegerOr("steps", 4, 0, 9), 4);
  EXPECT_FALSE(*node.BooleanOr("closed", false));
  EXPECT_THAT(node.Keys(),
              ElementsAre("size", "count", "name", "open", "parts"));
}

TEST(YamlNode, SaysWhereAndWhatIsWrong) {
  const YamlNode node = Parsed(
      "size: [3, x]\n"
      "count: 2.5\n"
      "parts:\n"
      "  - kind: wal\n"
      "  - 4\n");
  EXPECT_EQ(ErrorOf(node.Numbers("size", 2, 0, 9)),
            "file.yaml:1: size[1]: 'x' is not a number");
  EXPECT_EQ(ErrorOf(node.Numbers("size", 3, 0, 9)),
            "file.yaml:1: 'size' must be a sequence of 3 numbers");
  EXPECT_EQ(ErrorOf(node.Integer("count", 0, 9)),
            "file.yaml:2: count: '2.5' is not a whole number");
  EXPECT_EQ(ErrorOf(node.Number("count", 3, 9)),
            "file.yaml:2: count is 2.5; it must be 3..9");
  EXPECT_EQ(ErrorOf(node.Text("parts")),
            "file.yaml:4: 'parts' must be one value");
  EXPECT_EQ(ErrorOf(node.Items("parts")->at(0).Choice("kind", {"wall"})),
            "file.yaml:4: kind is 'wal'; it must be one of wall");
  EXPECT_EQ(ErrorOf(node.Items("parts")->at(0).Get("at")),
            "file.yaml:4: there is no 'at' in 'parts[0]'");
  EXPECT_EQ(node.Items("parts")->at(1).CheckKeys({"kind", "at"}).message(),
            "file.yaml:5: 'parts[1]' must hold names and values: kind, at");
}

TEST(YamlNode, KnowsItsKeys) {
  const YamlNode node = Parsed("heigth: 2\nwidth: 3\n");
  EXPECT_TRUE(node.CheckKeys({"heigth", "width"}).ok());
  EXPECT_EQ(node.CheckKeys({"height", "width"}).message(),
            "file.yaml:1: unknown key 'heigth'; did you mean 'height'?");
  EXPECT_EQ(node.CheckKeys({"width", "color"}).message(),
            "file.yaml:1: unknown key 'heigth'; there are width, color");
  EXPECT_EQ(Parsed("a: 1\nb: 2\na: 3\n").CheckKeys({"a", "b"}).message(),
            "file.yaml:3: 'a' stands there twice");
}

TEST(YamlNode, RefusesWhatIsNoYaml) {
  const auto error = [](absl::string_view text) {
    return ErrorOf(YamlNode::Parse(text, "f"));
  };
  EXPECT_EQ(error(""), "f:1: there is nothing in it");
  EXPECT_THAT(error("a: 1\nb: [2\n"), testing::StartsWith("f:3: not YAML: "));
  EXPECT_EQ(error("a: 1\n---\nb: 2\n"),
            "f:2: a second document; there may be one only");
  EXPECT_EQ(error(absl::string_view("a\0b", 3)),
            "f:1: a zero byte: this is not a text");
  EXPECT_EQ(error(std::string(YamlNode::kMaxBytes + 1, 'a')),
            "f:1: more than 1048576 bytes of YAML");
  EXPECT_THAT(error(std::string(100000, '[')),
              testing::StartsWith("f:1: not YAML: "));
}

}  // namespace
}  // namespace treeline::yaml
