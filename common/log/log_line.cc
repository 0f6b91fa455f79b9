#include "common/log/log_line.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "absl/strings/str_replace.h"

namespace treeline::logging {
namespace {

// In quotation marks, on one line.
std::string Quoted(absl::string_view value) {
  // Apostrophes do no harm there.
  return absl::StrCat(
      "\"", absl::StrReplaceAll(absl::CHexEscape(value), {{"\\'", "'"}}), "\"");
}

}  // namespace

std::string JsonText(absl::string_view text) {
  return nlohmann::json(std::string(text))
      .dump(-1, ' ', /*ensure_ascii=*/true,
            nlohmann::json::error_handler_t::replace);
}

void LogLine::Start(absl::string_view key) {
  if (format_ == LogFormat::kJson) {
    absl::StrAppend(&fields_, fields_.empty() ? "\"" : ",\"", key, "\":");
  } else {
    absl::StrAppend(&fields_, fields_.empty() ? "" : " ", key, "=");
  }
}

LogLine& LogLine::Word(absl::string_view key, absl::string_view word) {
  Start(key);
  fields_ += format_ == LogFormat::kJson ? JsonText(word) : std::string(word);
  return *this;
}

LogLine& LogLine::Text(absl::string_view key, absl::string_view text) {
  Start(key);
  fields_ += format_ == LogFormat::kJson ? JsonText(text) : Quoted(text);
  return *this;
}

LogLine& LogLine::Message(absl::string_view sentence) {
  if (format_ == LogFormat::kJson) return Text("message", sentence);
  if (!fields_.empty()) fields_ += ' ';
  // Sentences of the system and of gRPC may hold anything too.
  fields_ += absl::StrReplaceAll(absl::Utf8SafeCHexEscape(sentence),
                                 {{"\\'", "'"}, {"\\\"", "\""}});
  return *this;
}

LogLine& LogLine::Integer(absl::string_view key, int64_t value) {
  Start(key);
  absl::StrAppend(&fields_, value);
  return *this;
}

LogLine& LogLine::Number(absl::string_view key, double value) {
  Start(key);
  // JSON has no infinity.
  if (format_ == LogFormat::kJson && !std::isfinite(value)) {
    fields_ += "null";
  } else {
    absl::StrAppendFormat(&fields_, "%.2f", value);
  }
  return *this;
}

}  // namespace treeline::logging
