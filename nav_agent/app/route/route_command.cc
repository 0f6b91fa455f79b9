#include "nav_agent/app/route/route_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "nav_agent/app/agent_command/agent_command.h"
#include "nav_agent/app/route/route_yaml.h"
#include "nav_agent/service/agent_stub.h"
#include "nav_agent/service/routes_wire.h"

namespace treeline::route_app {
namespace {

using agent_command::AddTo;
using agent_service::CallStatus;
using agent_service::EnumWord;

constexpr const char* kFooter = R"(
Files of routes: docs/reference/routes.md.

Examples:
  treeline-agent route save routes.yaml
  treeline-agent route run patrol
  treeline-agent route list)";
constexpr const char* kRunFooter = R"(
Shows how the robot gets on until the route is over. Ctrl-C cancels it, unless
--keep. Exit codes: 0 at its end, 1 not (and why), 2 wrong usage, 130
interrupted. Waypoints that were missed are listed either way.)";

constexpr uint64_t kMaxFileBytes = 1u << 20;

struct RouteFlags {
  std::string agent = agent_service::kAgentAddress;
  std::string file;
  std::vector<std::string> names;
  int first = 1;
  bool keep = false;
  bool quiet = false;
};

absl::StatusOr<v1::GetRoutesResponse> GetRoutes(const RouteFlags& flags) {
  grpc::ClientContext context;
  v1::GetRoutesResponse routes;
  TL_RETURN_IF_ERROR(CallStatus(
      flags.agent,
      agent_service::AgentStub(flags.agent)->GetRoutes(&context, {}, &routes)));
  return routes;
}

absl::StatusOr<std::vector<routes::Route>> ReadRoutes(const std::string& path) {
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(path, kMaxFileBytes));
  return ParseRoutes(text, path);
}

void Warn(const std::string& warning) {
  if (!warning.empty()) std::fprintf(stderr, "note: %s\n", warning.c_str());
}

absl::Status List(const RouteFlags& flags) {
  TL_ASSIGN_OR_RETURN(const v1::GetRoutesResponse found, GetRoutes(flags));
  for (const v1::Route& route : found.routes()) {
    double wait_s = 0;
    for (const v1::Waypoint& waypoint : route.waypoints()) {
      wait_s += waypoint.wait_s();
    }
    std::printf("%s: %d waypoint%s%s, waits %.0f s\n", route.name().c_str(),
                route.waypoints_size(), route.waypoints_size() == 1 ? "" : "s",
                route.loop() ? " in a loop" : "", wait_s);
  }
  if (found.routes().empty()) std::printf("no route is kept\n");
  if (found.has_current()) {
    std::printf("under way, held or offered: %s\n",
                found.current().name().empty()
                    ? "a route without a name"
                    : found.current().name().c_str());
  }
  Warn(found.warning());
  return absl::OkStatus();
}

absl::Status Export(const RouteFlags& flags) {
  TL_ASSIGN_OR_RETURN(const v1::GetRoutesResponse found, GetRoutes(flags));
  std::vector<routes::Route> kept;
  for (const v1::Route& proto : found.routes()) {
    TL_ASSIGN_OR_RETURN(routes::Route route, agent_service::FromProto(proto));
    kept.push_back(std::move(route));
  }
  std::printf("%s", RoutesText(kept).c_str());
  return absl::OkStatus();
}

absl::Status Save(const RouteFlags& flags) {
  TL_ASSIGN_OR_RETURN(const std::vector<routes::Route> routes,
                      ReadRoutes(flags.file));
  v1::PutRoutesRequest request;
  for (const routes::Route& route : routes) {
    *request.add_routes() = agent_service::ToProto(route);
  }
  grpc::ClientContext context;
  v1::PutRoutesResponse response;
  TL_RETURN_IF_ERROR(
      CallStatus(flags.agent, agent_service::AgentStub(flags.agent)
                                  ->PutRoutes(&context, request, &response)));
  std::printf("routes kept: %d\n", request.routes_size());
  Warn(response.warning());
  return absl::OkStatus();
}

absl::Status Delete(const RouteFlags& flags) {
  v1::RemoveRoutesRequest request;
  request.mutable_names()->Add(flags.names.begin(), flags.names.end());
  grpc::ClientContext context;
  v1::RemoveRoutesResponse response;
  TL_RETURN_IF_ERROR(CallStatus(
      flags.agent, agent_service::AgentStub(flags.agent)
                       ->RemoveRoutes(&context, request, &response)));
  std::printf("routes no longer kept: %d\n", request.names_size());
  return absl::OkStatus();
}

absl::Status Resume(const RouteFlags& flags) {
  grpc::ClientContext context;
  v1::ResumeRouteResponse response;
  TL_RETURN_IF_ERROR(
      CallStatus(flags.agent, agent_service::AgentStub(flags.agent)
                                  ->ResumeRoute(&context, {}, &response)));
  std::printf("the route goes on\n");
  return absl::OkStatus();
}

absl::Status Cancel(const RouteFlags& flags) {
  grpc::ClientContext context;
  v1::CancelRouteResponse response;
  TL_RETURN_IF_ERROR(
      CallStatus(flags.agent, agent_service::AgentStub(flags.agent)
                                  ->CancelRoute(&context, {}, &response)));
  std::printf("the route is ended\n");
  return absl::OkStatus();
}

// ---- run ----

absl::StatusOr<v1::RunRouteRequest> RequestOf(const RouteFlags& flags) {
  v1::RunRouteRequest request;
  const std::string name = flags.names.empty() ? "" : flags.names.front();
  if (flags.file.empty() && name.empty()) {
    return absl::InvalidArgumentError(
        "name a route that is kept, or one of --file");
  }
  if (flags.file.empty()) {
    request.set_kept(name);
  } else {
    TL_ASSIGN_OR_RETURN(const std::vector<routes::Route> routes,
                        ReadRoutes(flags.file));
    for (const routes::Route& route : routes) {
      if (!name.empty() && route.name != name) continue;
      *request.mutable_route() = agent_service::ToProto(route);
      break;
    }
    if (!request.has_route()) {
      return absl::NotFoundError(absl::StrCat(
          flags.file, " has no route that is called '", name, "'"));
    }
  }
  request.set_first_waypoint(flags.first - 1);
  request.set_keep_when_call_ends(flags.keep);
  return request;
}

std::string LineOf(const v1::RunRouteResponse& feedback) {
  const v1::RouteStatus& route = feedback.route();
  std::string what =
      EnumWord(v1::RouteState_Name(route.state()), "ROUTE_STATE_");
  if (route.state() == v1::ROUTE_STATE_WAITING) {
    absl::StrAppend(&what, " ", static_cast<int>(route.waited_s()), " of ",
                    static_cast<int>(route.wait_s()), " s");
  }
  return absl::StrFormat(
      "waypoint %d of %d%s%s, lap %d: %s (%s), %.2f m to go",
      route.waypoint() + 1, route.waypoints(),
      route.waypoint_name().empty() ? "" : " ", route.waypoint_name(),
      route.lap() + 1, what,
      EnumWord(v1::NavigatorMode_Name(feedback.mode()), "NAVIGATOR_MODE_"),
      feedback.goal().to_go_m());
}

absl::Status ResultOf(const v1::RouteStatus& route) {
  for (const v1::MissedWaypoint& missed : route.last_missed()) {
    std::printf("missed waypoint %d in lap %d (%s): %s\n",
                missed.waypoint() + 1, static_cast<int>(missed.lap()) + 1,
                missed.cause().c_str(), missed.why().c_str());
  }
  if (route.state() == v1::ROUTE_STATE_SUCCEEDED) {
    std::printf("over: %s\n", route.why().c_str());
    return absl::OkStatus();
  }
  return absl::AbortedError(
      absl::StrCat(EnumWord(v1::RouteState_Name(route.state()), "ROUTE_STATE_"),
                   ": ", route.why()));
}

absl::Status Run(const RouteFlags& flags, const std::stop_token& stop) {
  TL_ASSIGN_OR_RETURN(const v1::RunRouteRequest request, RequestOf(flags));
  const auto stub = agent_service::AgentStub(flags.agent);
  grpc::ClientContext context;
  const std::stop_callback on_stop(stop, [&] { context.TryCancel(); });
  const auto stream = stub->RunRoute(&context, request);
  v1::RunRouteResponse feedback;
  agent_command::Follow(*stream, flags.quiet, LineOf, feedback);
  TL_RETURN_IF_ERROR(CallStatus(flags.agent, stream->Finish()));
  return ResultOf(feedback.route());
}

// ---- commands ----

cli::Command AddRun(CLI::App& group, const std::shared_ptr<RouteFlags>& flags) {
  const cli::Command command =
      AddTo(group, "run", "Drive a route, and follow it", flags, Run);
  command.app->footer(kRunFooter);
  command.app->add_option("name", flags->names, "One that is kept")
      ->type_name("NAME")
      ->expected(0, 1);
  command.app
      ->add_option("--file", flags->file,
                   "One of this file instead: the first, or the one named")
      ->type_name("FILE");
  command.app->add_option("--first", flags->first, "Begin with this waypoint")
      ->type_name("N")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command.app->add_flag("--keep", flags->keep,
                        "The robot drives on when this program ends");
  command.app->add_flag("--quiet", flags->quiet, "Only the result");
  return command;
}

}  // namespace

cli::Command AddRouteCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand(
      "route", "Keep, run and end routes of a running agent");
  group->require_subcommand(1);
  group->footer(kFooter);
  auto flags = std::make_shared<RouteFlags>();
  std::vector<cli::Command> commands = {
      AddTo(*group, "list", "Routes that are kept", flags, List),
      AddTo(*group, "export", "The same, as a file that `save` reads", flags,
            Export),
      AddTo(*group, "save", "Keep the routes of a file", flags, Save),
      AddTo(*group, "delete", "Keep these no longer", flags, Delete),
      AddTo(*group, "resume", "Go on with a route that is held or offered",
            flags, Resume),
      AddTo(*group, "cancel", "End the route, wherever it is", flags, Cancel),
      AddRun(*group, flags)};
  agent_command::AddFile(commands[2], flags->file);
  agent_command::AddNames(commands[3], flags->names);
  return {group, cli::RunChosen(std::move(commands))};
}

}  // namespace treeline::route_app
