#include "simulation/emulators/fault_plan.h"

#include <string>

#include "gtest/gtest.h"
#include "simulation/emulators/byte_faults.h"
#include "simulation/emulators/emulator_server.h"

namespace treeline::emulators {
namespace {

constexpr base::MonotonicTime kNow =
    base::MonotonicTime() + std::chrono::hours(1);

std::string Joined(const std::vector<std::string>& writes) {
  std::string all;
  for (const std::string& write : writes) all += write;
  return all;
}

TEST(FaultPlanTest, EachFaultHasItsTime) {
  DeviceFaultPlan plan;
  for (const char* text : {"corrupt:0.001", "unplug@10+3", "error:52@5",
                           "skew:-200@1+1", "merge:0.05@20"}) {
    ASSERT_TRUE(plan.Add(text).ok()) << text;
  }
  EXPECT_EQ(plan.At(0), ActiveFaults{.corrupt = 0.001});
  EXPECT_EQ(plan.At(1).skew_ppm, -200);
  EXPECT_EQ(plan.At(2).skew_ppm, 0);
  EXPECT_FALSE(plan.At(9.99).unplugged);
  EXPECT_TRUE(plan.At(10).unplugged);
  EXPECT_FALSE(plan.At(13).unplugged);
  EXPECT_EQ(plan.At(1e9).error_status, 52);
  EXPECT_EQ(plan.At(20).merge_s, 0.05);
}

TEST(FaultPlanTest, SaysWhatIsWrong) {
  for (const char* text : {"", "fire", "corrupt", "corrupt:2", "corrupt:x",
                           "stuck:1", "unplug@x", "unplug@-1", "unplug@1+0",
                           "unplug@1+x", "error:0", "error:100", "merge:-1"}) {
    DeviceFaultPlan plan;
    EXPECT_TRUE(absl::IsInvalidArgument(plan.Add(text))) << text;
  }
}

TEST(ByteFaultsTest, LeavesBytesAloneWithoutFaults) {
  ByteFaults faults(1);
  EXPECT_EQ(Joined(faults.Apply("hello", {}, kNow)), "hello");
  EXPECT_TRUE(faults.Apply("", {}, kNow).empty());
}

TEST(ByteFaultsTest, ChangesAndLosesAsOftenAsAskedFor) {
  const std::string bytes(100'000, 'x');
  ByteFaults corrupt(1);
  int changed = 0;
  for (const char c : Joined(corrupt.Apply(bytes, {.corrupt = 0.1}, kNow))) {
    changed += c != 'x' ? 1 : 0;
  }
  // A standard error of 95.
  EXPECT_NEAR(changed, 10'000, 500);
  ByteFaults drop(1);
  EXPECT_NEAR(static_cast<double>(
                  Joined(drop.Apply(bytes, {.drop = 0.1}, kNow)).size()),
              90'000, 500);
  ByteFaults same(1);
  ByteFaults again(1);
  EXPECT_EQ(Joined(same.Apply(bytes, {.corrupt = 0.1}, kNow)),
            Joined(again.Apply(bytes, {.corrupt = 0.1}, kNow)));
}

TEST(ByteFaultsTest, SplitsAndMergesWithoutLoss) {
  ByteFaults split(1);
  const std::string bytes(1000, 'x');
  const auto pieces = split.Apply(bytes, {.split_bytes = 7}, kNow);
  EXPECT_GT(pieces.size(), 150u);
  EXPECT_EQ(Joined(pieces), bytes);
  for (const std::string& piece : pieces) EXPECT_LE(piece.size(), 7u);

  ByteFaults merge(1);
  const ActiveFaults late = {.merge_s = 0.05};
  EXPECT_TRUE(merge.Apply("a", late, kNow).empty());
  EXPECT_TRUE(
      merge.Apply("b", late, kNow + std::chrono::milliseconds(49)).empty());
  EXPECT_EQ(
      Joined(merge.Apply("c", late, kNow + std::chrono::milliseconds(50))),
      "abc");
}

TEST(DeviceAddressTest, UnderstandsWhatItSays) {
  const auto symlink = [](const char* text) {
    return std::get<PtyAddress>(ParseDeviceAddress(text).value()).symlink;
  };
  EXPECT_EQ(symlink("pty"), "");
  EXPECT_EQ(symlink("pty:/tmp/ttyLaser"), "/tmp/ttyLaser");
  const auto tcp = [](const char* text) {
    return std::get<base::ListenAddress>(ParseDeviceAddress(text).value())
        .ToString();
  };
  EXPECT_EQ(tcp("tcp:10940"), "127.0.0.1:10940");
  EXPECT_EQ(tcp("tcp:0.0.0.0:10940"), "0.0.0.0:10940");
  for (const char* text :
       {"", "pty:", "tcp:", "tcp:x", "tcp::1", "tcp:65536", "udp:1", "10940"}) {
    EXPECT_TRUE(absl::IsInvalidArgument(ParseDeviceAddress(text).status()))
        << text;
  }
}

}  // namespace
}  // namespace treeline::emulators
