#include "evaluation/accuracy/scene_recognition.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/status_macros.h"
#include "evaluation/accuracy/query_calibration.h"
#include "server/core/recognition/appearance_words.h"

namespace treeline::accuracy {
namespace {

namespace fs = std::filesystem;

template <typename Predicate>
int CountFrames(const std::vector<RecognizedFrame>& frames,
                const Predicate& predicate) {
  return static_cast<int>(std::ranges::count_if(frames, predicate));
}

// As the server has it: numbers by value, older than all that are none.
bool IsOlderVersion(const std::string& a, const std::string& b) {
  const auto is_number = [](const std::string& text) {
    return text.find_first_not_of("0123456789") == std::string::npos;
  };
  if (is_number(a) != is_number(b)) return is_number(a);
  if (is_number(a) && a.size() != b.size()) return a.size() < b.size();
  return a < b;
}

// Asks about the frames of one query.
class QueryRun {
 public:
  QueryRun(SceneModels& models, const RecognitionQuery& query,
           const RecognitionOptions& options, const base::Clock& clock)
      : models_(models), query_(query), options_(options), clock_(clock) {}

  absl::StatusOr<RecognitionTally> Run() {
    RecognitionTally tally{query_.scene, query_.source.name, {}};
    if (!query_.source.builtin) {
      TL_ASSIGN_OR_RETURN(dataset_,
                          dataset::Dataset::Open(query_.source.dataset));
    }
    const int available =
        dataset_ ? dataset_->size() : query_.source.builtin_count;
    const int count = (available + options_.every - 1) / options_.every;
    tally.frames.resize(static_cast<size_t>(count));
    base::Progress progress(
        query_.scene.empty() ? "foreign images" : query_.scene,
        std::max(count, 1), options_.quiet);
    base::ParallelFor(count, options_.threads, [&](int64_t i) {
      if (options_.stop.stop_requested()) return;
      tally.frames[static_cast<size_t>(i)] =
          Ask(static_cast<int>(i) * options_.every);
      progress.Add(1);
    });
    if (options_.stop.stop_requested()) {
      return absl::CancelledError("recognition was interrupted");
    }
    return tally;
  }

 private:
  absl::StatusOr<image::Frame> Load(int i) const {
    if (dataset_) return dataset_->Load(i);
    // Of the first scene's camera.
    TL_ASSIGN_OR_RETURN(const std::shared_ptr<const localizer::Localizer> any,
                        models_.Acquire(models_.scenes().front()));
    return BuiltinForeignFrame(any->info().calibration, i);
  }

  RecognizedFrame Ask(int i) const {
    RecognizedFrame result;
    result.stem =
        dataset_ ? dataset_->frame(i).stem : absl::StrCat("picture ", i);
    absl::StatusOr<image::Frame> frame = Load(i);
    if (!frame.ok()) {
      result.status = frame.status();
      return result;
    }
    if (options_.no_depth) frame->depth.reset();
    const base::MonotonicTime start = clock_.Now();
    recognition::AppearanceWords extractor;
    const std::vector<uint32_t>& words = extractor.Extract(frame->color);
    const base::MonotonicTime extracted = clock_.Now();
    const std::vector<recognition::SceneScore> ranking =
        models_.index().RankWords(words);
    const base::MonotonicTime ranked = clock_.Now();
    result.words_ms = base::MillisecondsBetween(start, extracted);
    result.rank_ms = base::MillisecondsBetween(extracted, ranked);
    result.first = ranking.front().scene;
    for (size_t k = 0; k < ranking.size(); ++k) {
      if (ranking[k].scene == query_.scene) {
        result.rank = static_cast<int>(k) + 1;
      }
    }
    if (!options_.rank_only) FindPose(*std::move(frame), ranking, result);
    return result;
  }

  void FindPose(image::Frame frame,
                const std::vector<recognition::SceneScore>& ranking,
                RecognizedFrame& result) const {
    const std::optional<camera::RgbdCalibration> own = frame.calibration;
    const auto acquire = [&](const std::string& scene)
        -> absl::StatusOr<recognition::SceneToTry> {
      recognition::SceneToTry to_try;
      TL_ASSIGN_OR_RETURN(to_try.localizer, models_.Acquire(scene));
      to_try.calibration =
          own || !dataset_
              ? own
              : QueryCalibration(*dataset_, query_.source.dataset,
                                 to_try.localizer->info().calibration);
      return to_try;
    };
    const base::MonotonicTime start = clock_.Now();
    const absl::StatusOr<recognition::AmongResult> among =
        recognition::LocalizeAmong(
            std::move(frame), ranking, acquire,
            {.seed = options_.seed, .stop = options_.stop}, options_.among);
    result.pose_ms = base::MillisecondsBetween(start, clock_.Now());
    result.status = among.status();
    if (!among.ok()) return;
    result.answer = among->scene;
    result.localized =
        among->estimate.outcome == localizer::Outcome::kLocalized;
    result.confidence = among->estimate.confidence;
    for (const recognition::ConsideredScene& considered : among->considered) {
      result.tried += considered.tried;
    }
  }

  SceneModels& models_;
  const RecognitionQuery& query_;
  const RecognitionOptions& options_;
  const base::Clock& clock_;
  std::optional<dataset::Dataset> dataset_;
};

}  // namespace

absl::StatusOr<RecognitionQuery> ParseRecognitionQuery(absl::string_view text) {
  const size_t equals = text.find('=');
  if (equals == absl::string_view::npos || equals == 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", text, "\" must be SCENE=URI or SCENE=URI,FRAMES"));
  }
  RecognitionQuery query;
  query.scene = std::string(text.substr(0, equals));
  TL_ASSIGN_OR_RETURN(query.source,
                      ParseForeignSource(text.substr(equals + 1)));
  return query;
}

int RecognitionTally::first_in_ranking() const { return among_first(1); }

int RecognitionTally::among_first(int count) const {
  return CountFrames(frames, [&](const RecognizedFrame& f) {
    return f.rank > 0 && f.rank <= count;
  });
}

int RecognitionTally::right_scene() const {
  return CountFrames(frames, [&](const RecognizedFrame& f) {
    return !f.answer.empty() && f.answer == scene;
  });
}

int RecognitionTally::right_localized() const {
  return CountFrames(frames, [&](const RecognizedFrame& f) {
    return f.localized && f.answer == scene;
  });
}

int RecognitionTally::wrong_localized() const {
  return CountFrames(frames, [&](const RecognizedFrame& f) {
    return f.localized && f.answer != scene;
  });
}

int RecognitionTally::errors() const {
  return CountFrames(frames,
                     [](const RecognizedFrame& f) { return !f.status.ok(); });
}

absl::StatusOr<std::unique_ptr<SceneModels>> SceneModels::Open(
    const std::string& folder) {
  std::unique_ptr<SceneModels> models(new SceneModels);
  TL_RETURN_IF_ERROR(models->Read(folder));
  return models;
}

absl::Status SceneModels::Read(const std::string& folder) {
  std::error_code error;
  for (const fs::directory_entry& scene :
       fs::directory_iterator(folder, error)) {
    std::error_code ignored;
    std::string newest;
    for (const fs::directory_entry& version :
         fs::directory_iterator(scene.path(), ignored)) {
      const std::string name = version.path().filename().string();
      if (fs::exists(version.path() / "model.treeline", ignored) &&
          (newest.empty() || IsOlderVersion(newest, name))) {
        newest = name;
      }
    }
    if (newest.empty()) continue;
    paths_[scene.path().filename().string()] =
        (scene.path() / newest / "model.treeline").string();
  }
  if (error) {
    return absl::NotFoundError(absl::StrCat(folder, ": ", error.message()));
  }
  if (paths_.empty()) {
    return absl::NotFoundError(
        absl::StrCat(folder, ": no <scene>/<version>/model.treeline in it"));
  }
  const base::SteadyClock clock;
  const base::MonotonicTime start = clock.Now();
  for (const auto& [scene, path] : paths_) {
    absl::StatusOr<recognition::SceneDescriptor> descriptor =
        recognition::ReadSceneDescriptor(path);
    if (absl::IsNotFound(descriptor.status())) {
      return absl::InvalidArgumentError(absl::StrCat(
          path,
          ": the model says not what its scene looks like; train it "
          "with this version"));
    }
    TL_RETURN_IF_ERROR(descriptor.status());
    index_.Set(scene, *descriptor);
    scenes_.push_back(scene);
  }
  read_ms_ = base::MillisecondsBetween(start, clock.Now());
  return absl::OkStatus();
}

absl::StatusOr<std::shared_ptr<const localizer::Localizer>>
SceneModels::Acquire(const std::string& scene) {
  const auto path = paths_.find(scene);
  if (path == paths_.end()) return absl::NotFoundError(scene);
  absl::MutexLock lock(&mutex_);
  std::shared_ptr<const localizer::Localizer>& localizer = open_[scene];
  if (localizer == nullptr) {
    TL_ASSIGN_OR_RETURN(localizer, localizer::OpenLocalizer(path->second));
  }
  return localizer;
}

absl::StatusOr<std::vector<RecognitionTally>> Recognize(
    SceneModels& models, const std::vector<RecognitionQuery>& queries,
    const RecognitionOptions& options, const base::Clock& clock) {
  if (options.every < 1) {
    return absl::InvalidArgumentError("every must be positive");
  }
  if (!options.rank_only) {  // opening is no part of a query's time
    for (const std::string& scene : models.scenes()) {
      TL_RETURN_IF_ERROR(models.Acquire(scene).status());
    }
  }
  std::vector<RecognitionTally> tallies;
  for (const RecognitionQuery& query : queries) {
    if (!query.scene.empty() && !models.index().Contains(query.scene)) {
      return absl::NotFoundError(
          absl::StrCat("no model of scene \"", query.scene, "\""));
    }
    TL_ASSIGN_OR_RETURN(RecognitionTally tally,
                        QueryRun(models, query, options, clock).Run());
    tallies.push_back(std::move(tally));
  }
  return tallies;
}

}  // namespace treeline::accuracy
