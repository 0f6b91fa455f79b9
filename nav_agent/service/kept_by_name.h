// Things that an operator keeps by name, over a restart, too: routes, docks.
#ifndef NAV_AGENT_SERVICE_KEPT_BY_NAME_H_
#define NAV_AGENT_SERVICE_KEPT_BY_NAME_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "absl/synchronization/mutex.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"

namespace treeline::agent_service {

// What a kind of things is called, and how it is written.
template <typename Thing>
struct KeptKind {
  // "route", and "routes", which is the file's name, too.
  std::string one;
  std::string many;
  // No file of them is longer.
  uint64_t max_bytes = 0;
  std::function<std::string(std::span<const Thing>)> text;
  std::function<absl::StatusOr<std::vector<Thing>>(absl::string_view)> parse;
  // INVALID_ARGUMENT: together they mean nothing on the map.
  std::function<absl::Status(std::span<const Thing>)> check;
};

template <typename Thing>
struct KeptContents {
  // Counts changes, from 1.
  uint64_t revision = 1;
  // In the order they came in.
  std::vector<Thing> things = {};
};

// Thread-safe. Things have a `name`. They never get lost in silence: what
// cannot be read is an error of Load, and what cannot be kept is not put.
template <typename Thing>
class KeptByName {
 public:
  using Contents = KeptContents<Thing>;

  // folder: where its file is; empty: a restart forgets them.
  KeptByName(KeptKind<Thing> kind, std::string folder)
      : kind_(std::move(kind)), folder_(std::move(folder)) {}

  // Makes the folder, and reads the file, if there is one. DATA_LOSS: it is
  // another, or damaged. INVALID_ARGUMENT: things that mean nothing on this
  // map. Others: it cannot be read. Each says what to do.
  absl::Status Load();

  // In the place of those of the same names: all or none. INVALID_ARGUMENT:
  // which means nothing, and why; others: they cannot be kept.
  absl::StatusOr<Contents> Put(const std::vector<Thing>& things);
  // NOT_FOUND: one of them is not kept; nothing changes.
  absl::StatusOr<Contents> Remove(const std::vector<std::string>& names);

  // NOT_FOUND names those there are.
  absl::StatusOr<Thing> Find(const std::string& name) const;
  Contents contents() const {
    const absl::MutexLock lock(&mutex_);
    return contents_;
  }
  uint64_t revision() const {
    const absl::MutexLock lock(&mutex_);
    return contents_.revision;
  }
  // OK: a restart finds what is kept; else why not.
  absl::Status keeping() const;

 private:
  using Edit = std::function<absl::Status(std::vector<Thing>& things)>;

  absl::StatusOr<Contents> Change(const Edit& edit);
  absl::Status NoneCalled(const std::string& name,
                          const std::vector<Thing>& things) const;
  std::string path() const { return absl::StrCat(folder_, "/", kind_.many); }

  const KeptKind<Thing> kind_;
  const std::string folder_;
  // One change at a time, from its beginning to its end.
  absl::Mutex changing_;
  mutable absl::Mutex mutex_;
  Contents contents_ ABSL_GUARDED_BY(mutex_);
};

template <typename Thing>
absl::Status KeptByName<Thing>::Load() {
  if (folder_.empty()) return absl::OkStatus();
  const std::string unreadable =
      absl::StrCat("the robot's ", kind_.many, " cannot be read");
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  const absl::StatusOr<std::string> text =
      base::ReadFile(path(), kind_.max_bytes);
  if (absl::IsNotFound(text.status())) return absl::OkStatus();
  if (!text.ok()) return base::Annotate(text.status(), unreadable);
  absl::StatusOr<std::vector<Thing>> read = kind_.parse(*text);
  if (!read.ok()) {
    return absl::DataLossError(absl::StrCat(
        unreadable, ": ", path(), ": ", read.status().message(),
        "; put a good copy there, or remove the file and set them up again"));
  }
  const absl::Status checked = kind_.check(*read);
  if (!checked.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat(checked.message(), " (", kind_.many, " of ", path(),
                     "; are they of another map?)"));
  }
  const absl::MutexLock lock(&mutex_);
  contents_.things = *std::move(read);
  return absl::OkStatus();
}

template <typename Thing>
absl::Status KeptByName<Thing>::keeping() const {
  if (!folder_.empty()) return absl::OkStatus();
  return absl::FailedPreconditionError(
      absl::StrCat("a restart forgets ", kind_.many,
                   ": the agent runs without --state-dir"));
}

template <typename Thing>
absl::Status KeptByName<Thing>::NoneCalled(
    const std::string& name, const std::vector<Thing>& things) const {
  // So many names are told.
  constexpr size_t kTold = 10;
  std::string names = things.empty() ? "there are none" : "there are: ";
  for (size_t i = 0; i < std::min(things.size(), kTold); ++i) {
    absl::StrAppend(&names, i == 0 ? "'" : ", '", things[i].name, "'");
  }
  return absl::NotFoundError(
      absl::StrCat("no ", kind_.one, " is called '", name, "'; ", names,
                   things.size() > kTold ? ", ..." : ""));
}

template <typename Thing>
absl::StatusOr<Thing> KeptByName<Thing>::Find(const std::string& name) const {
  const absl::MutexLock lock(&mutex_);
  const auto found = std::ranges::find(contents_.things, name, &Thing::name);
  if (found != contents_.things.end()) return *found;
  return NoneCalled(name, contents_.things);
}

template <typename Thing>
absl::StatusOr<KeptContents<Thing>> KeptByName<Thing>::Put(
    const std::vector<Thing>& things) {
  TL_RETURN_IF_ERROR(kind_.check(things));
  return Change([&things](std::vector<Thing>& all) {
    for (const Thing& thing : things) {
      const auto known = std::ranges::find(all, thing.name, &Thing::name);
      if (known == all.end()) {
        all.push_back(thing);
      } else {
        *known = thing;
      }
    }
    return absl::OkStatus();
  });
}

template <typename Thing>
absl::StatusOr<KeptContents<Thing>> KeptByName<Thing>::Remove(
    const std::vector<std::string>& names) {
  return Change([&](std::vector<Thing>& all) -> absl::Status {
    for (const std::string& name : names) {
      if (std::erase_if(all, [&name](const Thing& thing) {
            return thing.name == name;
          }) == 0) {
        return NoneCalled(name, all);
      }
    }
    return absl::OkStatus();
  });
}

template <typename Thing>
absl::StatusOr<KeptContents<Thing>> KeptByName<Thing>::Change(
    const Edit& edit) {
  const absl::MutexLock one(&changing_);
  Contents after = contents();
  TL_RETURN_IF_ERROR(edit(after.things));
  TL_RETURN_IF_ERROR(kind_.check(after.things));
  ++after.revision;
  if (!folder_.empty()) {
    TL_RETURN_IF_ERROR(base::Annotate(
        base::WriteFileAtomically(path(), kind_.text(after.things)),
        absl::StrCat("the ", kind_.many,
                     " stay as they were; these cannot be kept")));
  }
  const absl::MutexLock lock(&mutex_);
  contents_ = std::move(after);
  return contents_;
}

}  // namespace treeline::agent_service

#endif  // NAV_AGENT_SERVICE_KEPT_BY_NAME_H_
