#include "evaluation/accuracy/foreign_images.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "common/base/parallel_for.h"
#include "common/base/progress.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "evaluation/accuracy/query_calibration.h"

namespace treeline::accuracy {
namespace {

constexpr uint64_t kSeed = 0x666f726569676eu;
constexpr size_t kNamesKept = 5;
constexpr int kColorKinds = 8;
constexpr int kDepthKinds = 5;

uint8_t ToByte(double value) {
  return static_cast<uint8_t>(std::clamp(std::lround(value), 0L, 255L));
}

struct Rgb {
  double r = 0;
  double g = 0;
  double b = 0;
};

Rgb RandomColor(base::Random& random) {
  return {random.NextUniform(10, 245), random.NextUniform(10, 245),
          random.NextUniform(10, 245)};
}

// One value a cell of `grain` pixels, in [0, 1].
class Cells {
 public:
  Cells(int width, int height, int grain, base::Random& random)
      : grain_(grain), columns_(width / grain + 1) {
    const int rows = height / grain + 1;
    for (int i = 0; i < 3 * columns_ * rows; ++i) {
      values_.push_back(random.NextUnit());
    }
  }
  double At(int x, int y, int channel) const {
    const int cell = y / grain_ * columns_ + x / grain_;
    return values_[static_cast<size_t>(3 * cell + channel)];
  }

 private:
  const int grain_;
  const int columns_;
  std::vector<double> values_;
};

// A picture as a function of place and channel.
template <typename Value>
image::ColorImage Painted(int width, int height, const Value& value) {
  image::ColorImage image{width, height, {}};
  image.rgb.reserve(3 * static_cast<size_t>(width) *
                    static_cast<size_t>(height));
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int c = 0; c < 3; ++c) image.rgb.push_back(ToByte(value(x, y, c)));
    }
  }
  return image;
}

double Channel(const Rgb& color, int c) {
  return c == 0 ? color.r : (c == 1 ? color.g : color.b);
}

image::ColorImage ForeignColor(int width, int height, int kind,
                               base::Random& random) {
  const Rgb a = RandomColor(random);
  const Rgb b = RandomColor(random);
  const double angle = random.NextUniform(0, 6.28);
  const double dx = std::cos(angle) / width;
  const double dy = std::sin(angle) / height;
  const auto mix = [&](double fraction, int c) {
    return Channel(a, c) + fraction * (Channel(b, c) - Channel(a, c));
  };
  switch (kind) {
    case 0:  // black, or white: a covered or a blinded lens
      return Painted(width, height,
                     [&, white = random.NextUnit() < 0.3](int, int, int) {
                       return white ? 255.0 : 0.0;
                     });
    case 1:  // a wall
      return Painted(width, height,
                     [&](int, int, int c) { return Channel(a, c); });
    case 2: {  // a wall as a sensor sees it
      const double sigma = random.NextUniform(1, 8);
      return Painted(width, height, [&](int, int, int c) {
        return Channel(a, c) + sigma * random.NextGaussian();
      });
    }
    case 3:  // a wall that a lamp lights from one side
      return Painted(width, height, [&](int x, int y, int c) {
        return mix(0.5 + 0.5 * (x * dx + y * dy), c);
      });
    case 4: {  // stripes or tiles
      const double period_px = random.NextUniform(8, 90);
      const bool tiles = random.NextUnit() < 0.5;
      return Painted(width, height, [&](int x, int y, int c) {
        const double u =
            std::sin(6.28 * (x * dx * width + y * dy * height) / period_px);
        const double v =
            std::sin(6.28 * (y * dx * height - x * dy * width) / period_px);
        return mix((tiles ? u * v : u) > 0 ? 1 : 0, c);
      });
    }
    case 5:  // noise, a value a pixel
      return Painted(width, height,
                     [&](int, int, int) { return 255 * random.NextUnit(); });
    default: {  // noise of coarser grain
      const Cells cells(width, height, kind == 6 ? 8 : 40, random);
      return Painted(width, height, [&](int x, int y, int c) {
        return 255 * cells.At(x, y, c);
      });
    }
  }
}

image::DepthImage ForeignDepth(int width, int height, int kind,
                               base::Random& random) {
  image::DepthImage depth{width, height, {}, 0.001};
  depth.values.reserve(static_cast<size_t>(width) *
                       static_cast<size_t>(height));
  const double base_mm = random.NextUniform(600, 4000);
  const double slope_x = random.NextUniform(-0.8, 0.8) * base_mm / width;
  const double slope_y = random.NextUniform(-0.8, 0.8) * base_mm / height;
  const Cells cells(width, height, 40, random);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double mm = base_mm;
      switch (kind) {
        case 0:  // a wall seen straight on
          mm += 0.002 * base_mm * random.NextGaussian();
          break;
        case 1:  // a slanted one
          mm += slope_x * (x - width / 2) + slope_y * (y - height / 2);
          break;
        case 2:  // boxes
          mm = 500 + 4000 * cells.At(x, y, 0);
          break;
        case 3:  // noise
          mm = 500 + 4000 * random.NextUnit();
          break;
        default:  // nothing was measured
          mm = 0;
      }
      depth.values.push_back(
          static_cast<uint16_t>(std::clamp(mm, 0.0, 60000.0)));
    }
  }
  return depth;
}

// Asks about one source.
class ForeignAsker {
 public:
  ForeignAsker(const localizer::Localizer& localizer,
               double confidence_threshold, const EvaluationOptions& options)
      : localizer_(localizer),
        confidence_threshold_(confidence_threshold),
        options_(options) {}

  absl::StatusOr<std::vector<NegativeTally>> Ask(const NegativeSource& source) {
    std::optional<dataset::Dataset> dataset;
    std::optional<camera::RgbdCalibration> calibration;
    if (!source.builtin) {
      TL_ASSIGN_OR_RETURN(dataset, dataset::Dataset::Open(source.dataset));
      calibration = QueryCalibration(*dataset, source.dataset,
                                     localizer_.info().calibration);
    }
    const int count = dataset ? dataset->size() : source.builtin_count;
    std::vector<Answers> answers(static_cast<size_t>(count));
    {
      base::Progress progress("foreign images", std::max(count, 1),
                              options_.quiet);
      base::ParallelFor(count, options_.threads, [&](int64_t i) {
        if (options_.stop.stop_requested()) return;
        const int index = static_cast<int>(i);
        absl::StatusOr<image::Frame> frame =
            dataset ? dataset->Load(index)
                    : BuiltinForeignFrame(localizer_.info().calibration, index);
        if (frame.ok())
          if (calibration) frame->calibration = calibration;
        answers[static_cast<size_t>(i)] = AskTwice(std::move(frame));
        progress.Add(1);
      });
    }
    if (options_.stop.stop_requested()) {
      return absl::CancelledError("evaluation was interrupted");
    }
    std::vector<NegativeTally> tallies(2);
    for (const bool with_depth : {true, false}) {
      NegativeTally& tally = tallies[with_depth ? 0 : 1];
      tally.source = source.name;
      tally.with_depth = with_depth;
      for (int i = 0; i < count; ++i) {
        const Answers& answer = answers[static_cast<size_t>(i)];
        Count(with_depth ? answer.with_depth : answer.without_depth,
              dataset ? dataset->frame(i).stem : absl::StrCat("picture ", i),
              tally);
      }
    }
    return tallies;
  }

 private:
  struct Answer {
    bool asked = false;
    bool unreadable = false;
    absl::StatusOr<localizer::PoseEstimate> estimate =
        localizer::PoseEstimate{};
  };
  struct Answers {
    Answer with_depth;
    Answer without_depth;
  };

  Answers AskTwice(absl::StatusOr<image::Frame> frame) const {
    Answers answers;
    if (!frame.ok()) {
      answers.with_depth = {true, true, frame.status()};
      return answers;
    }
    const localizer::LocalizeOptions query = options_.Query();
    if (frame->depth) {
      answers.with_depth = {true, false, localizer_.Localize(*frame, query)};
      frame->depth.reset();
    }
    answers.without_depth = {true, false, localizer_.Localize(*frame, query)};
    return answers;
  }

  void Count(const Answer& answer, const std::string& name,
             NegativeTally& tally) const {
    if (!answer.asked) return;
    ++tally.images;
    if (!answer.estimate.ok()) {
      ++(answer.unreadable ? tally.unreadable : tally.refused);
      if (answer.unreadable && tally.problems.size() < kNamesKept) {
        tally.problems.emplace_back(answer.estimate.status().message());
      }
      return;
    }
    if (answer.estimate->outcome != localizer::Outcome::kLocalized) {
      ++tally.not_localized;
      return;
    }
    ++tally.accepted;
    tally.confident += answer.estimate->confidence >= confidence_threshold_;
    if (tally.accepted_names.size() < kNamesKept) {
      tally.accepted_names.push_back(name);
    }
  }

  const localizer::Localizer& localizer_;
  const double confidence_threshold_;
  const EvaluationOptions& options_;
};

// "color-camera=...", "depth-camera=..." or "depth-unit=...".
absl::Status SetForeignCamera(absl::string_view text,
                              dataset::DatasetOptions& options) {
  const std::pair<absl::string_view, absl::string_view> parts =
      absl::StrSplit(text, absl::MaxSplits('=', 1));
  const auto& [name, value] = parts;
  if (!value.empty() && name == "color-camera") {
    options.color_camera = std::string(value);
  } else if (!value.empty() && name == "depth-camera") {
    options.depth_camera = std::string(value);
  } else if (name != "depth-unit" ||
             !absl::SimpleAtod(value, &options.depth_unit_m)) {
    return absl::InvalidArgumentError(
        absl::StrCat("\"", text,
                     "\" says nothing about a foreign recording's cameras: it "
                     "must be color-camera=CAMERA, depth-camera=CAMERA or "
                     "depth-unit=M"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<NegativeSource> ParseForeignSource(absl::string_view whole) {
  NegativeSource source;
  source.name = std::string(whole);
  const std::vector<absl::string_view> parts = absl::StrSplit(whole, ';');
  const absl::string_view text = parts.front();
  for (size_t i = 1; i < parts.size(); ++i) {
    TL_RETURN_IF_ERROR(SetForeignCamera(parts[i], source.dataset));
  }
  absl::string_view rest = text;
  if (absl::ConsumePrefix(&rest, "builtin")) {
    source.builtin = true;
    source.builtin_count = kBuiltinForeignImages;
    // Built-in pictures have the scene's cameras.
    if (rest.empty() && parts.size() == 1) return source;
    if (parts.size() == 1 && absl::ConsumePrefix(&rest, ",") &&
        absl::SimpleAtoi(rest, &source.builtin_count) &&
        source.builtin_count > 0) {
      return source;
    }
  } else if (const size_t colon = text.find(':');
             colon != absl::string_view::npos && colon > 0) {
    // colmap:MODEL,IMAGES has a comma of its own.
    size_t comma = text.find(',');
    if (absl::StartsWith(text, "colmap:") && comma != absl::string_view::npos) {
      comma = text.find(',', comma + 1);
    }
    source.dataset.uri = std::string(text.substr(0, comma));
    if (comma != absl::string_view::npos) {
      source.dataset.frame_list = std::string(text.substr(comma + 1));
    }
    return source;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("\"", whole,
                   "\" names no foreign images: it must be builtin, builtin,N, "
                   "URI or URI,FRAMES"));
}

image::Frame BuiltinForeignFrame(const camera::RgbdCalibration& calibration,
                                 int index) {
  base::Random random(kSeed, static_cast<uint64_t>(index));
  image::Frame frame;
  frame.color =
      ForeignColor(calibration.color.width(), calibration.color.height(),
                   index % kColorKinds, random);
  frame.depth =
      ForeignDepth(calibration.depth.width(), calibration.depth.height(),
                   index / kColorKinds % kDepthKinds, random);
  return frame;
}

absl::StatusOr<std::vector<NegativeTally>> AskForeign(
    const localizer::Localizer& localizer,
    const std::vector<NegativeSource>& sources, double confidence_threshold,
    const EvaluationOptions& options) {
  ForeignAsker asker(localizer, confidence_threshold, options);
  std::vector<NegativeTally> tallies;
  for (const NegativeSource& source : sources) {
    TL_ASSIGN_OR_RETURN(const std::vector<NegativeTally> of_source,
                        asker.Ask(source));
    tallies.insert(tallies.end(), of_source.begin(), of_source.end());
  }
  return tallies;
}

}  // namespace treeline::accuracy
