// The robot's state and its maps over gRPC.
#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "common/wire/geometry.h"
#include "common/wire/status.h"
#include "nav_agent/service/grpc_services.h"
#include "nav_agent/service/map_pictures.h"
#include "nav_agent/service/navigation_wire.h"
#include "nav_agent/service/stream_slot.h"

namespace treeline::agent_service {
namespace {

constexpr absl::Duration kLookUp = absl::Milliseconds(50);
constexpr double kMostHz = 10;
constexpr double kLeastHz = 0.1;
constexpr size_t kEventsAtOnce = 100;

}  // namespace

grpc::Status NavigationGrpcService::StreamState(
    grpc::ServerContext* context, const v1::StreamStateRequest* request,
    grpc::ServerWriter<v1::StreamStateResponse>* writer) {
  const double rate_hz = request->rate_hz() == 0 ? kMostHz : request->rate_hz();
  if (!(rate_hz >= kLeastHz && rate_hz <= kMostHz)) {
    return wire::ToGrpc(wire::FieldError(
        "rate_hz", absl::StrCat("is ", rate_hz, "; it must be 0.1..10")));
  }
  const StreamSlot slot(streams_, max_streams_);
  if (!slot.is_taken()) {
    return wire::ToGrpc(
        absl::ResourceExhaustedError("too many streams are open"));
  }
  const AgentHub& hub = commands_.hub();
  // States come at kMostHz: a little less than the interval, so that none of
  // them is passed over for being a millisecond early.
  const absl::Duration interval =
      absl::Seconds(1 / rate_hz) - absl::Milliseconds(50);
  absl::Time next = absl::InfinitePast();
  uint64_t seen = 0;
  uint64_t event = hub.last_event();
  while (!context->IsCancelled()) {
    if (hub.is_closed()) {
      return wire::ToGrpc(absl::UnavailableError("the agent is stopping"));
    }
    const auto state = hub.WaitForNewer(seen, absl::Now() + kLookUp);
    if (state == nullptr) continue;
    seen = state->number;
    const absl::Time now = absl::Now();
    if (now < next) continue;
    next = now + interval;
    v1::StreamStateResponse message;
    *message.mutable_state() = ToProto(*state);
    for (const AgentHub::Event& one : hub.EventsAfter(event, kEventsAtOnce)) {
      *message.add_events() = ToProto(one);
      event = one.number;
    }
    if (!writer->Write(message)) break;
  }
  return wire::ToGrpc(absl::CancelledError("the caller has gone"));
}

grpc::Status NavigationGrpcService::GetMaps(grpc::ServerContext* /*context*/,
                                            const v1::GetMapsRequest* request,
                                            v1::GetMapsResponse* response) {
  const AgentInfo& info = commands_.info();
  const auto& levels = info.map->levels.levels;
  response->set_name(info.map_name);
  for (size_t i = 0; i < levels.size(); ++i) {
    *response->add_levels() = ToProto(levels[i], static_cast<int>(i));
  }
  for (const int index : request->picture_levels()) {
    if (index < 0 || static_cast<size_t>(index) >= levels.size()) {
      return wire::ToGrpc(wire::FieldError(
          "picture_levels",
          absl::StrCat("has ", index, "; the map has 0..", levels.size() - 1)));
    }
    v1::MapLevel& level = *response->mutable_levels(index);
    if (!level.png().empty()) continue;
    auto png = LevelPng(levels[static_cast<size_t>(index)].grid);
    if (!png.ok()) return wire::ToGrpc(png.status());
    level.set_png(*std::move(png));
  }
  return grpc::Status::OK;
}

}  // namespace treeline::agent_service
