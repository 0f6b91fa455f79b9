// A `treeline-agent run` of a test's own, and who talks to it.
#ifndef TESTS_INTEGRATION_AGENT_RUN_FIXTURE_H_
#define TESTS_INTEGRATION_AGENT_RUN_FIXTURE_H_

#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <httplib.h>
#include <signal.h>
#include <stdlib.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "nav_agent/app/run/agent_robot.h"
#include "nav_agent/map_bundle/map_bundle.h"
#include "nav_agent/octomap/octree_file.h"
#include "nav_agent/traversability/level_files.h"
#include "tests/integration/process.h"
#include "treeline/v1/navigation.grpc.pb.h"

namespace treeline {

// The cafe: where its tour begins, and a place at the other end of its
// counter, 7.4 m away.
inline constexpr char kStart[] = "1.6,7.9,0";
inline constexpr double kGoalX_m = 9.0;
inline constexpr double kGoalY_m = 7.7;

class AgentRunTest : public testing::Test {
 protected:
  void SetUp() override {
    // httplib's client writes on to a program that has ended.
    signal(SIGPIPE, SIG_IGN);
    std::string folder = testing::TempDir() + "/agent-XXXXXX";
    ASSERT_NE(mkdtemp(folder.data()), nullptr);
    folder_ = folder;
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  // Starts the agent on free ports and waits until it drives.
  void StartAgent(const std::vector<std::string>& arguments,
                  const std::string& shell_before = "") {
    std::vector<std::string> command = {TREELINE_AGENT,  "run",
                                        "--listen",      "127.0.0.1:0",
                                        "--http-listen", "127.0.0.1:0"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    if (!shell_before.empty()) {
      command.insert(command.begin(),
                     {"/bin/bash", "-c", shell_before + "; exec \"$@\"", "sh"});
    }
    agent_ = std::make_unique<Process>(command);
    const auto grpc = agent_->WaitForLine("grpc on ");
    ASSERT_TRUE(grpc.has_value()) << agent_->err();
    const auto page = agent_->WaitForLine("page on ");
    ASSERT_TRUE(page.has_value()) << agent_->err();
    ASSERT_TRUE(agent_->WaitForLine("driving").has_value()) << agent_->err();
    grpc_ = std::string(absl::StripPrefix(*grpc, "grpc on "));
    page_ = std::string(absl::StripPrefix(*page, "page on "));
    page_.pop_back();
    stub_ = v1::NavigationService::NewStub(
        grpc::CreateChannel(grpc_, grpc::InsecureChannelCredentials()));
  }

  // A bundle of the cafe's perfect map, as mapping would leave it.
  static void WriteMap(const std::string& folder) {
    const auto map = run_app::MapOfWorld("cafe");
    ASSERT_TRUE(map.ok()) << map.status();
    ASSERT_TRUE(map_bundle::BeginMapBundle(folder, /*overwrite=*/false).ok());
    const std::string octomap = folder + "/" + map_bundle::kBundleOctomap;
    ASSERT_TRUE(octree::WriteOctree(map->voxels, octomap).ok());
    // A file ends where what is known ends, the world's voxels with the world.
    const auto voxels = octree::ReadOctree(octomap);
    ASSERT_TRUE(voxels.ok()) << voxels.status();
    const auto levels = traversability::ExtractTraversableMap(*voxels);
    ASSERT_TRUE(levels.ok()) << levels.status();
    map_bundle::MapBundleManifest manifest;
    manifest.name = "cafe";
    manifest.levels = static_cast<int>(levels->levels.size());
    manifest.resolution_m = voxels->resolution_m();
    manifest.poses = 1;
    const std::vector<dataset::TimedPose> trajectory = {{5, {}}};
    ASSERT_TRUE(traversability::WriteTraversableMap(
                    *levels, manifest.traversability.max_slope_rad,
                    folder + "/" + map_bundle::kBundleLevels)
                    .ok());
    ASSERT_TRUE(map_bundle::WriteBundleTrajectory(folder, trajectory).ok());
    ASSERT_TRUE(map_bundle::FinishMapBundle(folder, manifest).ok());
  }

  // Drives there; the last that is heard of it.
  v1::NavigateResponse DriveTo(double x_m, double y_m) {
    v1::NavigateRequest request;
    v1::LevelPose& pose = *request.add_poses();
    pose.set_x_m(x_m);
    pose.set_y_m(y_m);
    grpc::ClientContext context;
    const auto stream = stub_->Navigate(&context, request);
    v1::NavigateResponse feedback;
    while (stream->Read(&feedback)) ++feedbacks_;
    const grpc::Status status = stream->Finish();
    EXPECT_TRUE(status.ok()) << status.error_message() << agent_->err();
    return feedback;
  }

  // Waits for the first step: 503 says that there was none.
  nlohmann::json Get(const std::string& path) const {
    auto answer = httplib::Client(page_).Get(path);
    for (int i = 0; i < 600 && answer && answer->status == 503; ++i) {
      absl::SleepFor(absl::Milliseconds(100));
      answer = httplib::Client(page_).Get(path);
    }
    if (!answer || answer->status != 200) {
      ADD_FAILURE() << path << " " << (answer ? answer->body : "no answer");
      return nullptr;
    }
    return nlohmann::json::parse(answer->body);
  }
  // The first state that `holds`; null if there is none for a minute.
  nlohmann::json StateWhere(
      const std::function<bool(const nlohmann::json&)>& holds) const {
    for (int i = 0; i < 1200; ++i) {
      nlohmann::json state = Get("/api/state");
      if (state.is_null() || holds(state)) return state;
      absl::SleepFor(absl::Milliseconds(50));
    }
    ADD_FAILURE() << "the state is still " << Get("/api/state");
    return nullptr;
  }
  grpc::Status Stop(const std::string& why, v1::StopResponse& response) {
    v1::StopRequest request;
    request.set_why(why);
    grpc::ClientContext context;
    return stub_->Stop(&context, request, &response);
  }
  grpc::Status Release() {
    grpc::ClientContext context;
    v1::ReleaseResponse response;
    return stub_->Release(&context, {}, &response);
  }
  grpc::Status Drive(double forward_mps, uint64_t sequence,
                     const std::string& driver = "test") {
    v1::DriveRequest request;
    request.set_forward_mps(forward_mps);
    request.set_driver(driver);
    request.set_sequence(sequence);
    grpc::ClientContext context;
    v1::DriveResponse response;
    return stub_->Drive(&context, request, &response);
  }
  grpc::Status Navigate(double x_m, double y_m) {
    v1::NavigateRequest request;
    request.add_poses()->set_x_m(x_m);
    request.mutable_poses(0)->set_y_m(y_m);
    request.set_keep_when_call_ends(true);
    grpc::ClientContext context;
    const auto stream = stub_->Navigate(&context, request);
    v1::NavigateResponse first;
    if (stream->Read(&first)) context.TryCancel();
    return stream->Finish();
  }
  // A command of the program's own that talks to the agent: what it printed.
  std::string Ask(std::vector<std::string> command, int wanted_exit = 0) {
    command.insert(command.begin(), TREELINE_AGENT);
    command.insert(command.end(), {"--agent", grpc_});
    const ProgramResult result = RunProgram(command);
    EXPECT_EQ(result.exit_code, wanted_exit) << result.err;
    return result.out + result.err;
  }
  int Post(const std::string& path, const std::string& body) const {
    const auto answer = httplib::Client(page_).Post(path, {{"X-Treeline", "1"}},
                                                    body, "application/json");
    return answer ? answer->status : -1;
  }

  std::string folder_;
  std::string grpc_;
  std::string page_;
  int feedbacks_ = 0;
  std::unique_ptr<Process> agent_;
  std::unique_ptr<v1::NavigationService::Stub> stub_;
};

}  // namespace treeline

#endif  // TESTS_INTEGRATION_AGENT_RUN_FIXTURE_H_
