#include "nav_agent/localization/place_hypotheses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

namespace treeline::localization {
namespace {

// Of what the odometry may be off, the steps in which a fit is looked for: from
// both sides of where the wheels say, then between.
constexpr std::array<double, 2> kFitSteps = {1, 0.5};
// A search looks at so many viewpoints at once, the newest: over two metres the
// odometry is as good as a beam's end is sharp.
constexpr size_t kSearchViewpoints = 5;
// A beam that hits nothing.
const double kMiss = std::log(1 - kBeamHitShare);

// What the odometry may be off (m, rad) over a way.
struct OdometryError {
  double m = 0;
  double rad = 0;
};

OdometryError ErrorOver(const geometry::Rigid2& from_from_to,
                        const OdometryNoise& noise) {
  const double way_m = geometry::Norm(from_from_to.translation);
  const double turn_rad = std::abs(from_from_to.yaw_rad);
  return {.m = kRefineStep_m / 2 + noise.drive_from_drive * way_m +
               noise.drive_from_turn * turn_rad,
          .rad = kRefineTurnPerStep * kRefineStep_m / 2 +
                 noise.turn_from_turn * turn_rad +
                 noise.turn_from_drive * way_m};
}

ScanPoints Thinned(const ScanPoints& points, size_t at_most) {
  if (points.size() <= at_most) return points;
  ScanPoints some;
  for (size_t i = 0; i < at_most; ++i) {
    some.Add(points, i * points.size() / at_most);
  }
  return some;
}

}  // namespace

PlaceHypotheses::PlaceHypotheses(const PlaceHypothesesOptions& options,
                                 const OdometryNoise& odometry)
    : options_(options),
      // Maps are bent, too: none is taken to be better.
      odometry_(odometry.AtLeastUsual()) {}

// ---- what is followed ----

PlaceHypotheses::Fit PlaceHypotheses::Fitted(const PlaceMap& map,
                                             const Viewpoint& viewpoint,
                                             const core::LevelPose& about,
                                             double std_m, double std_rad) {
  const double beams = static_cast<double>(viewpoint.points.size());
  // As many as are independent, of beams that are neighbours.
  const double per_beam = kScanBeams / kIndependentBeams / beams;
  Fit best = {.pose = about, .score = -1e9F};
  PoseArrays poses;
  std::vector<core::LevelPose> tried;
  std::vector<float> penalties;
  for (const double step : kFitSteps) {
    tried.clear();
    penalties.clear();
    const core::LevelPose center = best.pose;
    for (int x = -1; x <= 1; ++x) {
      for (int y = -1; y <= 1; ++y) {
        for (int yaw = -1; yaw <= 1; ++yaw) {
          core::LevelPose pose = center;
          pose.map_from_base.translation =
              pose.map_from_base.translation +
              geometry::Vec2{x * step * std_m, y * step * std_m};
          pose.map_from_base.yaw_rad = geometry::NormalizedAngle_rad(
              pose.map_from_base.yaw_rad + yaw * step * std_rad);
          const double off_m = geometry::Norm(pose.map_from_base.translation -
                                              about.map_from_base.translation) /
                               std_m;
          const double off_rad =
              geometry::NormalizedAngle_rad(pose.map_from_base.yaw_rad -
                                            about.map_from_base.yaw_rad) /
              std_rad;
          penalties.push_back(static_cast<float>(
              -0.5 * (off_m * off_m + off_rad * off_rad) * per_beam));
          tried.push_back(pose);
        }
      }
    }
    poses.Resize(tried.size());
    for (size_t i = 0; i < tried.size(); ++i) {
      poses.Set(i, tried[i].map_from_base, tried[i].place.height_m);
    }
    std::vector<float> sums(tried.size());
    map.field->SumLogLikelihoods(viewpoint.points, poses, sums);
    budget_ -= static_cast<int64_t>(tried.size());
    for (size_t i = 0; i < tried.size(); ++i) {
      const float score =
          static_cast<float>(static_cast<double>(sums[i]) / beams) +
          penalties[i];
      if (score > best.score) best = {.pose = tried[i], .score = score};
    }
  }
  if (!IsOnGround(map, best.pose)) {
    best.score += static_cast<float>(kOffGroundShare * kMiss);
  }
  best.score = std::max(best.score, static_cast<float>(kMiss));
  return best;
}

bool PlaceHypotheses::IsOnGround(const PlaceMap& map,
                                 core::LevelPose& pose) const {
  if (map.levels == nullptr) return ground_.Has(pose.map_from_base.translation);
  const std::optional<core::LevelPlace> ground = map.levels->GroundNear(
      pose.map_from_base.translation, pose.place.height_m);
  if (ground.has_value()) pose.place = *ground;
  return ground.has_value();
}

PlaceHypotheses::Fit PlaceHypotheses::Followed(const PlaceMap& map,
                                               int64_t from,
                                               const core::LevelPose& pose,
                                               int64_t to) {
  const geometry::Rigid2 from_from_to =
      At(from).odom_from_base.Inverse() * At(to).odom_from_base;
  const OdometryError error = ErrorOver(from_from_to, odometry_);
  return Fitted(
      map, At(to),
      {.map_from_base = pose.map_from_base * from_from_to, .place = pose.place},
      error.m, error.rad);
}

void PlaceHypotheses::Extend(const PlaceMap& map, Hypothesis& hypothesis) {
  if (hypothesis.last() < newest()) {
    hypothesis.fits.push_back(Followed(map, hypothesis.last(),
                                       hypothesis.fits.back().pose,
                                       hypothesis.last() + 1));
  } else {
    hypothesis.fits.push_front(Followed(map, hypothesis.first,
                                        hypothesis.fits.front().pose,
                                        hypothesis.first - 1));
    --hypothesis.first;
  }
}

core::LevelPose PlaceHypotheses::PoseOf(
    const Hypothesis& hypothesis,
    const geometry::Rigid2& odom_from_base) const {
  const core::LevelPose& pose = hypothesis.fits.back().pose;
  return {.map_from_base =
              pose.map_from_base *
              (At(hypothesis.last()).odom_from_base.Inverse() * odom_from_base),
          .place = pose.place};
}

double PlaceHypotheses::Evidence(const Hypothesis& one,
                                 const Hypothesis& other) const {
  const int64_t begin = std::max({one.first, other.first, oldest_});
  const int64_t end = std::min(one.last(), other.last());
  double evidence = 0;
  for (int64_t k = begin; k <= end; ++k) {
    const double difference = static_cast<double>(one.At(k).score) -
                              static_cast<double>(other.At(k).score);
    const double clear = std::abs(difference) - options_.tolerance;
    if (clear <= 0) continue;
    const double beams = static_cast<double>(At(k).points.size()) *
                         kIndependentBeams / kScanBeams;
    evidence += std::copysign(std::min(beams * clear, options_.max_evidence),
                              difference);
  }
  return evidence;
}

// ---- from outside ----

void PlaceHypotheses::BeginDoubt() {
  EndDoubt();
  in_doubt_ = true;
  share_ = 0;
}

void PlaceHypotheses::EndDoubt() {
  in_doubt_ = false;
  viewpoints_.clear();
  oldest_ = 0;
  hypotheses_.clear();
  against_.clear();
  believed_ = 0;
  search_.reset();
  candidates_.clear();
  searched_ = -1;
  searches_done_ = 0;
  share_ = 1;
}

void PlaceHypotheses::AddScan(const geometry::Rigid2& odom_from_base,
                              const ScanPoints& points) {
  if (!in_doubt_) return;
  if (!viewpoints_.empty()) {
    const geometry::Rigid2 since =
        viewpoints_.back().odom_from_base.Inverse() * odom_from_base;
    if (geometry::Norm(since.translation) < options_.viewpoint_m &&
        std::abs(since.yaw_rad) < options_.viewpoint_rad) {
      return;
    }
  }
  if (points.size() < kMinViewpointBeams) return;
  has_new_viewpoint_ = true;
  viewpoints_.push_back({odom_from_base, points});
  if (viewpoints_.size() <= options_.viewpoints) return;
  viewpoints_.pop_front();
  ++oldest_;
  if (searched_ < oldest_) {
    search_.reset();
    candidates_.clear();
  }
  std::erase_if(hypotheses_, [this](Hypothesis& hypothesis) {
    if (hypothesis.last() < oldest_) return true;
    while (hypothesis.first < oldest_) {
      hypothesis.fits.pop_front();
      ++hypothesis.first;
    }
    return false;
  });
}

void PlaceHypotheses::Step(const PlaceMap& map,
                           const geometry::Rigid2& odom_from_base,
                           const std::optional<core::LevelPose>& believed) {
  if (!in_doubt_ || viewpoints_.empty()) return;
  if (map.levels == nullptr && ground_.is_empty()) {
    ground_ = GroundSquares(*map.places);
  }
  budget_ = static_cast<int64_t>(options_.slice);
  if (believed.has_value()) {
    FindBelieved(map, odom_from_base, *believed);
  } else {
    BelieveBest();
  }
  ExtendAll(map);
  Exclude();
  if (std::exchange(has_new_viewpoint_, false)) MergeTwins();
  StepSearch(map);
  Judge(believed.has_value());
}

// ---- parts of a step ----

void PlaceHypotheses::FindBelieved(const PlaceMap& map,
                                   const geometry::Rigid2& odom_from_base,
                                   const core::LevelPose& believed) {
  std::optional<size_t> found;
  double nearest_m = 0;
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    const core::LevelPose pose = PoseOf(hypotheses_[i], odom_from_base);
    if (!AreNear(pose, believed, kOtherPlace_m, kOtherPlace_rad)) continue;
    const double away_m = geometry::Norm(pose.map_from_base.translation -
                                         believed.map_from_base.translation);
    if (!found.has_value() || away_m < nearest_m) {
      found = i;
      nearest_m = away_m;
    }
  }
  // What was excluded was so by another place: all over again.
  const bool is_same = found.has_value() &&
                       against_.size() == hypotheses_.size() &&
                       (*found == believed_ ||
                        AreNear(PoseOf(hypotheses_[*found], odom_from_base),
                                PoseOf(hypotheses_[believed_], odom_from_base),
                                kOtherPlace_m, kOtherPlace_rad));
  if (!is_same) searches_done_ = 0;
  if (!found.has_value()) {
    const geometry::Rigid2 now_from_newest =
        odom_from_base.Inverse() * viewpoints_.back().odom_from_base;
    Hypothesis hypothesis = {.first = newest(), .fits = {}};
    hypothesis.fits.push_back(
        Fitted(map, viewpoints_.back(),
               {.map_from_base = believed.map_from_base * now_from_newest,
                .place = believed.place},
               kRefineStep_m, kRefineTurnPerStep * kRefineStep_m));
    found = hypotheses_.size();
    hypotheses_.push_back(std::move(hypothesis));
  }
  believed_ = *found;
}

void PlaceHypotheses::BelieveBest() {
  if (against_.size() != hypotheses_.size() || hypotheses_.empty()) return;
  // Evidence is against the believed place: what that had excluded, a better
  // one excludes as well.
  const auto best = static_cast<size_t>(std::ranges::min_element(against_) -
                                        against_.begin());
  if (against_[best] < 0) believed_ = best;
}

void PlaceHypotheses::ExtendAll(const PlaceMap& map) {
  if (hypotheses_.empty()) return;
  // What all are compared with first.
  Hypothesis& believed = hypotheses_[believed_];
  while (!IsComplete(believed) && budget_ > 0) Extend(map, believed);
  for (size_t i = 0; i < hypotheses_.size() && budget_ > 0; ++i) {
    // No further than until it is excluded: most are soon.
    while (!IsComplete(hypotheses_[i]) && budget_ > 0 &&
           Evidence(believed, hypotheses_[i]) < options_.exclude) {
      Extend(map, hypotheses_[i]);
    }
  }
}

void PlaceHypotheses::Exclude() {
  against_.clear();
  std::vector<bool> is_excluded;
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    const double against =
        i == believed_ ? 0 : Evidence(hypotheses_[believed_], hypotheses_[i]);
    is_excluded.push_back(against >= options_.exclude);
    if (!is_excluded.back()) against_.push_back(against);
  }
  Remove(is_excluded);
}

void PlaceHypotheses::MergeTwins() {
  std::vector<bool> is_twin(hypotheses_.size());
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    if (is_twin[i]) continue;
    for (size_t k = i + 1; k < hypotheses_.size(); ++k) {
      if (is_twin[k] || hypotheses_[i].last() != hypotheses_[k].last() ||
          !AreNear(hypotheses_[i].fits.back().pose,
                   hypotheses_[k].fits.back().pose, kOtherPlace_m / 2,
                   kOtherPlace_rad / 2)) {
        continue;
      }
      // The one that explains less; never the believed one.
      const bool drops_first =
          k == believed_ || (i != believed_ && against_[i] > against_[k]);
      is_twin[drops_first ? i : k] = true;
      if (drops_first) break;
    }
  }
  std::vector<double> kept;
  for (size_t i = 0; i < against_.size(); ++i) {
    if (!is_twin[i]) kept.push_back(against_[i]);
  }
  against_ = std::move(kept);
  Remove(is_twin);
}

void PlaceHypotheses::Remove(const std::vector<bool>& is_gone) {
  std::vector<Hypothesis> kept;
  size_t believed = 0;
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    if (is_gone[i]) continue;
    if (i == believed_) believed = kept.size();
    kept.push_back(std::move(hypotheses_[i]));
  }
  hypotheses_ = std::move(kept);
  believed_ = believed;
}

void PlaceHypotheses::StepSearch(const PlaceMap& map) {
  if (!candidates_.empty()) TakeCandidates(map);
  if (budget_ <= 0 || !candidates_.empty()) return;
  if (!search_.has_value()) {
    if (searched_ == newest()) return;
    searched_ = newest();
    search_.emplace(map.places, NewestPoints(), std::nullopt,
                    GlobalPoseSearchOptions{.candidates = options_.candidates,
                                            .within = options_.search_within});
    return;
  }
  if (!search_->Step(*map.field, static_cast<size_t>(budget_))) return;
  candidates_ = search_->Best();
  std::ranges::reverse(candidates_);
  is_search_whole_ = !search_->is_cut_short();
  search_.reset();
}

ScanPoints PlaceHypotheses::NewestPoints() const {
  ScanPoints points;
  const size_t views = std::min(viewpoints_.size(), kSearchViewpoints);
  const geometry::Rigid2 newest_from_odom =
      viewpoints_.back().odom_from_base.Inverse();
  for (size_t i = viewpoints_.size() - views; i < viewpoints_.size(); ++i) {
    ScanPoints some = Thinned(viewpoints_[i].points, kScanBeams / views);
    const geometry::Rigid2 newest_from_view =
        newest_from_odom * viewpoints_[i].odom_from_base;
    for (size_t k = 0; k < some.size(); ++k) {
      const geometry::Vec2 end =
          newest_from_view * geometry::Vec2{some.x_m[k], some.y_m[k]};
      some.x_m[k] = static_cast<float>(end.x);
      some.y_m[k] = static_cast<float>(end.y);
      points.Add(some, k);
    }
  }
  return points;
}

void PlaceHypotheses::TakeCandidates(const PlaceMap& map) {
  while (!candidates_.empty() && budget_ > 0) {
    const Fit fit = Fitted(map, At(searched_), candidates_.back(),
                           kRefineStep_m, kRefineTurnPerStep * kRefineStep_m);
    candidates_.pop_back();
    const bool is_followed =
        std::ranges::any_of(hypotheses_, [&](const Hypothesis& other) {
          return other.Has(searched_) &&
                 AreNear(other.At(searched_).pose, fit.pose, kOtherPlace_m / 2,
                         kOtherPlace_rad / 2);
        });
    if (is_followed) continue;
    if (hypotheses_.size() >= 2 * options_.candidates) {
      is_search_whole_ = false;
      candidates_.clear();
      break;
    }
    hypotheses_.push_back({.first = searched_, .fits = {fit}});
    against_.push_back(0);
  }
  if (candidates_.empty() && is_search_whole_) ++searches_done_;
}

bool PlaceHypotheses::IsCompared() const {
  return candidates_.empty() && against_.size() == hypotheses_.size() &&
         std::ranges::all_of(hypotheses_, [this](const Hypothesis& one) {
           return IsComplete(one);
         });
}

void PlaceHypotheses::Judge(bool may_end) {
  double others = 0;
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    if (i != believed_ && IsComplete(hypotheses_[i])) {
      others += std::exp(std::min(-against_[i], 50.0));
    }
  }
  share_ = searches_done_ > 0 ? 1 / (1 + others) : 0;
  if (!may_end || !IsCompared() || searches_done_ < options_.searches) return;
  const core::LevelPose& here = hypotheses_[believed_].fits.back().pose;
  const bool is_alone =
      std::ranges::all_of(hypotheses_, [&here](const Hypothesis& other) {
        return AreNear(other.fits.back().pose, here, kOtherPlace_m,
                       kOtherPlace_rad);
      });
  if (is_alone) EndDoubt();
}

std::vector<PossiblePlace> PlaceHypotheses::Others(
    const geometry::Rigid2& odom_from_base, size_t at_most) const {
  std::vector<PossiblePlace> others;
  if (against_.size() != hypotheses_.size() || searches_done_ == 0) return {};
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    if (i == believed_ || !IsComplete(hypotheses_[i])) continue;
    others.push_back(
        {.pose = PoseOf(hypotheses_[i], odom_from_base),
         .share = share_ * std::exp(std::min(-against_[i], 50.0))});
  }
  std::ranges::stable_sort(others, std::greater(), &PossiblePlace::share);
  if (others.size() > at_most) others.resize(at_most);
  return others;
}

std::optional<core::LevelPose> PlaceHypotheses::Best(
    const geometry::Rigid2& odom_from_base) const {
  if (hypotheses_.empty() || searches_done_ == 0 || !IsCompared() ||
      viewpoints_.size() < kSearchViewpoints) {
    return std::nullopt;
  }
  const auto best = static_cast<size_t>(std::ranges::min_element(against_) -
                                        against_.begin());
  return PoseOf(hypotheses_[best], odom_from_base);
}

std::optional<core::LevelPose> PlaceHypotheses::Better(
    const geometry::Rigid2& odom_from_base) const {
  if (against_.size() != hypotheses_.size() || hypotheses_.empty()) {
    return std::nullopt;
  }
  const auto best = static_cast<size_t>(std::ranges::min_element(against_) -
                                        against_.begin());
  if (against_[best] > -options_.exclude || !IsComplete(hypotheses_[best]) ||
      !IsComplete(hypotheses_[believed_])) {
    return std::nullopt;
  }
  return PoseOf(hypotheses_[best], odom_from_base);
}

// ---- ground ----

GroundSquares::GroundSquares(const std::vector<FreePlace>& places) {
  if (places.empty()) return;
  const auto square = [](double m) {
    return static_cast<int64_t>(std::floor(m / kSearchGrid_m));
  };
  int64_t right = square(places.front().center.x);
  int64_t top = square(places.front().center.y);
  left_ = right;
  bottom_ = top;
  for (const FreePlace& place : places) {
    left_ = std::min(left_, square(place.center.x));
    right = std::max(right, square(place.center.x));
    bottom_ = std::min(bottom_, square(place.center.y));
    top = std::max(top, square(place.center.y));
  }
  --left_;
  --bottom_;
  width_ = right - left_ + 2;
  height_ = top - bottom_ + 2;
  is_free_.resize(static_cast<size_t>(width_ * height_));
  for (const FreePlace& place : places) {
    const int64_t x = square(place.center.x) - left_;
    const int64_t y = square(place.center.y) - bottom_;
    for (int64_t dy = -1; dy <= 1; ++dy) {
      for (int64_t dx = -1; dx <= 1; ++dx) {
        is_free_[static_cast<size_t>((y + dy) * width_ + x + dx)] = true;
      }
    }
  }
}

bool GroundSquares::Has(geometry::Vec2 point) const {
  const auto x =
      static_cast<int64_t>(std::floor(point.x / kSearchGrid_m)) - left_;
  const auto y =
      static_cast<int64_t>(std::floor(point.y / kSearchGrid_m)) - bottom_;
  return x >= 0 && y >= 0 && x < width_ && y < height_ &&
         is_free_[static_cast<size_t>(y * width_ + x)];
}

}  // namespace treeline::localization
