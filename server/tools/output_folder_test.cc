#include "server/tools/output_folder.h"

#include <filesystem>
#include <optional>

#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::tools {
namespace {

using testing::HasSubstr;

TEST(OutputFolderTest, WhatIsNotKeptIsGone) {
  const base::TestingFolder folder;
  {
    const auto output = OutputFolder::Create(folder.Path("a/out/"));
    ASSERT_TRUE(output.ok()) << output.status();
    EXPECT_EQ(output->Path("page"), folder.Path("a/out/page"));
    folder.Write("a/out/recording/frame", "x");
  }
  EXPECT_FALSE(std::filesystem::exists(folder.Path("a/out")));
}

TEST(OutputFolderTest, WhatIsKeptStays) {
  const base::TestingFolder folder;
  {
    auto output = OutputFolder::Create(folder.Path("out"));
    ASSERT_TRUE(output.ok()) << output.status();
    OutputFolder moved = *std::move(output);
    folder.Write("out/page", "x");
    moved.Keep();
  }
  EXPECT_TRUE(std::filesystem::exists(folder.Path("out/page")));
}

TEST(OutputFolderTest, WhatOthersWroteIsNotTouched) {
  const base::TestingFolder folder;
  folder.Write("out/theirs", "x");
  folder.Write("file", "x");
  EXPECT_THAT(OutputFolder::Create(folder.Path("out")).status().message(),
              HasSubstr("out is there already"));
  EXPECT_FALSE(OutputFolder::Create(folder.Path("file")).ok());
  EXPECT_TRUE(std::filesystem::exists(folder.Path("out/theirs")));
  EXPECT_TRUE(std::filesystem::exists(folder.Path("file")));
}

TEST(OutputFolderTest, WhereNothingCanBeMadeIsKnownBefore) {
  const base::TestingFolder folder;
  folder.Write("file", "x");
  EXPECT_TRUE(CheckFolderCanBeMade(folder.Path("not/there/yet")).ok());
  EXPECT_FALSE(std::filesystem::exists(folder.Path("not")));
  EXPECT_TRUE(CheckFolderCanBeMade("models").ok());
  EXPECT_FALSE(CheckFolderCanBeMade(folder.Path("file/models")).ok());
}

}  // namespace
}  // namespace treeline::tools
