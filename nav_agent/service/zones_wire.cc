#include "nav_agent/service/zones_wire.h"

#include "common/wire/geometry.h"
#include "nav_agent/service/utf8_text.h"

namespace treeline::agent_service {
namespace {

// Numbers of the proto are one higher: 0 is "unspecified" there.
v1::ZoneKind ToProto(zones::ZoneKind kind) {
  return static_cast<v1::ZoneKind>(static_cast<int>(kind) + 1);
}

}  // namespace

absl::StatusOr<zones::Zone> FromProto(const v1::Zone& proto) {
  if (proto.kind() < v1::ZONE_KIND_KEEP_OUT ||
      proto.kind() > v1::ZONE_KIND_ONE_WAY) {
    return wire::FieldError("kind", "is none that there is");
  }
  zones::Zone zone = {
      .name = proto.name(),
      .kind = static_cast<zones::ZoneKind>(static_cast<int>(proto.kind()) - 1),
      .level = proto.level(),
      .corners_in_map = {},
      .max_mps = 0,
      .direction_rad = 0};
  // What a kind does not have is not kept, either.
  if (zone.kind == zones::ZoneKind::kSpeed) zone.max_mps = proto.max_mps();
  if (zone.kind == zones::ZoneKind::kOneWay) {
    zone.direction_rad = proto.direction_rad();
  }
  for (const v1::ZoneCorner& corner : proto.corners()) {
    zone.corners_in_map.push_back({corner.x_m(), corner.y_m()});
  }
  return zone;
}

v1::Zone ToProto(const zones::Zone& zone) {
  v1::Zone proto;
  proto.set_name(Utf8(zone.name));
  proto.set_kind(ToProto(zone.kind));
  proto.set_level(zone.level);
  for (const geometry::Vec2& corner : zone.corners_in_map) {
    v1::ZoneCorner& at = *proto.add_corners();
    at.set_x_m(corner.x);
    at.set_y_m(corner.y);
  }
  proto.set_max_mps(zone.max_mps);
  proto.set_direction_rad(zone.direction_rad);
  return proto;
}

v1::ZoneMask ToProto(const zones::ZoneMask& mask,
                     const std::vector<int32_t>& runs) {
  v1::ZoneMask proto;
  proto.set_name(Utf8(mask.name));
  proto.set_kind(ToProto(mask.kind));
  proto.set_level(mask.level);
  proto.mutable_runs()->Add(runs.begin(), runs.end());
  return proto;
}

}  // namespace treeline::agent_service
