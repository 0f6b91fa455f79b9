// treeline-client as a process: what it prints, and what it exits with.
#include <csignal>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "common/image/decode.h"
#include "gmock/gmock.h"
#include "nlohmann/json.hpp"
#include "server/core/localizer/localizer.h"
#include "tests/integration/fixture.h"

namespace treeline {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class ClientProgram : public ServerTest {
 protected:
  ClientProgram() : frames_(HeldOutFrames()) {}

  void SetUp() override {
    ServerTest::SetUp();
    PutRoom();
    StartServer();
  }

  std::vector<std::string> FrameArguments(int i) const {
    return {"--scene", "room",
            "--color", frames_.frame(i).color_path,
            "--depth", frames_.frame(i).depth_path};
  }

  // A depth image in which nothing was measured.
  std::string PutBlindDepth() {
    const camera::Camera& camera = frames_.calibration().depth;
    image::DepthImage depth{
        .width = camera.width(), .height = camera.height(), .values = {}};
    depth.values.resize(static_cast<size_t>(depth.width) *
                        static_cast<size_t>(depth.height));
    return PutFile("blind.png", image::EncodeDepthPng(depth).value());
  }

  const dataset::Dataset frames_;
};

TEST_F(ClientProgram, LocalizesForPeople) {
  const ProgramResult result = RunClient("localize", FrameArguments(0));
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("LOCALIZED in room, version 1"),
                    HasSubstr("qw qx qy qz"), HasSubstr("round trip")));
}

TEST_F(ClientProgram, LocalizesForProgramsBitForBit) {
  std::vector<std::string> arguments = FrameArguments(0);
  arguments.insert(arguments.end(), {"--json", "--seed", "7"});
  const ProgramResult result = RunClient("localize", arguments);
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json["outcome"], "LOCALIZED");
  const Json& pose = json["world_from_camera"];
  const geometry::Rigid3 served{
      {pose["qw"], pose["qx"], pose["qy"], pose["qz"]},
      {pose["tx"], pose["ty"], pose["tz"]}};
  const auto localizer = localizer::OpenLocalizer(RoomModelPath());
  ASSERT_TRUE(localizer.ok()) << localizer.status();
  localizer::LocalizeOptions options;
  options.seed = 7;
  const auto offline = (*localizer)->Localize(frames_.Load(0).value(), options);
  ASSERT_TRUE(offline.ok()) << offline.status();
  EXPECT_EQ(served, offline->world_from_camera);
}

TEST_F(ClientProgram, WhatIsNotLocalizedExitsWith3) {
  const std::vector<std::string> arguments = {
      "--scene", "room",         "--color", frames_.frame(0).color_path,
      "--depth", PutBlindDepth()};
  const ProgramResult text = RunClient("localize", arguments);
  EXPECT_EQ(text.exit_code, 3) << text.err;
  EXPECT_THAT(text.out, HasSubstr("NOT LOCALIZED in room"));
  std::vector<std::string> with_json = arguments;
  with_json.push_back("--json");
  const ProgramResult json = RunClient("localize", with_json);
  EXPECT_EQ(json.exit_code, 3);
  EXPECT_EQ(Json::parse(json.out)["reason"], "TOO_FEW_SAMPLES");
}

TEST_F(ClientProgram, ErrorsExitWith1AndAreNamed) {
  std::vector<std::string> arguments = FrameArguments(0);
  arguments[1] = "attic";
  arguments.push_back("--json");
  const ProgramResult unknown = RunClient("localize", arguments);
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.err, AllOf(HasSubstr("NOT_FOUND"), HasSubstr("attic")));
  EXPECT_EQ(Json::parse(unknown.out)["code"], "NOT_FOUND");

  const ProgramResult no_file = RunClient(
      "localize", {"--scene", "room", "--color", folder_ + "/none.jpg"});
  EXPECT_EQ(no_file.exit_code, 1);
  EXPECT_THAT(no_file.err, HasSubstr("none.jpg"));

  const ProgramResult no_depth = RunClient(
      "localize", {"--scene", "room", "--color", frames_.frame(0).color_path});
  EXPECT_EQ(no_depth.exit_code, 1);
  EXPECT_THAT(no_depth.err, HasSubstr("INVALID_ARGUMENT"));
}

TEST_F(ClientProgram, AServerThatIsNotThereExitsWith1) {
  server_->Signal(SIGKILL);
  ASSERT_TRUE(server_->WaitForExit().has_value());
  const ProgramResult result = RunClient("localize", FrameArguments(0));
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, AllOf(HasSubstr("UNAVAILABLE"), HasSubstr(address_)));
}

TEST_F(ClientProgram, WrongUsageExitsWith2) {
  EXPECT_EQ(RunClient("localize", {"--scene", "room"}).exit_code, 2);
  EXPECT_EQ(RunClient("scenes", {"--no-such-flag"}).exit_code, 2);
  EXPECT_EQ(RunProgram({TREELINE_CLIENT_PROGRAM}).exit_code, 2);
  EXPECT_EQ(RunProgram({TREELINE_CLIENT_PROGRAM, "--help"}).exit_code, 0);
}

TEST_F(ClientProgram, AskAboutAListOverOneConnection) {
  const ProgramResult result = RunClient(
      "localize", {"--scene", "room", "--list", RecordingFolder() + "/test.txt",
                   "--root", RecordingFolder(), "--json"});
  EXPECT_EQ(result.exit_code, 0) << result.err;
  std::istringstream lines(result.out);
  std::string line;
  int count = 0;
  int localized = 0;
  while (std::getline(lines, line)) {
    const Json json = Json::parse(line);
    ASSERT_LT(count, frames_.size());
    EXPECT_EQ(json["stem"], frames_.frame(count).stem);
    EXPECT_EQ(json["scene"], "room");
    EXPECT_EQ(json["version"], "1");
    EXPECT_GT(json["round_trip_ms"], json["server"]["localize_ms"]);
    localized += json["outcome"] == "LOCALIZED";
    ++count;
  }
  EXPECT_EQ(count, frames_.size());
  // The model is small, but it is of this room.
  EXPECT_GE(localized, 0.8 * count);
  EXPECT_THAT(result.err,
              AllOf(HasSubstr("localizing"), HasSubstr("round trip p50")));
}

TEST_F(ClientProgram, AListWithABadFrameGoesOnAndExitsWith1) {
  const std::string& good_color = frames_.frame(0).color_path;
  const std::string& good_depth = frames_.frame(0).depth_path;
  std::filesystem::copy_file(good_color, folder_ + "/good.color.jpg");
  std::filesystem::copy_file(good_depth, folder_ + "/good.depth.png");
  PutFile("bad.color.jpg", "no image");
  std::filesystem::copy_file(good_depth, folder_ + "/bad.depth.png");
  const std::string list = PutFile("list.txt", "bad\ngood\n");
  const ProgramResult result = RunClient(
      "localize", {"--scene", "room", "--list", list, "--root", folder_});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.out, HasSubstr("bad  ERROR INVALID_ARGUMENT"));
  EXPECT_THAT(result.err, HasSubstr("2 frames: 1 localized, 0 not, 1 failed"));
}

TEST_F(ClientProgram, ListsScenes) {
  PutModel("broken", "1", "not a model");
  StartServer();
  const ProgramResult text = RunClient("scenes", {});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  EXPECT_THAT(text.out, AllOf(HasSubstr("room    READY     1"),
                              HasSubstr("broken  FAILED"),
                              HasSubstr("broken: DATA_LOSS")));
  const ProgramResult json = RunClient("scenes", {"--json"});
  EXPECT_EQ(json.exit_code, 0) << json.err;
  const Json scenes = Json::parse(json.out)["scenes"];
  ASSERT_EQ(scenes.size(), 2u);
  EXPECT_EQ(scenes[0]["scene"], "broken");
  EXPECT_EQ(scenes[1]["model"]["method"], "rgbd");
  EXPECT_EQ(RunClient("scenes", {"--scene", "attic"}).exit_code, 1);
}

}  // namespace
}  // namespace treeline
