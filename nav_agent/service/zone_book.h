// The zones that an agent has: drawn ones, which are kept for a restart, and
// masks.
#ifndef NAV_AGENT_SERVICE_ZONE_BOOK_H_
#define NAV_AGENT_SERVICE_ZONE_BOOK_H_

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/synchronization/mutex.h"
#include "nav_agent/behavior/navigator.h"
#include "nav_agent/zones/zone.h"
#include "nav_agent/zones/zone_map.h"
#include "nav_agent/zones/zone_masks.h"

namespace treeline::agent_service {

struct ZoneBookContents {
  // Counts changes, from 1.
  uint64_t revision = 1;
  std::vector<zones::Zone> zones;
  // Null: there never were any.
  std::shared_ptr<const zones::ZoneMap> map;
};

struct ZoneBookOptions {
  std::vector<zones::ZoneMask> masks;
  // What masks have percents of (m/s).
  double full_mps = 0.6;
  // Where drawn zones are kept, in the file `zones`; empty: a restart forgets
  // them.
  std::string folder;
};

// Thread-safe. Zones never get lost in silence: what cannot be read is an error
// of Open, and what cannot be kept is not put.
class ZoneBook {
 public:
  // Nothing is kept, and there are no masks.
  explicit ZoneBook(std::shared_ptr<const behavior::NavigatorMap> map)
      : map_(std::move(map)) {}

  // Makes the folder, and reads its zones. DATA_LOSS: the file is not one of
  // zones, or damaged. INVALID_ARGUMENT: zones or masks that mean nothing on
  // this map. Others: the file cannot be read. Each says what to do.
  static absl::StatusOr<std::unique_ptr<ZoneBook>> Open(
      std::shared_ptr<const behavior::NavigatorMap> map,
      const ZoneBookOptions& options);

  // What the robot is told of new zones; an error undoes the change.
  using Apply = std::function<absl::Status(
      const std::shared_ptr<const zones::ZoneMap>& zones)>;
  // As NavigationService's PutZones and RemoveZones have it.
  absl::StatusOr<ZoneBookContents> Put(const std::vector<zones::Zone>& zones,
                                       const Apply& apply);
  absl::StatusOr<ZoneBookContents> Remove(const std::vector<std::string>& names,
                                          const Apply& apply);

  ZoneBookContents contents() const;
  uint64_t revision() const;
  const std::vector<zones::ZoneMask>& masks() const { return options_.masks; }
  // The cells of the map that a mask makes zones of, in runs: row, first
  // column, the column after the last.
  std::vector<int32_t> RunsOf(const zones::ZoneMask& mask) const;
  // OK: a restart finds what is drawn; else why not.
  absl::Status keeping() const;

 private:
  using Edit = std::function<absl::Status(std::vector<zones::Zone>& zones)>;

  absl::StatusOr<ZoneBookContents> Change(const Edit& edit, const Apply& apply);
  absl::StatusOr<std::shared_ptr<const zones::ZoneMap>> MapOf(
      const std::vector<zones::Zone>& zones) const;
  absl::Status Write(const std::vector<zones::Zone>& zones) const;
  absl::Status Load();
  std::string path() const { return options_.folder + "/zones"; }

  const std::shared_ptr<const behavior::NavigatorMap> map_;
  ZoneBookOptions options_;
  // One change at a time, from its beginning to its end.
  absl::Mutex changing_;
  mutable absl::Mutex mutex_;
  ZoneBookContents contents_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_ZONE_BOOK_H_
