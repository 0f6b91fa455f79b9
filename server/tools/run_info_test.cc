#include "server/tools/run_info.h"

#include <string>

#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::tools {
namespace {

using ::testing::HasSubstr;

TEST(ShellQuoted, QuotesOnlyWhatAShellWouldChange) {
  EXPECT_EQ(ShellQuoted("--model=a/b_c-1.treeline"),
            "--model=a/b_c-1.treeline");
  EXPECT_EQ(ShellQuoted("7scenes:dir"), "7scenes:dir");
  EXPECT_EQ(ShellQuoted("a b"), "'a b'");
  EXPECT_EQ(ShellQuoted("it's"), "'it'\\''s'");
  EXPECT_EQ(ShellQuoted("$HOME"), "'$HOME'");
  EXPECT_EQ(ShellQuoted(""), "''");
}

TEST(RunInfo, TellsAboutThisProcess) {
  EXPECT_THAT(CommandLine(), HasSubstr("tools_test"));
  EXPECT_GT(PeakMemoryBytes(), 1u << 20);
  EXPECT_THAT(CpuDescription(), HasSubstr("processor"));
  EXPECT_EQ(UtcNow().size(), std::string("2026-11-21T09:30:00Z").size());
}

}  // namespace
}  // namespace treeline::tools
