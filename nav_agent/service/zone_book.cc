#include "nav_agent/service/zone_book.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "nav_agent/zones/zone_file.h"

namespace treeline::agent_service {
namespace {

// 1000 zones of 100 corners take 5 MB.
constexpr uint64_t kMaxBytes = 16u << 20;

absl::Status WithText(const absl::Status& status, absl::string_view before,
                      absl::string_view after) {
  return {status.code(), absl::StrCat(before, status.message(), after)};
}

}  // namespace

absl::StatusOr<std::unique_ptr<ZoneBook>> ZoneBook::Open(
    std::shared_ptr<const behavior::NavigatorMap> map,
    const ZoneBookOptions& options) {
  auto book = std::make_unique<ZoneBook>(std::move(map));
  book->options_ = options;
  TL_RETURN_IF_ERROR(book->Load());
  return book;
}

absl::Status ZoneBook::Load() {
  std::vector<zones::Zone> read;
  if (!options_.folder.empty()) {
    std::error_code error;
    std::filesystem::create_directories(options_.folder, error);
    const absl::StatusOr<std::string> text = base::ReadFile(path(), kMaxBytes);
    if (!text.ok() && !absl::IsNotFound(text.status())) {
      return WithText(text.status(), "the robot's zones cannot be read: ",
                      "; it does not drive without them");
    }
    if (text.ok()) {
      absl::StatusOr<std::vector<zones::Zone>> parsed =
          zones::ParseZoneFile(*text);
      if (!parsed.ok()) {
        return absl::DataLossError(absl::StrCat(
            "the robot's zones cannot be read: ", path(), ": ",
            parsed.status().message(),
            "; it does not drive without them: put a good copy there, or "
            "remove the file and draw them again"));
      }
      read = *std::move(parsed);
    }
  }
  absl::StatusOr<std::shared_ptr<const zones::ZoneMap>> map = MapOf(read);
  if (!map.ok()) {
    return WithText(map.status(), "",
                    options_.folder.empty() || read.empty()
                        ? ""
                        : absl::StrCat(" (zones of ", path(),
                                       "; are they of another map?)"));
  }
  const absl::MutexLock lock(&mutex_);
  contents_.zones = std::move(read);
  contents_.map = *std::move(map);
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const zones::ZoneMap>> ZoneBook::MapOf(
    const std::vector<zones::Zone>& zones) const {
  return zones::ZoneMap::Make(map_->levels, zones, options_.masks,
                              options_.full_mps);
}

absl::Status ZoneBook::Write(const std::vector<zones::Zone>& zones) const {
  if (options_.folder.empty()) return absl::OkStatus();
  return base::WriteFileAtomically(path(), zones::ZoneFileText(zones));
}

absl::Status ZoneBook::keeping() const {
  if (!options_.folder.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "a restart forgets drawn zones: the agent runs without --state-dir");
}

ZoneBookContents ZoneBook::contents() const {
  const absl::MutexLock lock(&mutex_);
  return contents_;
}

uint64_t ZoneBook::revision() const {
  const absl::MutexLock lock(&mutex_);
  return contents_.revision;
}

absl::StatusOr<ZoneBookContents> ZoneBook::Put(
    const std::vector<zones::Zone>& zones, const Apply& apply) {
  TL_RETURN_IF_ERROR(
      zones::CheckZones(zones, static_cast<int>(map_->levels.levels.size())));
  return Change(
      [&zones](std::vector<zones::Zone>& all) {
        for (const zones::Zone& zone : zones) {
          const auto known =
              std::ranges::find(all, zone.name, &zones::Zone::name);
          if (known == all.end()) {
            all.push_back(zone);
          } else {
            *known = zone;
          }
        }
        return absl::OkStatus();
      },
      apply);
}

absl::StatusOr<ZoneBookContents> ZoneBook::Remove(
    const std::vector<std::string>& names, const Apply& apply) {
  return Change(
      [&names](std::vector<zones::Zone>& all) -> absl::Status {
        for (const std::string& name : names) {
          if (std::erase_if(all, [&name](const zones::Zone& zone) {
                return zone.name == name;
              }) == 0) {
            return absl::NotFoundError(
                absl::StrCat("no zone that was drawn is called '", name, "'"));
          }
        }
        return absl::OkStatus();
      },
      apply);
}

absl::StatusOr<ZoneBookContents> ZoneBook::Change(const Edit& edit,
                                                  const Apply& apply) {
  const absl::MutexLock one(&changing_);
  const ZoneBookContents before = contents();
  ZoneBookContents after = before;
  TL_RETURN_IF_ERROR(edit(after.zones));
  TL_ASSIGN_OR_RETURN(after.map, MapOf(after.zones));
  ++after.revision;
  if (absl::Status written = Write(after.zones); !written.ok()) {
    return WithText(written,
                    "the zones stay as they were; these cannot be "
                    "kept: ",
                    "");
  }
  if (absl::Status applied = apply(after.map); !applied.ok()) {
    // What the robot does not know a restart does not find.
    const absl::Status undone = Write(before.zones);
    return undone.ok() ? applied
                       : WithText(applied, "",
                                  absl::StrCat("; a restart finds the new "
                                               "zones nevertheless: ",
                                               undone.message()));
  }
  const absl::MutexLock lock(&mutex_);
  contents_ = std::move(after);
  return contents_;
}

std::vector<int32_t> ZoneBook::RunsOf(const zones::ZoneMask& mask) const {
  std::vector<int32_t> runs;
  const auto map =
      zones::ZoneMap::Make(map_->levels, {}, {&mask, 1}, options_.full_mps);
  if (!map.ok()) return runs;
  const core::OccupancyGrid& grid = (*map)->grid();
  for (int y = 0; y < grid.height; ++y) {
    for (int x = 0; x < grid.width; ++x) {
      const core::CellIndex cell = {x, y};
      const bool is_in = (*map)->IsKeptOut(mask.level, cell) ||
                         std::isfinite((*map)->MaxSpeed_mps(
                             mask.level, grid.CenterInMap(cell)));
      if (!is_in) continue;
      if (!runs.empty() && runs[runs.size() - 3] == y && runs.back() == x) {
        ++runs.back();
      } else {
        runs.insert(runs.end(), {y, x, x + 1});
      }
    }
  }
  return runs;
}

}  // namespace treeline::agent_service
