#include "common/base/child_process.h"

#include "common/base/testing_folder.h"
#include "gmock/gmock.h"
#include "gtest/gtest.h"

namespace treeline::base {
namespace {

using testing::HasSubstr;

TEST(ChildProcessTest, WhatItWritesIsInItsLog) {
  const TestingFolder folder;
  auto child = ChildProcess::Start({"/bin/sh", "-c", "echo out; echo err >&2"},
                                   folder.Path("logs/log"));
  ASSERT_TRUE(child.ok()) << child.status();
  EXPECT_TRUE((*child)->Wait({}).ok());
  EXPECT_EQ((*child)->ExitCode(), 0);
  EXPECT_EQ((*child)->Log(), "out\nerr\n");
}

TEST(ChildProcessTest, AFailureSaysHowItEndedAndWhy) {
  const TestingFolder folder;
  auto child = ChildProcess::Start({"/bin/sh", "-c", "echo no disk; exit 3"},
                                   folder.Path("log"));
  ASSERT_TRUE(child.ok()) << child.status();
  const absl::Status status = (*child)->Wait({});
  EXPECT_THAT(status.message(), HasSubstr("ended with 3"));
  EXPECT_THAT(status.message(), HasSubstr("no disk"));
}

TEST(ChildProcessTest, StoppingEndsIt) {
  const TestingFolder folder;
  auto child = ChildProcess::Start({"/bin/sleep", "600"}, folder.Path("log"));
  ASSERT_TRUE(child.ok()) << child.status();
  EXPECT_FALSE((*child)->ExitCode().has_value());
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(absl::IsCancelled((*child)->Wait(stop.get_token())));
}

TEST(ChildProcessTest, ReadsWhatItIsSentUntilTheEnd) {
  const TestingFolder folder;
  auto child = ChildProcess::StartWithInput({"/bin/cat"}, folder.Path("log"));
  ASSERT_TRUE(child.ok()) << child.status();
  EXPECT_EQ(*(*child)->Send("one "), 4);
  EXPECT_EQ(*(*child)->Send("two"), 3);
  (*child)->CloseInput();
  EXPECT_TRUE((*child)->Wait({}).ok());
  EXPECT_EQ((*child)->Log(), "one two");
}

// Neither one that does not read nor one that is gone stops who sends.
TEST(ChildProcessTest, SendingWaitsForNobody) {
  const TestingFolder folder;
  const std::string much(1 << 20, 'x');
  auto deaf =
      ChildProcess::StartWithInput({"/bin/sleep", "600"}, folder.Path("deaf"));
  ASSERT_TRUE(deaf.ok()) << deaf.status();
  EXPECT_LT(*(*deaf)->Send(much), much.size());
  EXPECT_EQ(*(*deaf)->Send(much), 0);

  auto gone = ChildProcess::StartWithInput({"/bin/true"}, folder.Path("gone"));
  ASSERT_TRUE(gone.ok()) << gone.status();
  EXPECT_TRUE((*gone)->Wait({}).ok());
  EXPECT_TRUE(absl::IsUnavailable((*gone)->Send("anything").status()));
}

TEST(ChildProcessTest, AProgramThatIsNotThereIsNotFound) {
  const TestingFolder folder;
  EXPECT_TRUE(absl::IsNotFound(
      ChildProcess::Start({folder.Path("none")}, folder.Path("log")).status()));
}

TEST(FindProgramTest, FindsWhatTheShellWouldRun) {
  EXPECT_THAT(FindProgram("sh"), testing::EndsWith("/sh"));
  EXPECT_EQ(FindProgram("/bin/sh"), "/bin/sh");
  EXPECT_EQ(FindProgram("no-such-program"), "");
  EXPECT_EQ(FindProgram("/etc/passwd"), "") << "it may not be run";
  EXPECT_EQ(FindProgram("/bin"), "") << "a folder";
}

}  // namespace
}  // namespace treeline::base
