#include "server/repository/model_index.h"

#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_replace.h"
#include "gmock/gmock.h"

namespace treeline::repository {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

const char* const kDigest =
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

std::string Index() {
  return absl::StrCat(
      R"({"models":[{"scene":"kitchen","version":"7","bytes":12,"sha256":")",
      kDigest, R"(","url":"https://h/k?sig=SECRET"}],)",
      R"("scenes":{"kitchen":{"display_name":"K\u00fcche"}}})");
}

std::string IndexWith(const std::string& from, const std::string& to) {
  const std::string changed = absl::StrReplaceAll(Index(), {{from, to}});
  EXPECT_NE(changed, Index()) << from;
  return changed;
}

TEST(ModelIndex, ReadsModelsAndScenes) {
  const auto index = ParseModelIndex(Index());
  ASSERT_TRUE(index.ok()) << index.status();
  ASSERT_EQ(index->models.size(), 1u);
  EXPECT_EQ(index->models[0].scene, "kitchen");
  EXPECT_EQ(index->models[0].version, "7");
  EXPECT_EQ(index->models[0].bytes, 12u);
  EXPECT_EQ(index->models[0].sha256, kDigest);
  EXPECT_EQ(index->models[0].url, "https://h/k?sig=SECRET");
  EXPECT_EQ(index->scene_json.at("kitchen"), R"({"display_name":"Küche"})");
}

TEST(ModelIndex, IsReadAsItWasWritten) {
  const auto index = ParseModelIndex(Index());
  ASSERT_TRUE(index.ok()) << index.status();
  const auto text = ModelIndexJson(*index);
  ASSERT_TRUE(text.ok()) << text.status();
  const auto again = ParseModelIndex(*text);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->models[0].url, index->models[0].url);
  EXPECT_EQ(again->scene_json, index->scene_json);
}

TEST(ModelIndex, SignaturesAreReadAsTheyWereWritten) {
  ModelIndex index = ParseModelIndex(Index()).value();
  index.published_unix_s = 1764172800;
  index.signature = std::string(kSignatureBytes, '\xfe');
  const std::string text = ModelIndexJson(index).value();
  const auto again = ParseModelIndex(text);
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->published_unix_s, index.published_unix_s);
  EXPECT_EQ(again->signature, index.signature);
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{
           {"1764172800", "-1"},
           {"1764172800", "0"},
           {"1764172800", "1.5"},
           {"1764172800", "\"1764172800\""},
           {"published", "publisht"},
           {"==\"", "\""},
           {"/v7+/v7+", "/v7+ /v7+"},
           {"/v7+/v7+/v7+/v7+", "/v7+/v7+/v7+"}}) {
    const std::string changed = absl::StrReplaceAll(text, {{from, to}});
    EXPECT_NE(changed, text) << from;
    EXPECT_FALSE(ParseModelIndex(changed).ok()) << changed;
  }
}

TEST(ModelIndex, ScenesMayBeMissingAndModelsEmpty) {
  const auto index = ParseModelIndex(R"({"models":[]})");
  ASSERT_TRUE(index.ok()) << index.status();
  EXPECT_TRUE(index->models.empty());
}

TEST(ModelIndex, RefusesWhatItDoesNotKnowAndSaysWhere) {
  const std::string model = Index().substr(11, Index().find("],") - 11);
  const struct {
    std::string text;
    const char* said;
  } cases[] = {
      {"", "not JSON"},
      {"[]", "not an object"},
      {"{}", "lacks models"},
      {R"({"models":{}})", "models: is not a list"},
      {R"({"models":[],"more":1})", "unknown key"},
      {R"({"models":[],"models":[]})", "twice"},
      {IndexWith("\"kitchen\",", "\"../etc\","), "models[0].scene"},
      {IndexWith("\"7\"", "\".7\""), "models[0].version"},
      {IndexWith("\"7\"", "7"), "models[0].version: is not a string"},
      {IndexWith(":12,", ":0,"), "models[0].bytes"},
      {IndexWith(":12,", ":-12,"), "models[0].bytes"},
      {IndexWith(":12,", ":1.5,"), "models[0].bytes"},
      {IndexWith(":12,", ":68719476737,"), "models[0].bytes"},
      {IndexWith(":12,", ":1e999,"), "out of range"},
      {IndexWith("e3b0", "E3B0"), "models[0].sha256"},
      {IndexWith("e3b0", "3b0"), "models[0].sha256"},
      {IndexWith("?sig", " sig"), "models[0].url"},
      {IndexWith("?sig", "\\nsig"), "models[0].url"},
      {IndexWith("\"bytes\"", "\"size\""), "models[0]: has an unknown key"},
      {IndexWith("\"bytes\":12,", ""), "models[0]: lacks bytes"},
      {IndexWith("],", absl::StrCat(",", model, "],")), "models[1]"},
      {IndexWith("{\"display_name\":\"K\\u00fcche\"}", "3"),
       "scenes.kitchen: is not an object"},
      {IndexWith("{\"kitchen\"", "{\"kit/chen\""), "scenes"},
      {IndexWith("\"K\\u00fcche\"",
                 std::string(100, '[') + std::string(100, ']')),
       "too deeply"},
  };
  for (const auto& [text, said] : cases) {
    const auto index = ParseModelIndex(text);
    EXPECT_EQ(index.status().code(), absl::StatusCode::kInvalidArgument)
        << text;
    EXPECT_THAT(std::string(index.status().message()), HasSubstr(said));
  }
}

TEST(ModelIndex, NestingCannotExhaustTheStack) {
  const std::string deep(4u << 20, '[');
  EXPECT_FALSE(ParseModelIndex(deep).ok());
  EXPECT_FALSE(ParseModelIndex(deep + std::string(4u << 20, ']')).ok());
}

TEST(ModelIndex, ErrorsRepeatNoUrl) {
  for (const std::string& text :
       {IndexWith("SECRET\"}", "SECRET\""), IndexWith("?sig", " sig"),
        IndexWith("SECRET", "SECRET\\x")}) {
    const auto index = ParseModelIndex(text);
    ASSERT_FALSE(index.ok());
    EXPECT_THAT(std::string(index.status().message()),
                Not(HasSubstr("SECRET")));
  }
}

TEST(ModelIndex, TooManyBytesAreRefusedUnread) {
  const auto index = ParseModelIndex(std::string(kMaxIndexBytes + 1, ' '));
  EXPECT_THAT(std::string(index.status().message()), HasSubstr("at most"));
}

}  // namespace
}  // namespace treeline::repository
