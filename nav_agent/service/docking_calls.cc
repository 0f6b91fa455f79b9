#include "nav_agent/service/docking_calls.h"

#include <optional>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/wire/geometry.h"
#include "nav_agent/service/docks_wire.h"
#include "nav_agent/service/stream_slot.h"
#include "nav_agent/service/tell_until_over.h"

namespace treeline::agent_service {
namespace {

// nullopt: the state is older than the docking.
std::optional<v1::DockResponse> FeedbackOf(const AgentState& state,
                                           uint64_t id) {
  if (state.docks.docking.id < id) return std::nullopt;
  v1::DockResponse message;
  *message.mutable_docking() = ToProto(state.docks);
  if (state.docks.docking.id == id) {
    message.set_is_final(state.docks.docking.outcome !=
                         docking::DockingOutcome::kUnderWay);
    return message;
  }
  v1::DockingStatus& status = *message.mutable_docking();
  status.Clear();
  status.set_id(id);
  status.set_outcome(v1::DOCKING_OUTCOME_CANCELLED);
  status.set_why("another docking took its place");
  message.set_is_final(true);
  return message;
}

}  // namespace

absl::StatusOr<v1::GetDocksResponse> DockingCalls::GetDocks(
    const v1::GetDocksRequest& /*request*/) const {
  const DockBook& book = commands_.docks().book();
  const KeptContents<docking::Dock> contents = book.contents();
  v1::GetDocksResponse response;
  response.set_revision(contents.revision);
  for (const docking::Dock& dock : contents.things) {
    *response.add_docks() = ToProto(dock);
  }
  response.set_survives_restart(book.keeping().ok());
  response.set_warning(std::string(book.keeping().message()));
  return response;
}

absl::StatusOr<v1::PutDocksResponse> DockingCalls::PutDocks(
    const v1::PutDocksRequest& request) {
  std::vector<docking::Dock> docks;
  const core::ContactEnd contacts = commands_.docks().contacts();
  for (const v1::Dock& proto : request.docks()) {
    docks.push_back(FromProto(proto, commands_.info().robot));
    if (contacts == core::ContactEnd::kRear) docks.back().is_backward = true;
    if (contacts == core::ContactEnd::kFront && docks.back().is_backward) {
      return wire::FieldError(
          "docks", absl::StrCat("'", proto.name(),
                                "' is driven into with the rear first, and the "
                                "robot's charging contacts are at its front"));
    }
  }
  if (docks.empty()) return wire::FieldError("docks", "has none");
  if (request.here()) {
    if (docks.size() != 1) {
      return wire::FieldError("docks", "has several, and `here` is set");
    }
    TL_ASSIGN_OR_RETURN(const core::LevelPose robot, commands_.WhereItStands());
    docks.front().map_from_docked = robot.map_from_base;
    docks.front().level = robot.place.level;
  }
  DockBook& book = commands_.docks().book();
  // What was seen from one that stays where it is, is seen from it still.
  for (docking::Dock& dock : docks) {
    const absl::StatusOr<docking::Dock> kept = book.Find(dock.name);
    if (kept.ok() && docking::IsSamePlace(*kept, dock)) dock.view = kept->view;
  }
  TL_ASSIGN_OR_RETURN(const KeptContents<docking::Dock> contents,
                      book.Put(docks));
  v1::PutDocksResponse response;
  response.set_revision(contents.revision);
  response.set_survives_restart(book.keeping().ok());
  response.set_warning(std::string(book.keeping().message()));
  return response;
}

absl::StatusOr<v1::RemoveDocksResponse> DockingCalls::RemoveDocks(
    const v1::RemoveDocksRequest& request) {
  TL_ASSIGN_OR_RETURN(const KeptContents<docking::Dock> contents,
                      commands_.docks().book().Remove(
                          {request.names().begin(), request.names().end()}));
  v1::RemoveDocksResponse response;
  response.set_revision(contents.revision);
  return response;
}

absl::Status DockingCalls::Dock(const v1::DockRequest& request,
                                MessageSink<v1::DockResponse>& sink) {
  const StreamSlot slot(streams_, max_streams_);
  if (!slot.is_taken()) {
    return absl::ResourceExhaustedError("too many streams are open");
  }
  TL_ASSIGN_OR_RETURN(const uint64_t id, commands_.Dock(request.name()));
  const absl::Status told = TellUntilOver<v1::DockResponse>(
      commands_.hub(),
      [id](const AgentState& state) { return FeedbackOf(state, id); }, sink);
  if (absl::IsCancelled(told) && !request.keep_when_call_ends()) {
    // NOT_FOUND where it is over by now, or another took its place.
    commands_.CancelDocking(id).IgnoreError();
  }
  return told;
}

absl::StatusOr<v1::UndockResponse> DockingCalls::Undock(
    const v1::UndockRequest& /*request*/) {
  TL_RETURN_IF_ERROR(commands_.Undock());
  return v1::UndockResponse();
}

}  // namespace treeline::agent_service
