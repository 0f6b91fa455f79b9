#include "server/repository/http_model_source.h"

#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "common/base/error_info.h"
#include "common/base/file.h"
#include "common/base/status_macros.h"
#include "server/repository/sha256.h"
#include "server/repository/web_url.h"

namespace treeline::repository {
namespace {

// A body that ended well before what the index promises.
constexpr char kShort[] = "the file is shorter than the index promises";

// Requests a stop when either of two tokens does.
class EitherStop {
 public:
  EitherStop(const std::stop_token& a, const std::stop_token& b)
      : on_a_(a, Request{source_}), on_b_(b, Request{source_}) {}
  std::stop_token token() const { return source_.get_token(); }

 private:
  struct Request {
    std::stop_source& source;
    void operator()() const { source.request_stop(); }
  };
  std::stop_source source_;
  std::stop_callback<Request> on_a_;
  std::stop_callback<Request> on_b_;
};

// A whole body in memory.
class TextSink final : public HttpSink {
 public:
  absl::Status Begin(uint64_t /*offset*/) override {
    text_.clear();
    return absl::OkStatus();
  }
  absl::Status Write(absl::string_view bytes) override {
    if (text_.size() + bytes.size() > kMaxIndexBytes) {
      return base::WithReason(
          absl::InvalidArgumentError(
              absl::StrCat("index: more than ", kMaxIndexBytes, " bytes")),
          "INDEX_INVALID");
    }
    text_.append(bytes.data(), bytes.size());
    return absl::OkStatus();
  }
  std::string& text() { return text_; }

 private:
  std::string text_;
};

class DownloadSink final : public HttpSink {
 public:
  explicit DownloadSink(CacheDownload& download) : download_(download) {}
  absl::Status Begin(uint64_t offset) override {
    if (offset == download_.size()) return absl::OkStatus();
    return download_.Restart();
  }
  absl::Status Write(absl::string_view bytes) override {
    return download_.Append(bytes);
  }

 private:
  CacheDownload& download_;
};

// `status` with `prefix` in front of its message, and its details.
absl::Status Prefixed(absl::string_view prefix, const absl::Status& status) {
  absl::Status prefixed = base::Annotate(status, prefix);
  status.ForEachPayload([&](absl::string_view type, const absl::Cord& payload) {
    prefixed.SetPayload(type, payload);
  });
  return prefixed;
}

// Whether an index could not be had from where it is believed: the last one is
// better than none.
bool IsNoAnswer(const absl::Status& status) {
  const std::string reason = base::ErrorInfoOf(status).reason;
  return absl::IsUnavailable(status) || reason == "SOURCE_UNTRUSTED" ||
         reason == "INDEX_UNSIGNED" || reason == "INDEX_SIGNATURE_WRONG" ||
         reason == "INDEX_OLD";
}

}  // namespace

bool IsModelUrl(absl::string_view models) {
  return absl::StrContains(models, "://");
}

absl::Status HttpModelSourceOptions::Validate() const {
  TL_RETURN_IF_ERROR(http.Validate());
  if (cache.folder.empty()) {
    return absl::InvalidArgumentError("a folder for fetched models is needed");
  }
  if (retry.max_attempts < 1) {
    return absl::InvalidArgumentError("attempts must be at least 1");
  }
  const auto absolute = ResolveUrl("", url);
  if (!absolute.ok()) return absolute.status();
  return CheckTransport(*absolute, http.allow_plain_http);
}

absl::StatusOr<std::unique_ptr<HttpModelSource>> HttpModelSource::Open(
    HttpModelSourceOptions options, const base::Clock& clock, Sleeper sleep) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(std::string url, ResolveUrl("", options.url));
  if (absl::EndsWith(PublicUrl(url), "/")) {
    const std::string query =
        url.find('?') == std::string::npos ? "" : url.substr(url.find('?'));
    TL_ASSIGN_OR_RETURN(url, ResolveUrl(url, "index.json" + query));
  }
  TL_ASSIGN_OR_RETURN(std::unique_ptr<DigestCache> cache,
                      DigestCache::Open(options.cache, clock));
  std::unique_ptr<HttpModelSource> source(
      new HttpModelSource(std::move(options), std::move(url), std::move(cache),
                          clock, std::move(sleep)));
  TL_RETURN_IF_ERROR(base::MakeParentFolder(source->IndexPath()));
  return source;
}

HttpModelSource::HttpModelSource(HttpModelSourceOptions options,
                                 std::string index_url,
                                 std::unique_ptr<DigestCache> cache,
                                 const base::Clock& clock, Sleeper sleep)
    : options_(std::move(options)),
      index_url_(std::move(index_url)),
      cache_(std::move(cache)),
      clock_(clock),
      sleep_(std::move(sleep)) {}

void HttpModelSource::Warn(absl::string_view message) const {
  if (options_.warn) options_.warn(message);
}

// By address without query, which changes from one presigned one to the next.
std::string HttpModelSource::IndexPath() const {
  Sha256 hash;
  hash.Update(PublicUrl(index_url_));
  return absl::StrCat(options_.cache.folder, "/index/", hash.Finish());
}

// A line with the ETag, and the index.
HttpModelSource::KeptIndex HttpModelSource::ReadKeptIndex() const {
  const auto file = base::ReadFile(IndexPath(), 2 * kMaxIndexBytes);
  const size_t line = file.ok() ? file->find('\n') : std::string::npos;
  if (line == std::string::npos) return {};
  return {.etag = file->substr(0, line), .text = file->substr(line + 1)};
}

void HttpModelSource::KeepIndex(const KeptIndex& kept) const {
  const absl::Status status = base::WriteFileAtomically(
      IndexPath(), absl::StrCat(kept.etag, "\n", kept.text));
  if (!status.ok()) {
    Warn(absl::StrCat("the index could not be kept: ", status.message()));
  }
}

absl::StatusOr<HttpModelSource::KeptIndex> HttpModelSource::GetIndex(
    const KeptIndex& kept) const {
  TextSink sink;
  absl::StatusOr<HttpGetResponse> response;
  TL_RETURN_IF_ERROR(Retry(
      options_.retry, options_.seed, sleep_, options_.stop,
      [&] {
        response = HttpGet({.url = index_url_, .etag = kept.etag},
                           options_.http, clock_, sink, options_.stop);
        return response.status();
      },
      [] { return uint64_t{0}; }));
  if (response->status == 304) return kept;
  return KeptIndex{.etag = response->etag, .text = std::move(sink.text())};
}

absl::StatusOr<SourceListing> HttpModelSource::List() {
  absl::StatusOr<SourceListing> listing = ListNow();
  // Whoever polls goes on with what it has, and would not say so.
  if (!listing.ok() && !options_.stop.stop_requested()) {
    Warn(absl::StrCat("the index cannot be used, nothing new is served: ",
                      listing.status().message()));
  }
  return listing;
}

absl::StatusOr<ModelIndex> HttpModelSource::Read(const KeptIndex& index) const {
  absl::StatusOr<ModelIndex> read = ParseModelIndex(index.text);
  if (!read.ok()) {
    return base::WithReason(Prefixed(PublicUrl(index_url_), read.status()),
                            "INDEX_INVALID");
  }
  if (options_.keys != nullptr) {
    const absl::Status believed = options_.keys->Check(*read);
    if (!believed.ok()) return Prefixed(PublicUrl(index_url_), believed);
  }
  return read;
}

// Whoever holds the web server may have an older index, which was signed, too.
absl::StatusOr<ModelIndex> HttpModelSource::ReadNext(
    const KeptIndex& index, const absl::StatusOr<ModelIndex>& before) const {
  TL_ASSIGN_OR_RETURN(ModelIndex read, Read(index));
  if (options_.keys != nullptr && before.ok() &&
      read.published_unix_s < before->published_unix_s) {
    return base::WithReason(
        absl::FailedPreconditionError(absl::StrCat(
            PublicUrl(index_url_), ": the index is older than the last one")),
        "INDEX_OLD");
  }
  return read;
}

absl::StatusOr<SourceListing> HttpModelSource::ListNow() {
  KeptIndex kept = ReadKeptIndex();
  absl::StatusOr<ModelIndex> before = Read(kept);
  // One that was damaged must not stand in for the server's.
  if (!before.ok()) kept = {};
  absl::StatusOr<KeptIndex> now = GetIndex(kept);
  absl::StatusOr<ModelIndex> index =
      now.ok() ? ReadNext(*now, before)
               : absl::StatusOr<ModelIndex>(now.status());
  if (before.ok() && IsNoAnswer(index.status())) {
    Warn(absl::StrCat("going on with the last index: ",
                      index.status().message()));
    now = kept;
    index = std::move(before);
  }
  TL_RETURN_IF_ERROR(index.status());
  SourceListing listing{.models = {}, .scene_json = index->scene_json};
  std::map<std::string, std::string> urls;
  for (const IndexedModel& model : index->models) {
    const auto url = ResolveUrl(index_url_, model.url);
    if (!url.ok()) {
      return base::WithReason(
          Prefixed(absl::StrCat(PublicUrl(index_url_), ": scene ", model.scene,
                                ", version ", model.version),
                   url.status()),
          "INDEX_INVALID");
    }
    urls[model.sha256] = *url;
    listing.models.push_back({.scene = model.scene,
                              .version = model.version,
                              .bytes = model.bytes,
                              .fingerprint = model.sha256});
  }
  if (now->text != kept.text || now->etag != kept.etag) KeepIndex(*now);
  absl::MutexLock lock(&mutex_);
  urls_ = std::move(urls);
  return listing;
}

absl::StatusOr<std::string> HttpModelSource::LocalPath(const ModelRef& model) {
  if (!IsSha256(model.fingerprint)) {
    return absl::InvalidArgumentError("fingerprint: not a SHA-256");
  }
  return cache_->Find(model.fingerprint, model.bytes, options_.stop);
}

absl::StatusOr<std::string> HttpModelSource::Fetch(
    const ModelRef& model, const std::stop_token& stop) {
  if (!IsSha256(model.fingerprint)) {
    return absl::InvalidArgumentError("fingerprint: not a SHA-256");
  }
  std::string url;
  {
    absl::MutexLock lock(&mutex_);
    if (const auto found = urls_.find(model.fingerprint);
        found != urls_.end()) {
      url = found->second;
    }
  }
  const EitherStop either(stop, options_.stop);
  bool resumed = false;
  auto path = FetchOnce(model, url, either.token(), resumed);
  // What an earlier process left may be what is damaged.
  if (absl::IsDataLoss(path.status()) && resumed) {
    path = FetchOnce(model, url, either.token(), resumed);
  }
  if (path.ok()) return path;
  return Prefixed(
      absl::StrCat("scene ", model.scene, ", version ", model.version),
      path.status());
}

std::shared_ptr<const void> HttpModelSource::Keep(const ModelRef& model) {
  return cache_->Keep(model.fingerprint);
}

absl::StatusOr<std::string> HttpModelSource::FetchOnce(
    const ModelRef& model, const std::string& url, const std::stop_token& stop,
    bool& resumed) const {
  while (true) {
    auto cached = cache_->Find(model.fingerprint, model.bytes, stop);
    if (!absl::IsNotFound(cached.status())) return cached;
    if (url.empty()) {
      return base::WithReason(absl::NotFoundError("no longer in the index"),
                              "NOT_IN_INDEX");
    }
    TL_ASSIGN_OR_RETURN(const std::unique_ptr<CacheDownload> download,
                        cache_->Begin(model.fingerprint, model.bytes, stop));
    if (download == nullptr) continue;
    resumed = download->resumed();
    TL_RETURN_IF_ERROR(Download(url, *download, stop));
    return download->Commit();
  }
}

absl::Status HttpModelSource::Download(const std::string& url,
                                       CacheDownload& download,
                                       const std::stop_token& stop) const {
  DownloadSink sink(download);
  const auto attempt = [&]() -> absl::Status {
    if (download.size() == download.promised()) return absl::OkStatus();
    absl::Status got = HttpGet({.url = url, .offset = download.size()},
                               options_.http, clock_, sink, stop)
                           .status();
    if (base::ErrorInfoOf(got).reason == "RANGE_REFUSED" &&
        download.size() > 0) {
      TL_RETURN_IF_ERROR(download.Restart());
      got = HttpGet({.url = url}, options_.http, clock_, sink, stop).status();
    }
    TL_RETURN_IF_ERROR(got);
    if (download.size() == download.promised()) return absl::OkStatus();
    return absl::UnavailableError(kShort);
  };
  absl::Status status = Retry(options_.retry, options_.seed, sleep_, stop,
                              attempt, [&] { return download.size(); });
  // The server says each time that this is all: Commit() says what is wrong.
  if (absl::IsUnavailable(status) && status.message() == kShort) {
    return absl::OkStatus();
  }
  return status;
}

}  // namespace treeline::repository
