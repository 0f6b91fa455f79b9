#include "nav_agent/service/route_book.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "nav_agent/routes/route_file.h"

namespace treeline::agent_service {
namespace {

// 1000 routes of 100 waypoints with long names take 16 MB.
constexpr uint64_t kMaxBytes = 32u << 20;
// So many names are told to who asks for another one.
constexpr size_t kToldNames = 10;

std::string NamesText(const std::vector<routes::Route>& routes) {
  if (routes.empty()) return "there are none";
  std::string text = "there are: ";
  for (size_t i = 0; i < std::min(routes.size(), kToldNames); ++i) {
    absl::StrAppend(&text, i == 0 ? "'" : ", '", routes[i].name, "'");
  }
  return routes.size() > kToldNames ? absl::StrCat(text, ", ...") : text;
}

}  // namespace

absl::StatusOr<std::unique_ptr<RouteBook>> RouteBook::Open(
    int levels, const std::string& folder) {
  auto book = std::make_unique<RouteBook>(levels);
  book->folder_ = folder;
  if (!folder.empty()) TL_RETURN_IF_ERROR(book->Load());
  return book;
}

absl::Status RouteBook::Load() {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  const absl::StatusOr<std::string> text = base::ReadFile(path(), kMaxBytes);
  if (absl::IsNotFound(text.status())) return absl::OkStatus();
  if (!text.ok()) {
    return base::Annotate(text.status(), "the robot's routes cannot be read");
  }
  absl::StatusOr<std::vector<routes::Route>> read =
      routes::ParseRouteFile(*text);
  if (!read.ok()) {
    return absl::DataLossError(absl::StrCat(
        "the robot's routes cannot be read: ", path(), ": ",
        read.status().message(),
        "; put a good copy there, or remove the file and set them up again"));
  }
  const absl::Status checked = routes::CheckRoutes(*read, levels_);
  if (!checked.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(checked.message(), " (routes of ", path(),
                     "; are they of another map?)"));
  }
  const absl::MutexLock lock(&mutex_);
  contents_.routes = *std::move(read);
  return absl::OkStatus();
}

absl::Status RouteBook::keeping() const {
  if (!folder_.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      "a restart forgets routes: the agent runs without --state-dir");
}

RouteBookContents RouteBook::contents() const {
  const absl::MutexLock lock(&mutex_);
  return contents_;
}

uint64_t RouteBook::revision() const {
  const absl::MutexLock lock(&mutex_);
  return contents_.revision;
}

absl::StatusOr<routes::Route> RouteBook::Find(const std::string& name) const {
  const absl::MutexLock lock(&mutex_);
  const auto found =
      std::ranges::find(contents_.routes, name, &routes::Route::name);
  if (found != contents_.routes.end()) return *found;
  return absl::NotFoundError(absl::StrCat("no route is called '", name, "'; ",
                                          NamesText(contents_.routes)));
}

absl::StatusOr<RouteBookContents> RouteBook::Put(
    const std::vector<routes::Route>& routes) {
  TL_RETURN_IF_ERROR(routes::CheckRoutes(routes, levels_));
  return Change([&routes](std::vector<routes::Route>& all) {
    for (const routes::Route& route : routes) {
      const auto known =
          std::ranges::find(all, route.name, &routes::Route::name);
      if (known == all.end()) {
        all.push_back(route);
      } else {
        *known = route;
      }
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<RouteBookContents> RouteBook::Remove(
    const std::vector<std::string>& names) {
  return Change([&names](std::vector<routes::Route>& all) -> absl::Status {
    for (const std::string& name : names) {
      if (std::erase_if(all, [&name](const routes::Route& route) {
            return route.name == name;
          }) == 0) {
        return absl::NotFoundError(
            absl::StrCat("no route is called '", name, "'; ", NamesText(all)));
      }
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<RouteBookContents> RouteBook::Change(const Edit& edit) {
  const absl::MutexLock one(&changing_);
  RouteBookContents after = contents();
  TL_RETURN_IF_ERROR(edit(after.routes));
  TL_RETURN_IF_ERROR(routes::CheckRoutes(after.routes, levels_));
  ++after.revision;
  if (!folder_.empty()) {
    TL_RETURN_IF_ERROR(base::Annotate(
        base::WriteFileAtomically(path(), routes::RouteFileText(after.routes)),
        "the routes stay as they were; these cannot be kept"));
  }
  const absl::MutexLock lock(&mutex_);
  contents_ = std::move(after);
  return contents_;
}

}  // namespace treeline::agent_service
