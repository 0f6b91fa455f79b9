#include "common/ros2/bag/open_bag.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/status_macros.h"
#include "common/ros2/bag/mcap_bag.h"
#include "common/ros2/bag/ros1_bag.h"
#include "common/ros2/bag/sqlite_bag.h"
#include "common/yaml/yaml_node.h"

namespace treeline::bag {
namespace {

namespace fs = std::filesystem;

struct FileKind {
  const char* ending;
  absl::string_view begin;
  absl::StatusOr<std::unique_ptr<Bag>> (*open)(const std::string& path);
};
const std::array<FileKind, 3> kKinds = {{{".mcap", "\x89MCAP", OpenMcapBag},
                                         {".db3", "SQLite", OpenSqliteBag},
                                         {".bag", "#ROSBAG", OpenRos1Bag}}};

std::string FirstBytes(const std::string& path) {
  std::array<char, 16> bytes{};
  std::ifstream file(path, std::ios::binary);
  file.read(bytes.data(), bytes.size());
  return {bytes.data(), static_cast<size_t>(file.gcount())};
}

const FileKind* KindOf(const std::string& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return nullptr;
  const std::string begin = FirstBytes(path);
  const auto* kind = std::ranges::find_if(kKinds, [&](const FileKind& known) {
    return absl::EndsWith(path, known.ending) &&
           absl::StartsWith(begin, known.begin);
  });
  return kind == kKinds.end() ? nullptr : kind;
}

// Several files, one after another.
class BagOfFiles final : public Bag {
 public:
  void Add(std::unique_ptr<Bag> bag) {
    std::vector<size_t>& own = topics_of_.emplace_back();
    for (const BagTopic& topic : bag->topics()) own.push_back(AddTopic(topic));
    bags_.push_back(std::move(bag));
  }

  bool is_closed() const override {
    return std::ranges::all_of(
        bags_, [](const auto& bag) { return bag->is_closed(); });
  }

  absl::Status Read(const TakeMessage& take) override {
    for (size_t i = 0; i < bags_.size(); ++i) {
      TL_RETURN_IF_ERROR(bags_[i]->Read([&](const BagMessage& message) {
        BagMessage passed = message;
        passed.topic = topics_of_[i][message.topic];
        passed.place.file = static_cast<uint32_t>(i);
        return take(passed);
      }));
    }
    return absl::OkStatus();
  }

  absl::StatusOr<std::span<const uint8_t>> Fetch(
      const BagPlace& place) override {
    if (place.file >= bags_.size()) {
      return absl::OutOfRangeError("bag: no such file");
    }
    return bags_[place.file]->Fetch(place);
  }

 private:
  std::vector<std::unique_ptr<Bag>> bags_;
  // For each bag, its topics among all.
  std::vector<std::vector<size_t>> topics_of_;
};

// The names of the files, as metadata.yaml has them, without folders: they lie
// beside it.
absl::StatusOr<std::vector<std::string>> FilesOf(const std::string& metadata) {
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode file,
                      yaml::YamlNode::Read(metadata));
  TL_ASSIGN_OR_RETURN(const yaml::YamlNode bag,
                      file.Get("rosbag2_bagfile_information"));
  TL_ASSIGN_OR_RETURN(const std::string mode,
                      bag.TextOr("compression_mode", ""));
  if (!mode.empty() && !absl::EqualsIgnoreCase(mode, "none")) {
    return bag.Error(absl::StrCat(
        "the bag is compressed by ", mode,
        "; unpack it (`ros2 bag convert`), or record with MCAP, whose own "
        "compression is read"));
  }
  TL_ASSIGN_OR_RETURN(const std::vector<yaml::YamlNode> paths,
                      bag.Items("relative_file_paths"));
  std::vector<std::string> names;
  for (const yaml::YamlNode& path : paths) {
    TL_ASSIGN_OR_RETURN(const std::string text, path.AsText());
    names.push_back(fs::path(text).filename().string());
  }
  if (names.empty()) return bag.Error("relative_file_paths names no file");
  return names;
}

std::vector<std::string> FilesIn(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (absl::EndsWith(name, ".mcap") || absl::EndsWith(name, ".db3")) {
      names.push_back(name);
    }
  }
  // rosbag2 counts them: the tenth comes behind the ninth.
  std::ranges::sort(names, [](const std::string& a, const std::string& b) {
    return std::pair(a.size(), a) < std::pair(b.size(), b);
  });
  return names;
}

absl::StatusOr<std::unique_ptr<Bag>> OpenFolder(const std::string& folder) {
  const std::string metadata = folder + "/metadata.yaml";
  std::vector<std::string> names;
  if (fs::exists(metadata)) {
    TL_ASSIGN_OR_RETURN(names, FilesOf(metadata));
  } else {
    names = FilesIn(folder);
  }
  if (names.empty()) {
    return absl::InvalidArgumentError(absl::StrCat(
        folder, ": is no bag: there is no metadata.yaml, .mcap or .db3"));
  }
  auto bag = std::make_unique<BagOfFiles>();
  for (const std::string& name : names) {
    const std::string path = absl::StrCat(folder, "/", name);
    if (!fs::exists(path)) {
      return absl::NotFoundError(
          absl::StrCat("there is no ", path, ", which ", metadata, " names"));
    }
    TL_ASSIGN_OR_RETURN(std::unique_ptr<Bag> file, OpenBag(path));
    bag->Add(std::move(file));
  }
  return bag;
}

}  // namespace

bool IsBag(const std::string& path) {
  std::error_code error;
  if (!fs::is_directory(path, error)) return KindOf(path) != nullptr;
  if (!fs::exists(path + "/metadata.yaml", error)) {
    return !FilesIn(path).empty();
  }
  return FilesOf(path + "/metadata.yaml").ok();
}

absl::StatusOr<std::unique_ptr<Bag>> OpenBag(const std::string& path) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    return absl::NotFoundError(absl::StrCat("there is no ", path));
  }
  if (fs::is_directory(path, error)) return OpenFolder(path);
  if (const FileKind* kind = KindOf(path)) return kind->open(path);
  return absl::InvalidArgumentError(absl::StrCat(
      path,
      ": is no recording of ROS that is known: .mcap, .db3 (rosbag2), "
      ".bag (rosbag, format 2.0), or the folder of `ros2 bag record`"));
}

}  // namespace treeline::bag
