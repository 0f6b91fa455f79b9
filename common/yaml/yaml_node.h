// YAML files that people write, read with errors that say where and what:
// "cafe.yaml:12: unknown key 'colour'; did you mean 'color'?".
#ifndef COMMON_YAML_YAML_NODE_H_
#define COMMON_YAML_YAML_NODE_H_

#include <cstdint>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace treeline::yaml {

// A value in a YAML text that knows its place. All errors are
// INVALID_ARGUMENT and begin with "FILE:LINE: ". Safe on any bytes. Cheap to
// copy; immutable and thread-safe.
class YamlNode {
 public:
  static constexpr size_t kMaxBytes = size_t{1} << 20;

  // The one document of `text`. `name` is what errors call the file.
  static absl::StatusOr<YamlNode> Parse(absl::string_view text,
                                        absl::string_view name);
  // Of the file at `path`; NOT_FOUND, PERMISSION_DENIED and so on name it.
  static absl::StatusOr<YamlNode> Read(const std::string& path);

  // INVALID_ARGUMENT: "FILE:LINE: message".
  absl::Status Error(absl::string_view message) const;
  // From 1.
  int line() const;

  // ---- maps ----

  // An error for a key that is not among `known`, with the nearest that is, for
  // a key that stands there twice, and for what is not a map.
  absl::Status CheckKeys(std::initializer_list<absl::string_view> known) const;
  // The keys, in the file's order; none of what is not a map.
  std::vector<std::string> Keys() const;
  bool Has(absl::string_view key) const;
  // The value of `key`; an error if there is none.
  absl::StatusOr<YamlNode> Get(absl::string_view key) const;

  // The value of `key` as ...; an error if it is not there, of another type, or
  // out of bounds.
  absl::StatusOr<double> Number(absl::string_view key, double min,
                                double max) const;
  absl::StatusOr<int64_t> Integer(absl::string_view key, int64_t min,
                                  int64_t max) const;
  absl::StatusOr<std::string> Text(absl::string_view key) const;
  absl::StatusOr<bool> Boolean(absl::string_view key) const;
  // A text that is one of `choices`; its index.
  absl::StatusOr<int> Choice(
      absl::string_view key,
      std::initializer_list<absl::string_view> choices) const;
  // A sequence of `count` numbers, each in [min, max].
  absl::StatusOr<std::vector<double>> Numbers(absl::string_view key,
                                              size_t count, double min,
                                              double max) const;
  // The elements of a sequence; none if there is no such key.
  absl::StatusOr<std::vector<YamlNode>> Items(absl::string_view key) const;

  // The same, and `otherwise` where the key is missing.
  absl::StatusOr<double> NumberOr(absl::string_view key, double otherwise,
                                  double min, double max) const;
  absl::StatusOr<int64_t> IntegerOr(absl::string_view key, int64_t otherwise,
                                    int64_t min, int64_t max) const;
  absl::StatusOr<std::string> TextOr(absl::string_view key,
                                     absl::string_view otherwise) const;
  absl::StatusOr<bool> BooleanOr(absl::string_view key, bool otherwise) const;

  // ---- sequences and scalars themselves ----

  bool IsMap() const;
  bool IsSequence() const;
  absl::StatusOr<std::vector<YamlNode>> Elements() const;
  // This node as `count` numbers in [min, max].
  absl::StatusOr<std::vector<double>> AsNumbers(size_t count, double min,
                                                double max) const;
  absl::StatusOr<double> AsNumber(double min, double max) const;
  absl::StatusOr<std::string> AsText() const;

 private:
  struct Impl;
  explicit YamlNode(std::shared_ptr<const Impl> impl);

  std::shared_ptr<const Impl> impl_;
};

}  // namespace treeline::yaml

#endif  // COMMON_YAML_YAML_NODE_H_
