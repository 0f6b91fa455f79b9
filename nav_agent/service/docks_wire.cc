#include "nav_agent/service/docks_wire.h"

#include "nav_agent/service/utf8_text.h"

namespace treeline::agent_service {
namespace {

// Numbers of the proto are one higher: 0 is "unspecified" there.
template <typename Proto, typename State>
Proto EnumToProto(State state) {
  return static_cast<Proto>(static_cast<int>(state) + 1);
}

}  // namespace

docking::Dock FromProto(const v1::Dock& proto, const core::RobotModel& robot) {
  return {.name = proto.name(),
          .map_from_docked = {{proto.x_m(), proto.y_m()}, proto.yaw_rad()},
          .level = proto.level(),
          .is_backward = proto.backward(),
          .staging_m = proto.staging_m() == 0 ? docking::DefaultStaging_m(robot)
                                              : proto.staging_m()};
}

v1::Dock ToProto(const docking::Dock& dock) {
  v1::Dock proto;
  proto.set_name(Utf8(dock.name));
  proto.set_x_m(dock.map_from_docked.translation.x);
  proto.set_y_m(dock.map_from_docked.translation.y);
  proto.set_yaw_rad(dock.map_from_docked.yaw_rad);
  proto.set_level(dock.level);
  proto.set_backward(dock.is_backward);
  proto.set_staging_m(dock.staging_m);
  return proto;
}

v1::DockingStatus ToProto(const DockReport& report) {
  v1::DockingStatus proto;
  proto.set_id(report.docking.id);
  proto.set_outcome(EnumToProto<v1::DockingOutcome>(report.docking.outcome));
  proto.set_why(Utf8(report.docking.why));
  proto.set_failed_tries(report.docking.failed_tries);
  proto.set_state(EnumToProto<v1::DockingState>(report.docking.state));
  proto.set_dock(Utf8(report.docking.dock));
  proto.set_charge_state(EnumToProto<v1::ChargeState>(report.charge.state));
  proto.set_charge_why(Utf8(report.charge.why));
  proto.set_charge_trips(report.charge_trips);
  proto.set_docks_revision(report.revision);
  return proto;
}

}  // namespace treeline::agent_service
