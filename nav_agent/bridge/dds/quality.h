// Quality of service, as far as ROS 2's profiles differ in it.
#ifndef NAV_AGENT_BRIDGE_DDS_QUALITY_H_
#define NAV_AGENT_BRIDGE_DDS_QUALITY_H_

namespace treeline::dds {

struct Quality {
  // Lost samples are sent again. A reader that asks for this meets no writer
  // that does not offer it; the other way round they match.
  bool is_reliable = true;
  // Who comes late gets the last ones ("transient local"); matched likewise.
  bool is_latched = false;
  // So many are kept for a slow reader, or for who comes late.
  int depth = 10;
};
// rmw_qos_profile_sensor_data.
inline constexpr Quality kSensorData = {
    .is_reliable = false, .is_latched = false, .depth = 5};
// /map, /tf_static.
inline constexpr Quality kLatched = {
    .is_reliable = true, .is_latched = true, .depth = 1};

}  // namespace treeline::dds

#endif  // NAV_AGENT_BRIDGE_DDS_QUALITY_H_
