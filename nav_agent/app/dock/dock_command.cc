#include "nav_agent/app/dock/dock_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"
#include "common/base/status_macros.h"
#include "nav_agent/app/agent_command/agent_command.h"
#include "nav_agent/service/agent_stub.h"

namespace treeline::dock_app {
namespace {

using agent_command::AddTo;
using agent_service::CallStatus;
using agent_service::DockingStub;

constexpr const char* kFooter = R"(
What docks are, and what the robot does with them: docs/reference/docks.md.

Examples:
  treeline-agent dock save charger --here
  treeline-agent dock save charger --at 4.2,1.5,1.57 --backward
  treeline-agent dock go charger)";
constexpr const char* kGoFooter = R"(
Shows how the robot gets on until it is docked. Ctrl-C cancels it, unless --keep.
Exit codes: 0 docked, 1 not (and why), 2 wrong usage, 130 interrupted.)";

struct DockFlags {
  std::string agent = agent_service::kAgentAddress;
  std::vector<std::string> names;
  bool here = false;
  std::vector<double> at;
  bool backward = false;
  double staging_m = 0;
  bool keep = false;
  bool quiet = false;
};

void Warn(const std::string& warning) {
  if (!warning.empty()) std::fprintf(stderr, "note: %s\n", warning.c_str());
}

// "driving in".
std::string Word(const std::string& name, absl::string_view prefix) {
  return absl::StrReplaceAll(agent_service::EnumWord(name, prefix),
                             {{"_", " "}});
}

std::string Described(const v1::Dock& dock) {
  return absl::StrFormat(
      "%s: at (%.3f, %.3f), %.3f rad, level %d, %s from "
      "%.2f m",
      dock.name(), dock.x_m(), dock.y_m(), dock.yaw_rad(), dock.level(),
      dock.backward() ? "backward" : "forward", dock.staging_m());
}

absl::StatusOr<v1::GetDocksResponse> GetDocks(const DockFlags& flags) {
  grpc::ClientContext context;
  v1::GetDocksResponse found;
  TL_RETURN_IF_ERROR(CallStatus(
      flags.agent, DockingStub(flags.agent)->GetDocks(&context, {}, &found)));
  return found;
}

absl::Status List(const DockFlags& flags) {
  TL_ASSIGN_OR_RETURN(const v1::GetDocksResponse found, GetDocks(flags));
  for (const v1::Dock& dock : found.docks()) {
    std::printf("%s\n", Described(dock).c_str());
  }
  if (found.docks().empty()) std::printf("no dock is kept\n");
  Warn(found.warning());
  return absl::OkStatus();
}

absl::Status Save(const DockFlags& flags) {
  if (flags.here != flags.at.empty()) {
    return absl::InvalidArgumentError(
        "give either --here, or --at X,Y,YAW or X,Y,YAW,LEVEL in m and rad");
  }
  v1::PutDocksRequest request;
  request.set_here(flags.here);
  v1::Dock& dock = *request.add_docks();
  dock.set_name(flags.names.front());
  dock.set_backward(flags.backward);
  dock.set_staging_m(flags.staging_m);
  if (!flags.here) {
    dock.set_x_m(flags.at[0]);
    dock.set_y_m(flags.at[1]);
    dock.set_yaw_rad(flags.at[2]);
    if (flags.at.size() > 3) dock.set_level(static_cast<int>(flags.at[3]));
  }
  grpc::ClientContext context;
  v1::PutDocksResponse response;
  TL_RETURN_IF_ERROR(CallStatus(
      flags.agent,
      DockingStub(flags.agent)->PutDocks(&context, request, &response)));
  // With what the agent has made of it: where the robot stands, the staging.
  TL_ASSIGN_OR_RETURN(const v1::GetDocksResponse found, GetDocks(flags));
  for (const v1::Dock& kept : found.docks()) {
    if (kept.name() != dock.name()) continue;
    std::printf("dock kept: %s; %s\n", Described(kept).c_str(),
                response.survives_restart() ? "in the agent's state folder"
                                            : "until the agent ends");
  }
  Warn(response.warning());
  return absl::OkStatus();
}

absl::Status Delete(const DockFlags& flags) {
  v1::RemoveDocksRequest request;
  request.mutable_names()->Add(flags.names.begin(), flags.names.end());
  grpc::ClientContext context;
  v1::RemoveDocksResponse response;
  TL_RETURN_IF_ERROR(CallStatus(
      flags.agent,
      DockingStub(flags.agent)->RemoveDocks(&context, request, &response)));
  std::printf("docks no longer kept: %d\n", request.names_size());
  return absl::OkStatus();
}

absl::Status Out(const DockFlags& flags) {
  grpc::ClientContext context;
  v1::UndockResponse response;
  TL_RETURN_IF_ERROR(CallStatus(
      flags.agent, DockingStub(flags.agent)->Undock(&context, {}, &response)));
  std::printf("the robot drives straight out of its dock\n");
  return absl::OkStatus();
}

std::string LineOf(const v1::DockResponse& feedback) {
  const v1::DockingStatus& docking = feedback.docking();
  return absl::StrCat(
      docking.dock(), ": ",
      Word(v1::DockingState_Name(docking.state()), "DOCKING_STATE_"),
      docking.failed_tries() > 0
          ? absl::StrCat(", failed tries: ", docking.failed_tries())
          : "");
}

absl::Status Go(const DockFlags& flags, const std::stop_token& stop) {
  v1::DockRequest request;
  if (!flags.names.empty()) request.set_name(flags.names.front());
  request.set_keep_when_call_ends(flags.keep);
  const auto stub = DockingStub(flags.agent);
  grpc::ClientContext context;
  const std::stop_callback on_stop(stop, [&] { context.TryCancel(); });
  const auto stream = stub->Dock(&context, request);
  v1::DockResponse feedback;
  agent_command::Follow(*stream, flags.quiet, LineOf, feedback);
  TL_RETURN_IF_ERROR(CallStatus(flags.agent, stream->Finish()));
  const v1::DockingStatus& docking = feedback.docking();
  if (docking.outcome() == v1::DOCKING_OUTCOME_SUCCEEDED) {
    std::printf("docked in %s: %s\n", docking.dock().c_str(),
                docking.why().c_str());
    return absl::OkStatus();
  }
  return absl::AbortedError(absl::StrCat(
      Word(v1::DockingOutcome_Name(docking.outcome()), "DOCKING_OUTCOME_"),
      ": ", docking.why()));
}

// ---- commands ----

cli::Command AddSave(CLI::App& group, const std::shared_ptr<DockFlags>& flags) {
  const cli::Command command =
      AddTo(group, "save", "Keep a dock under a name", flags, Save);
  command.app->add_option("name", flags->names, "Its name")
      ->type_name("NAME")
      ->expected(1)
      ->required();
  command.app->add_flag("--here", flags->here,
                        "The robot stands in it at this moment");
  command.app
      ->add_option("--at", flags->at,
                   "The robot's pose in the map when it is docked (m, rad)")
      ->type_name("X,Y,YAW[,LEVEL]")
      ->delimiter(',')
      ->expected(3, 4);
  command.app->add_flag("--backward", flags->backward,
                        "It drives in with its rear first");
  command.app
      ->add_option("--staging", flags->staging_m,
                   "From where it drives straight in, before that pose; 0: "
                   "what the robot needs (m)")
      ->type_name("METRES")
      ->capture_default_str();
  return command;
}

cli::Command AddGo(CLI::App& group, const std::shared_ptr<DockFlags>& flags) {
  const cli::Command command =
      AddTo(group, "go", "Drive into a dock, and follow it", flags, Go);
  command.app->footer(kGoFooter);
  command.app
      ->add_option("name", flags->names, "One that is kept; none: the nearest")
      ->type_name("NAME")
      ->expected(0, 1);
  command.app->add_flag("--keep", flags->keep,
                        "The robot goes on when this program ends");
  command.app->add_flag("--quiet", flags->quiet, "Only the result");
  return command;
}

}  // namespace

cli::Command AddDockCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand(
      "dock", "Keep docks of a running agent, and drive into and out of them");
  group->require_subcommand(1);
  group->footer(kFooter);
  auto flags = std::make_shared<DockFlags>();
  std::vector<cli::Command> commands = {
      AddTo(*group, "list", "Docks that are kept", flags, List),
      AddSave(*group, flags),
      AddTo(*group, "delete", "Keep these no longer", flags, Delete),
      AddGo(*group, flags),
      AddTo(*group, "out", "Drive straight out of the dock", flags, Out)};
  agent_command::AddNames(commands[2], flags->names);
  return {group, cli::RunChosen(std::move(commands))};
}

}  // namespace treeline::dock_app
