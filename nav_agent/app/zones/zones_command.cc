#include "nav_agent/app/zones/zones_command.h"

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "CLI/CLI.hpp"
#include "absl/strings/str_replace.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "nav_agent/app/agent_command/agent_command.h"
#include "nav_agent/app/zones/zones_yaml.h"
#include "nav_agent/service/agent_stub.h"
#include "nav_agent/service/zones_wire.h"

namespace treeline::zones_app {
namespace {

using agent_command::AddTo;
using agent_service::AgentStub;
using agent_service::CallStatus;

constexpr const char* kFooter = R"(
Files of zones: docs/reference/zones.md.

Examples:
  treeline-agent zones save zones.yaml
  treeline-agent zones list
  treeline-agent zones export > zones.yaml)";

constexpr uint64_t kMaxFileBytes = 1u << 20;

struct ZonesFlags {
  std::string agent = agent_service::kAgentAddress;
  std::string file;
  std::vector<std::string> names;
};

absl::StatusOr<v1::GetZonesResponse> GetZones(const ZonesFlags& flags) {
  grpc::ClientContext context;
  v1::GetZonesResponse zones;
  TL_RETURN_IF_ERROR(CallStatus(
      flags.agent, AgentStub(flags.agent)->GetZones(&context, {}, &zones)));
  return zones;
}

// "keep-out".
std::string KindWord(v1::ZoneKind kind) {
  return absl::StrReplaceAll(
      agent_service::EnumWord(v1::ZoneKind_Name(kind), "ZONE_KIND_"),
      {{"_", "-"}});
}

void Warn(const std::string& warning) {
  if (!warning.empty()) std::fprintf(stderr, "note: %s\n", warning.c_str());
}

absl::Status List(const ZonesFlags& flags) {
  TL_ASSIGN_OR_RETURN(const v1::GetZonesResponse found, GetZones(flags));
  for (const v1::Zone& zone : found.zones()) {
    std::printf("%s: %s, level %d, %d corners\n", zone.name().c_str(),
                KindWord(zone.kind()).c_str(), zone.level(),
                zone.corners_size());
  }
  for (const v1::ZoneMask& mask : found.masks()) {
    std::printf("%s: %s, level %d, a mask file\n", mask.name().c_str(),
                KindWord(mask.kind()).c_str(), mask.level());
  }
  if (found.zones().empty() && found.masks().empty()) {
    std::printf("there are no zones\n");
  }
  Warn(found.warning());
  return absl::OkStatus();
}

absl::Status Export(const ZonesFlags& flags) {
  TL_ASSIGN_OR_RETURN(const v1::GetZonesResponse found, GetZones(flags));
  std::vector<zones::Zone> drawn;
  for (const v1::Zone& proto : found.zones()) {
    TL_ASSIGN_OR_RETURN(zones::Zone zone, agent_service::FromProto(proto));
    drawn.push_back(std::move(zone));
  }
  std::printf("%s", ZonesText(drawn).c_str());
  return absl::OkStatus();
}

absl::Status Save(const ZonesFlags& flags) {
  TL_ASSIGN_OR_RETURN(const std::string text,
                      base::ReadFile(flags.file, kMaxFileBytes));
  TL_ASSIGN_OR_RETURN(const std::vector<zones::Zone> drawn,
                      ParseZones(text, flags.file));
  v1::PutZonesRequest request;
  for (const zones::Zone& zone : drawn) {
    *request.add_zones() = agent_service::ToProto(zone);
  }
  grpc::ClientContext context;
  v1::PutZonesResponse response;
  TL_RETURN_IF_ERROR(CallStatus(
      flags.agent,
      AgentStub(flags.agent)->PutZones(&context, request, &response)));
  std::printf("zones drawn: %d\n", request.zones_size());
  Warn(response.warning());
  return absl::OkStatus();
}

absl::Status Delete(const ZonesFlags& flags) {
  v1::RemoveZonesRequest request;
  request.mutable_names()->Add(flags.names.begin(), flags.names.end());
  grpc::ClientContext context;
  v1::RemoveZonesResponse response;
  TL_RETURN_IF_ERROR(CallStatus(
      flags.agent,
      AgentStub(flags.agent)->RemoveZones(&context, request, &response)));
  std::printf("zones removed: %d\n", request.names_size());
  return absl::OkStatus();
}

}  // namespace

cli::Command AddZonesCommand(CLI::App& app) {
  CLI::App* group = app.add_subcommand(
      "zones", "Draw and remove zones of a running agent, by files");
  group->require_subcommand(1);
  group->footer(kFooter);
  auto flags = std::make_shared<ZonesFlags>();
  std::vector<cli::Command> commands = {
      AddTo(*group, "list", "Zones and mask files that hold", flags, List),
      AddTo(*group, "export", "Drawn zones, as a file that `save` reads", flags,
            Export),
      AddTo(*group, "save", "Draw the zones of a file", flags, Save),
      AddTo(*group, "delete", "Remove these", flags, Delete)};
  agent_command::AddFile(commands[2], flags->file);
  agent_command::AddNames(commands[3], flags->names);
  return {group, cli::RunChosen(std::move(commands))};
}

}  // namespace treeline::zones_app
