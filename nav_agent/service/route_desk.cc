#include "nav_agent/service/route_desk.h"

#include <optional>
#include <utility>

#include "common/base/status_macros.h"

namespace treeline::agent_service {

absl::StatusOr<std::unique_ptr<RouteDesk>> RouteDesk::Open(
    int levels, const std::string& folder) {
  TL_ASSIGN_OR_RETURN(std::unique_ptr<RouteBook> book,
                      RouteBook::Open(levels, folder));
  return std::unique_ptr<RouteDesk>(new RouteDesk(std::move(book), folder));
}

absl::Status RouteDesk::Offer(base::MonotonicTime now) {
  constexpr char kUnknown[] = "what route was under way is not known";
  absl::StatusOr<std::optional<routes::RouteProgress>> progress =
      keeper_.Load();
  if (!progress.ok()) return base::Annotate(progress.status(), kUnknown);
  if (!progress->has_value()) return absl::OkStatus();
  TL_RETURN_IF_ERROR(base::Annotate(
      routes::CheckRoute(*(*progress)->route, book_->levels()), kUnknown));
  runner_.Offer(**std::move(progress), now);
  // The file has it already.
  kept_changes_ = runner_.changes();
  return absl::OkStatus();
}

void RouteDesk::Step(behavior::Navigator& navigator, base::MonotonicTime now) {
  runner_.Step(navigator, now);
  KeepProgress();
}

void RouteDesk::KeepProgress() {
  if (kept_changes_ == runner_.changes()) return;
  kept_changes_ = runner_.changes();
  if (runner_.IsOpen()) {
    keeper_.Keep(runner_.status()->progress);
  } else {
    keeper_.Keep(std::nullopt);
  }
}

}  // namespace treeline::agent_service
