// Docks of one agent: those that are kept, the drive into one, and the charge.
#ifndef NAV_AGENT_SERVICE_DOCK_DESK_H_
#define NAV_AGENT_SERVICE_DOCK_DESK_H_

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "common/base/clock.h"
#include "nav_agent/core/battery.h"
#include "nav_agent/core/robot_file.h"
#include "nav_agent/docking/charge_keeper.h"
#include "nav_agent/docking/dock_pilot.h"
#include "nav_agent/service/dock_book.h"

namespace treeline::agent_service {

// What is shown of it.
struct DockReport {
  docking::DockingStatus docking = {};
  docking::ChargeStatus charge = {};
  int64_t charge_trips = 0;
  // DockBook's.
  uint64_t revision = 0;
};

class DockDesk {
 public:
  // `charge` must be valid.
  DockDesk(std::unique_ptr<DockBook> book, const core::RobotModel& robot,
           const docking::ChargeOptions& charge,
           core::ContactEnd contacts = core::ContactEnd::kUnsaid)
      : book_(std::move(book)),
        pilot_(robot),
        keeper_(charge),
        contacts_(contacts) {}

  // ---- any thread ----
  DockBook& book() { return *book_; }
  const DockBook& book() const { return *book_; }
  // A dock that is made is driven into with that end ahead, whatever it says.
  core::ContactEnd contacts() const { return contacts_; }

  // ---- the thread that steps ----
  docking::DockPilot& pilot() { return pilot_; }
  docking::ChargeKeeper& keeper() { return keeper_; }
  // What was kept or removed, is known to the pilot.
  void FollowBook() {
    if (revision_ == book_->revision()) return;
    KeptContents<docking::Dock> contents = book_->contents();
    revision_ = contents.revision;
    pilot_.SetDocks(std::make_shared<const std::vector<docking::Dock>>(
        std::move(contents.things)));
  }
  // After each step of the navigator, and of its routes.
  void Step(behavior::Navigator& navigator, routes::RouteRunner& runner,
            base::MonotonicTime now,
            const std::optional<core::Battery>& battery) {
    FollowBook();
    keeper_.Step(navigator, pilot_, runner, now, battery);
    pilot_.Step(navigator, now, battery);
    KeepLearned();
  }
  DockReport Report() const {
    return {.docking = pilot_.status(),
            .charge = keeper_.status(),
            .charge_trips = keeper_.trips(),
            .revision = revision_};
  }
  // Of both, since the last call.
  std::vector<behavior::NavigatorEvent> TakeEvents() {
    std::vector<behavior::NavigatorEvent> events = keeper_.TakeEvents();
    std::ranges::move(pilot_.TakeEvents(), std::back_inserter(events));
    return events;
  }

 private:
  // What is seen from a dock is part of it.
  void KeepLearned() {
    const std::optional<docking::Dock> learned = pilot_.TakeLearned();
    if (!learned.has_value()) return;
    // Somebody may have moved or removed it just now; what cannot be kept for
    // a restart is looked at again then.
    const absl::StatusOr<docking::Dock> kept = book_->Find(learned->name);
    if (kept.ok() && docking::IsSamePlace(*kept, *learned)) {
      book_->Put({*learned}).IgnoreError();
    }
  }

  std::unique_ptr<DockBook> book_;
  docking::DockPilot pilot_;
  docking::ChargeKeeper keeper_;
  const core::ContactEnd contacts_;
  // Of what the pilot knows.
  uint64_t revision_ = 0;
};

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_DOCK_DESK_H_
