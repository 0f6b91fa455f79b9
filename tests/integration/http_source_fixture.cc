#include "tests/integration/http_source_fixture.h"

#include <unistd.h>

#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"

namespace treeline {

namespace fs = std::filesystem;

void HttpSourceTest::SetUp() {
  server_ = std::make_unique<WebServer>();
  folder_ = absl::StrCat(
      testing::TempDir(), "/http-source-", getpid(), "-",
      testing::UnitTest::GetInstance()->current_test_info()->name());
  fs::remove_all(folder_);
  options_.url = server_->address() + "/index.json";
  options_.cache.folder = folder_;
  options_.warn = [this](absl::string_view message) {
    warnings_.emplace_back(message);
  };
}

void HttpSourceTest::TearDown() {
  source_.reset();
  server_.reset();
  fs::remove_all(folder_);
}

std::string HttpSourceTest::Model(size_t bytes, char first) {
  std::string model(bytes, first);
  base::Random random(7, static_cast<uint64_t>(first));
  for (size_t i = 1; i < bytes; ++i) {
    model[i] = static_cast<char>(random.NextBits());
  }
  return model;
}

std::string HttpSourceTest::DigestOf(const std::string& bytes) {
  repository::Sha256 hash;
  hash.Update(bytes);
  return hash.Finish();
}

void HttpSourceTest::Serve(const std::string& model,
                           std::vector<WebAnswer> answers,
                           const std::string& url) {
  model_ = model;
  const repository::ModelIndex index{
      .models = {{.scene = "kitchen",
                  .version = "7",
                  .bytes = model.size(),
                  .sha256 = DigestOf(model),
                  .url = url}},
      .scene_json = {{"kitchen", R"({"display_name":"Kitchen"})"}}};
  server_->Put("/index.json", repository::ModelIndexJson(index).value());
  server_->Put("/" + url, model, std::move(answers));
}

void HttpSourceTest::Open() {
  source_.reset();
  auto source = repository::HttpModelSource::Open(
      options_, clock_,
      [this](std::chrono::milliseconds time, const std::stop_token&) {
        pauses_.push_back(time);
      });
  ASSERT_TRUE(source.ok()) << source.status();
  source_ = *std::move(source);
}

repository::ModelRef HttpSourceTest::RefOf(const std::string& model) const {
  return {.scene = "kitchen",
          .version = "7",
          .bytes = model.size(),
          .fingerprint = DigestOf(model)};
}

absl::StatusOr<std::string> HttpSourceTest::Fetch(const std::stop_token& stop) {
  if (source_ == nullptr) {
    Open();
    TL_RETURN_IF_ERROR(source_->List().status());
  }
  return source_->Fetch(RefOf(model_), stop);
}

void HttpSourceTest::FetchAndExit() {
  const auto path = Fetch();
  _exit(path.ok() ? 0 : 1);
}

std::set<std::string> HttpSourceTest::CachedNames() const {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder_ + "/sha256")) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

}  // namespace treeline
