#include "nav_agent/app/navigate/navigate_command.h"

#include <grpcpp/grpcpp.h>

#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_split.h"
#include "common/base/status_macros.h"
#include "nav_agent/app/agent_command/agent_command.h"
#include "nav_agent/app/run/agent_config.h"
#include "nav_agent/service/agent_stub.h"

namespace treeline::navigate_app {
namespace {

using agent_service::AgentStub;
using agent_service::CallStatus;
using agent_service::EnumWord;

constexpr const char* kFooter = R"(
Shows how the robot gets on until it is there. Ctrl-C cancels the goal, unless
--keep. Exit codes: 0 there, 1 not (and why), 2 wrong usage, 130 interrupted.

Examples:
  treeline-agent navigate 4,2,0
  treeline-agent navigate --agent 127.0.0.1:50061 4,2,0 7.5,1,1.57,1)";

struct NavigateFlags {
  std::string agent = agent_service::kAgentAddress;
  std::vector<std::string> poses;
  bool keep = false;
  bool quiet = false;
};

std::string ModeWord(const v1::NavigateResponse& feedback) {
  return EnumWord(v1::NavigatorMode_Name(feedback.mode()), "NAVIGATOR_MODE_");
}

std::string LineOf(const v1::NavigateResponse& feedback) {
  const v1::LevelPose& pose = feedback.map_from_base();
  return absl::StrFormat(
      "%-12s %6.2f m to go, %6.2f m driven, at %.2f, %.2f level %d, %.2f m/s",
      ModeWord(feedback), feedback.goal().to_go_m(), feedback.goal().driven_m(),
      pose.x_m(), pose.y_m(), pose.level(), feedback.forward_mps());
}

absl::Status ResultOf(const v1::GoalStatus& goal) {
  if (goal.state() == v1::GOAL_STATE_SUCCEEDED) {
    std::printf("there: %.2f m driven, %d replans, %d recoveries\n",
                goal.driven_m(), goal.replans(), goal.recoveries());
    return absl::OkStatus();
  }
  return absl::AbortedError(absl::StrCat(
      "not there: ",
      EnumWord(v1::NavigationCause_Name(goal.cause()), "NAVIGATION_CAUSE_"),
      goal.why().empty() ? "" : ": ", goal.why()));
}

absl::StatusOr<v1::NavigateRequest> RequestOf(const NavigateFlags& flags) {
  v1::NavigateRequest request;
  for (const std::string& text : flags.poses) {
    TL_ASSIGN_OR_RETURN(
        const std::optional<agent_service::RequestedPose> wish,
        run_app::ParseRequestedPose(absl::StrSplit(text, ','), "POSE"));
    v1::LevelPose& pose = *request.add_poses();
    pose.set_x_m(wish->x_m);
    pose.set_y_m(wish->y_m);
    pose.set_yaw_rad(wish->yaw_rad);
    pose.set_level(wish->level);
  }
  request.set_keep_when_call_ends(flags.keep);
  return request;
}

absl::Status Navigate(const NavigateFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const v1::NavigateRequest request, RequestOf(flags));
  const auto stub = AgentStub(flags.agent);
  grpc::ClientContext context;
  const std::stop_callback on_stop(stop, [&] { context.TryCancel(); });
  const auto stream = stub->Navigate(&context, request);
  v1::NavigateResponse feedback;
  agent_command::Follow(*stream, flags.quiet, LineOf, feedback);
  TL_RETURN_IF_ERROR(CallStatus(flags.agent, stream->Finish()));
  return ResultOf(feedback.goal());
}

}  // namespace

cli::Command AddNavigateCommand(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("navigate", "Send a running agent to a pose");
  command->footer(kFooter);
  auto flags = std::make_shared<NavigateFlags>();
  command->add_option("--agent", flags->agent, "Where it answers gRPC")
      ->type_name("HOST:PORT")
      ->capture_default_str();
  command
      ->add_option("poses", flags->poses,
                   "Driven through in order, in the map (m, rad)")
      ->type_name("X,Y,YAW[,LEVEL]")
      ->required();
  command->add_flag("--keep", flags->keep,
                    "The robot drives on when this program ends");
  command->add_flag("--quiet", flags->quiet, "Only the result");
  return {command, [flags](const std::stop_token& stop) {
            return Navigate(*flags, stop);
          }};
}

}  // namespace treeline::navigate_app
