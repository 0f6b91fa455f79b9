#include "nav_agent/localization/amcl.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "absl/strings/str_cat.h"
#include "common/base/check_range.h"
#include "common/base/status_macros.h"
#include "nav_agent/localization/covariance_root.h"
#include "nav_agent/localization/parameters.h"
#include "nav_agent/localization/particle_clusters.h"
#include "nav_agent/localization/upright_points.h"

namespace treeline::localization {
namespace {

bool IsFinite(const geometry::Rigid2& pose) {
  return std::isfinite(pose.translation.x) &&
         std::isfinite(pose.translation.y) && std::isfinite(pose.yaw_rad);
}

}  // namespace

absl::Status AmclOptions::Validate() const {
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: min_particles", min_particles, 1, 1e6));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: max_particles", max_particles,
                                      min_particles, 1e6));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: max_global_particles",
                                      max_global_localization_particles,
                                      max_particles, 1e6));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: kld_error", kld_error, 1e-4, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: kld_z", kld_z, 0, 10));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: bin_m", bin_m, 0.01, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: bin_rad", bin_rad, 0.01, 2 * std::numbers::pi));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: update_distance_m", update_distance_m, 0, 100));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: update_turn_rad", update_turn_rad, 0, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: max_beams", max_beams, 1, 100000));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: independent_beams",
                                      independent_beams, 0.1, 100000));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: min_counting_share", min_counting_share, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: searching_share", searching_share, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: roughen_m", regularization_m, 0, 10));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: roughen_rad", regularization_rad, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: found_share", found_share, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: inject_ratio", inject_ratio, 1, 1e6));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: anew_share", injected_share, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: skip_below_share", beam_skip_threshold, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: skip_distance_m", beam_skip_distance_m, 0, 100));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: slow_share", alpha_slow, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: fast_share", alpha_fast, alpha_slow, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: off_ground_share", off_ground_share, 0, 1));
  TL_RETURN_IF_ERROR(base::CheckRange("amcl: ground_m", ground_m, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: ground_share", ground_share, 0, 1));
  TL_RETURN_IF_ERROR(
      base::CheckRange("amcl: resample_below", resample_below, 0, 1));
  TL_RETURN_IF_ERROR(field.Validate());
  return odometry.Validate();
}

int KldSampleCount(int bins, double error, double z) {
  if (bins <= 1) return 1;
  const double k = bins - 1;
  const double a = 2 / (9 * k);
  const double root = 1 - a + std::sqrt(a) * z;
  return std::max(
      1, static_cast<int>(
             std::min(std::ceil(k / (2 * error) * root * root * root), 1e9)));
}

absl::StatusOr<Amcl> Amcl::Create(const core::OccupancyGrid& map,
                                  const AmclOptions& options, uint64_t seed) {
  TL_RETURN_IF_ERROR(options.Validate());
  TL_ASSIGN_OR_RETURN(LikelihoodField field,
                      LikelihoodField::Create(map, options.field));
  std::vector<FreePlace> free_places;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (map.At({x, y}) == core::Occupancy::kFree) {
        free_places.push_back({map.CenterInMap({x, y}), {}});
      }
    }
  }
  if (free_places.empty()) {
    return absl::InvalidArgumentError(absl::StrCat("amcl: none of the map's ",
                                                   map.width, " x ", map.height,
                                                   " cells is free"));
  }
  return Amcl(std::move(field), nullptr, std::move(free_places),
              map.resolution_m, options, seed);
}

absl::StatusOr<Amcl> Amcl::CreateOnLevels(
    std::shared_ptr<const LaserLevelMap> map, const AmclOptions& options,
    uint64_t seed) {
  TL_RETURN_IF_ERROR(options.Validate());
  if (map == nullptr) return absl::InvalidArgumentError("amcl: no map");
  std::vector<FreePlace> free_places = map->free_places();
  const double resolution_m = map->resolution_m();
  return Amcl(LikelihoodField::Empty(), std::move(map), std::move(free_places),
              resolution_m, options, seed);
}

Amcl::Amcl(LikelihoodField field, std::shared_ptr<const LaserLevelMap> levels,
           std::vector<FreePlace> free_places, double resolution_m,
           const AmclOptions& options, uint64_t seed)
    : field_(std::move(field)),
      levels_(std::move(levels)),
      free_places_(std::move(free_places)),
      resolution_m_(resolution_m),
      options_(options),
      seed_(seed),
      search_places_(std::make_shared<const std::vector<FreePlace>>(
          OnePlaceOfEachSquare(free_places_, kSearchGrid_m))),
      places_(options.places, options.odometry) {}

Particle Amcl::AnyParticle(base::Random& random) const {
  const FreePlace& free = free_places_[random.NextBelow(
      static_cast<uint32_t>(free_places_.size()))];
  const double half_m = resolution_m_ / 2;
  const double x = random.NextUniform(-half_m, half_m);
  const double y = random.NextUniform(-half_m, half_m);
  const double yaw_rad =
      random.NextUniform(-std::numbers::pi, std::numbers::pi);
  return {.map_from_base = {free.center + geometry::Vec2{x, y}, yaw_rad},
          .weight = 0,
          .place = free.place};
}

void Amcl::FindGround(Particle& particle) const {
  if (levels_ == nullptr) return;
  // In a wall it keeps its height, and comes out on the same level.
  const std::optional<core::LevelPlace> ground = levels_->GroundNear(
      particle.map_from_base.translation, particle.place.height_m);
  if (ground.has_value()) particle.place = *ground;
}

bool Amcl::IsOffGround(const Particle& particle) const {
  return levels_ != nullptr &&
         !levels_
              ->GroundNear(particle.map_from_base.translation,
                           particle.place.height_m)
              .has_value();
}

absl::Status Amcl::SetPose(const geometry::Rigid2& map_from_base,
                           const PoseCovariance2& covariance) {
  core::LevelPlace place;
  if (levels_ != nullptr && IsFinite(map_from_base)) {
    for (int level = levels_->levels() - 1; level >= 0; --level) {
      place =
          levels_->GroundOf(map_from_base.translation, level).value_or(place);
    }
  }
  return PlaceAbout(map_from_base, covariance, place);
}

absl::Status Amcl::SetPoseOnLevel(const geometry::Rigid2& map_from_base,
                                  double height_m,
                                  const PoseCovariance2& covariance) {
  if (levels_ == nullptr || !IsFinite(map_from_base)) {
    return absl::InvalidArgumentError(
        "amcl: a height needs levels and a finite pose");
  }
  const std::optional<core::LevelPlace> place =
      levels_->GroundNear(map_from_base.translation, height_m);
  if (!place.has_value()) {
    return absl::InvalidArgumentError(absl::StrCat(
        "amcl: no level has ground at ", map_from_base.translation.x, ", ",
        map_from_base.translation.y, ", height ", height_m));
  }
  return PlaceAbout(map_from_base, covariance, *place);
}

absl::Status Amcl::PlaceAbout(const geometry::Rigid2& map_from_base,
                              const PoseCovariance2& covariance,
                              const core::LevelPlace& place) {
  const std::optional<std::array<double, 9>> root = SquareRoot(covariance);
  if (!IsFinite(map_from_base) || !root.has_value()) {
    return absl::InvalidArgumentError(
        "amcl: an initial pose must be finite, and its covariance positive "
        "semidefinite");
  }
  Gather(map_from_base, *root, place);
  fits_ = 0;
  force_next_ = true;
  is_weighed_ = false;
  is_settled_ = true;
  places_.EndDoubt();
  sure_before_.reset();
  UpdateEstimate();
  return absl::OkStatus();
}

void Amcl::Gather(const geometry::Rigid2& map_from_base,
                  const std::array<double, 9>& root,
                  const core::LevelPlace& place) {
  max_particles_now_ = options_.max_particles;
  is_searching_ = false;
  particles_.assign(static_cast<size_t>(options_.max_particles), {});
  ++draws_;
  for (size_t i = 0; i < particles_.size(); ++i) {
    base::Random random(seed_ + draws_, i);
    const std::array<double, 3> away = DrawFrom(root, random);
    particles_[i] = {.map_from_base = {map_from_base.translation +
                                           geometry::Vec2{away[0], away[1]},
                                       geometry::NormalizedAngle_rad(
                                           map_from_base.yaw_rad + away[2])},
                     .weight = 1.0 / static_cast<double>(particles_.size()),
                     .place = place};
    FindGround(particles_[i]);
  }
}

void Amcl::StartGlobalLocalization() {
  max_particles_now_ = options_.max_global_localization_particles;
  is_searching_ = true;
  particles_.assign(static_cast<size_t>(max_particles_now_), {});
  ++draws_;
  for (size_t i = 0; i < particles_.size(); ++i) {
    base::Random random(seed_ + draws_, i);
    particles_[i] = AnyParticle(random);
    particles_[i].weight = 1.0 / static_cast<double>(particles_.size());
  }
  fits_ = 0;
  force_next_ = true;
  is_weighed_ = false;
  is_settled_ = true;
  if (options_.doubt) places_.BeginDoubt();
  sure_before_.reset();
  UpdateEstimate();
}

absl::StatusOr<std::optional<PlanarEstimate>> Amcl::Update(
    const geometry::Rigid2& odom_from_base, const ScanPoints& points) {
  TL_RETURN_IF_ERROR(Begin(odom_from_base, points));
  return Settle();
}

absl::Status Amcl::Begin(const geometry::Rigid2& odom_from_base,
                         const ScanPoints& points) {
  if (!IsFinite(odom_from_base)) {
    return absl::InvalidArgumentError("amcl: the odometry is not finite");
  }
  if (!is_settled_) Settle();
  if (particles_.empty()) return absl::OkStatus();
  if (odom_from_base_.has_value()) {
    const geometry::Rigid2 before_from_after =
        odom_from_base_->Inverse() * odom_from_base;
    if (before_from_after != geometry::Rigid2()) Move(before_from_after);
  }
  odom_from_base_ = odom_from_base;
  if (!odom_at_scan_.has_value()) odom_at_scan_ = odom_from_base;
  const geometry::Rigid2 since = odom_at_scan_->Inverse() * odom_from_base;
  const bool is_due =
      force_next_ ||
      geometry::Norm(since.translation) >= options_.update_distance_m ||
      std::abs(since.yaw_rad) >= options_.update_turn_rad;
  if (is_due && points.size() > 0) {
    Weigh(points);
    if (places_.in_doubt()) {
      places_.AddScan(
          odom_from_base,
          levels_ == nullptr ? points : UprightPoints(points, kGroundEnd_m));
    }
    is_weighed_ = true;
    odom_at_scan_ = odom_from_base;
    force_next_ = false;
  }
  is_settled_ = false;
  return absl::OkStatus();
}

std::optional<PlanarEstimate> Amcl::Settle() {
  is_settled_ = true;
  if (particles_.empty()) return std::nullopt;
  if (std::exchange(is_weighed_, false)) Resample();
  UpdateEstimate();
  if (MayDoubt()) Doubt();
  return estimate_;
}

std::optional<PlanarEstimate> Amcl::Ponder() {
  if (!is_settled_ || particles_.empty() || !MayDoubt()) return std::nullopt;
  Doubt();
  return estimate_;
}

// A search that it has begun by itself is likely to end where it was.
bool Amcl::MayDoubt() const {
  return places_.in_doubt() && odom_from_base_.has_value() &&
         (!is_searching_ || !sure_before_.has_value());
}

void Amcl::Move(const geometry::Rigid2& before_from_after) {
  const OdometryMotion motion(before_from_after, options_.odometry);
  ++draws_;
  for (size_t i = 0; i < particles_.size(); ++i) {
    base::Random random(seed_ + draws_, i);
    particles_[i].map_from_base =
        motion.Sample(particles_[i].map_from_base, random);
    FindGround(particles_[i]);
  }
}

ScanPoints Amcl::WithoutGround(const ScanPoints& points) const {
  // The whole cloud says nothing on what a beam may have met.
  if (levels_ == nullptr || is_searching_ || !points.has_heights()) {
    return points;
  }
  ScanPoints kept;
  for (size_t i = 0; i < points.size(); ++i) {
    const geometry::Vec2 end = {points.x_m[i], points.y_m[i]};
    const geometry::Vec2 end_in_map = estimate_.map_from_base * end;
    if (levels_->IsOnGround(
            {end_in_map.x, end_in_map.y,
             estimate_.place.height_m + static_cast<double>(points.z_m[i])},
            options_.ground_m + options_.ground_share * geometry::Norm(end))) {
      continue;
    }
    kept.Add(points, i);
  }
  return kept;
}

ScanPoints Amcl::WithoutUnexplained(const ScanPoints& points) {
  // Particles by weight, evenly.
  const size_t judging_particles =
      std::min(kWitnessParticles, particles_.size());
  const float explained_log = field().LogAt(options_.beam_skip_distance_m);
  std::vector<int> explained(points.size());
  std::vector<float> logs(points.size());
  double reached = 0;
  size_t particle = 0;
  double fit = 0;
  for (size_t k = 0; k < judging_particles; ++k) {
    const double at =
        (static_cast<double>(k) + 0.5) / static_cast<double>(judging_particles);
    while (particle + 1 < particles_.size() &&
           reached + particles_[particle].weight < at) {
      reached += particles_[particle++].weight;
    }
    field().LogLikelihoods(points, particles_[particle].map_from_base, logs,
                           particles_[particle].place.height_m);
    double sum = 0;
    for (size_t i = 0; i < points.size(); ++i) {
      explained[i] += logs[i] > explained_log ? 1 : 0;
      sum += logs[i];
    }
    fit += std::exp(sum / static_cast<double>(points.size()));
  }
  // Of all beams: those that are left out are what a lost robot sees.
  UpdateFit(fit / static_cast<double>(judging_particles));
  ScanPoints kept;
  const double needed =
      options_.beam_skip_threshold * static_cast<double>(judging_particles);
  for (size_t i = 0; i < points.size(); ++i) {
    if (explained[i] < needed) continue;
    kept.Add(points, i);
  }
  return 2 * kept.size() < points.size() ? points : kept;
}

double Amcl::GainFor(const std::vector<float>& sums, double beams) const {
  const double full = std::min(1.0, options_.independent_beams / beams);
  const double least =
      is_searching_ ? options_.searching_share : options_.min_counting_share;
  const auto counting_share = [&](double gain) {
    double total = 0;
    double squares = 0;
    for (size_t i = 0; i < sums.size(); ++i) {
      const double weight = particles_[i].weight * std::exp(gain * sums[i]);
      total += weight;
      squares += weight * weight;
    }
    return total * total / squares / static_cast<double>(sums.size());
  };
  if (counting_share(full) >= least) return full;
  double low = 0;
  double high = full;
  for (int i = 0; i < 10; ++i) {
    const double middle = (low + high) / 2;
    (counting_share(middle) >= least ? low : high) = middle;
  }
  return low;
}

void Amcl::Weigh(const ScanPoints& points) {
  const ScanPoints upright = WithoutGround(points);
  estimate_.beams_on_ground = static_cast<int>(points.size() - upright.size());
  // A scan of nothing but floor.
  if (upright.size() == 0) return;
  const ScanPoints used = WithoutUnexplained(upright);
  estimate_.beams_used = static_cast<int>(used.size());
  estimate_.beams_skipped = static_cast<int>(upright.size() - used.size());
  PoseArrays poses;
  poses.Resize(particles_.size());
  for (size_t i = 0; i < particles_.size(); ++i) {
    poses.Set(i, particles_[i].map_from_base, particles_[i].place.height_m);
  }
  std::vector<float> sums(particles_.size());
  field().SumLogLikelihoods(used, poses, sums);

  // What a beam that hits nothing costs.
  const double miss = std::log(1 - options_.field.hit_share);
  const double off_ground =
      options_.off_ground_share * miss * static_cast<double>(used.size());
  for (size_t i = 0; i < particles_.size(); ++i) {
    if (IsOffGround(particles_[i])) sums[i] += static_cast<float>(off_ground);
  }

  const double best = *std::max_element(sums.begin(), sums.end());
  for (float& sum : sums) sum -= static_cast<float>(best);
  const double gain = GainFor(sums, static_cast<double>(used.size()));
  double total = 0;
  for (size_t i = 0; i < particles_.size(); ++i) {
    particles_[i].weight *= std::exp(gain * sums[i]);
    total += particles_[i].weight;
  }
  for (Particle& particle : particles_) particle.weight /= total;
}

void Amcl::UpdateFit(double fit) {
  estimate_.fit = fit;
  // Plain means to begin with: the first scans of a wide cloud would hold a
  // share of a thousandth back for thousands of scans.
  ++fits_;
  const double new_share = 1.0 / static_cast<double>(fits_);
  w_slow_ += std::max(options_.alpha_slow, new_share) * (fit - w_slow_);
  w_fast_ += std::max(options_.alpha_fast, new_share) * (fit - w_fast_);
}

void Amcl::Resample() {
  double squares = 0;
  for (const Particle& p : particles_) squares += p.weight * p.weight;
  const double counting = 1 / squares;
  const bool inject = options_.inject && !is_searching_ &&
                      options_.inject_ratio * w_fast_ < w_slow_;
  const double size = static_cast<double>(particles_.size());
  if (counting >= options_.resample_below * size && !inject) return;

  ++draws_;
  base::Random random(seed_ + draws_, ~uint64_t{0});
  // Low variance: evenly spaced over the weights, from one random start.
  const auto drawn = [&](size_t count, double start) {
    std::vector<Particle> result;
    result.reserve(count);
    double reached = particles_[0].weight;
    size_t particle = 0;
    for (size_t k = 0; k < count; ++k) {
      const double at =
          (static_cast<double>(k) + start) / static_cast<double>(count);
      while (reached < at && particle + 1 < particles_.size()) {
        reached += particles_[++particle].weight;
      }
      result.push_back(particles_[particle]);
    }
    return result;
  };
  const double start = random.NextUnit();
  std::vector<Particle> next = drawn(particles_.size(), start);
  const int wanted = std::clamp(
      KldSampleCount(CountBins(next, options_.bin_m, options_.bin_rad),
                     options_.kld_error, options_.kld_z),
      options_.min_particles, max_particles_now_);
  next = drawn(static_cast<size_t>(wanted), start);
  for (Particle& p : next) p.weight = 1.0 / wanted;
  if (is_searching_) Roughen(next);
  particles_ = std::move(next);
  if (inject) {
    SearchEverywhere();
  } else if (wanted <= options_.max_particles) {
    max_particles_now_ = options_.max_particles;
    is_searching_ =
        is_searching_ &&
        HeaviestCluster(particles_, options_.bin_m, options_.bin_rad).share <
            options_.found_share;
  }
}

bool Amcl::IsWhereItWasSure() const {
  if (!sure_before_.has_value()) return false;
  const geometry::Rigid2 expected =
      sure_before_->pose.map_from_base *
      (sure_before_->odom_from_base.Inverse() * *odom_from_base_);
  return AreNear(
      {.map_from_base = expected, .place = estimate_.place},
      {.map_from_base = estimate_.map_from_base, .place = estimate_.place},
      kOtherPlace_m, kOtherPlace_rad);
}

void Amcl::Doubt() {
  if (IsWhereItWasSure()) {
    places_.EndDoubt();
  } else {
    std::optional<core::LevelPose> believed;
    if (!is_searching_) {
      believed = {.map_from_base = estimate_.map_from_base,
                  .place = estimate_.place};
    }
    places_.Step(
        {.field = &field(), .places = search_places_, .levels = levels_.get()},
        *odom_from_base_, believed);
    const std::optional<core::LevelPose> better =
        is_searching_ ? places_.Best(*odom_from_base_)
                      : places_.Better(*odom_from_base_);
    if (better.has_value()) {
      constexpr double kM = kRegularization_m;
      Gather(better->map_from_base,
             {kM, 0, 0, 0, kM, 0, 0, 0, kRegularization_rad}, better->place);
      UpdateEstimate();
    }
  }
  NoteDoubt(estimate_);
}

void Amcl::NoteDoubt(PlanarEstimate& estimate) const {
  estimate.in_doubt = places_.in_doubt();
  estimate.place_share =
      estimate.in_doubt && is_searching_ ? 0 : places_.share();
  if (odom_from_base_.has_value()) {
    estimate.other_places = places_.Others(*odom_from_base_, kOtherPlacesShown);
  }
}

void Amcl::SearchEverywhere() {
  if (!places_.in_doubt() && odom_from_base_.has_value()) {
    sure_before_ = {.pose = {.map_from_base = estimate_.map_from_base,
                             .place = estimate_.place},
                    .odom_from_base = *odom_from_base_};
  }
  if (options_.doubt) places_.BeginDoubt();
  const size_t known = particles_.size();
  const size_t anew =
      static_cast<size_t>(options_.max_global_localization_particles);
  for (Particle& p : particles_) p.weight *= 1 - options_.injected_share;
  particles_.resize(known + anew);
  ++draws_;
  for (size_t i = 0; i < anew; ++i) {
    base::Random random(seed_ + draws_, i);
    particles_[known + i] = AnyParticle(random);
    particles_[known + i].weight =
        options_.injected_share / static_cast<double>(anew);
  }
  max_particles_now_ = options_.max_global_localization_particles;
  is_searching_ = true;
  // As if all were well: the search gets its time before the next.
  w_fast_ = w_slow_;
}

void Amcl::Roughen(std::vector<Particle>& particles) {
  ++draws_;
  for (size_t i = 0; i < particles.size(); ++i) {
    base::Random random(seed_ + draws_, i);
    geometry::Rigid2& pose = particles[i].map_from_base;
    const double x = random.NextGaussian();
    const double y = random.NextGaussian();
    pose.translation =
        pose.translation + options_.regularization_m * geometry::Vec2{x, y};
    pose.yaw_rad = geometry::NormalizedAngle_rad(
        pose.yaw_rad + options_.regularization_rad * random.NextGaussian());
  }
}

void Amcl::UpdateEstimate() {
  PlanarEstimate estimate =
      HeaviestCluster(particles_, options_.bin_m, options_.bin_rad);
  estimate.fit = estimate_.fit;
  estimate.beams_on_ground = estimate_.beams_on_ground;
  estimate.is_searching = is_searching_;
  NoteDoubt(estimate);
  estimate.beams_used = estimate_.beams_used;
  estimate.beams_skipped = estimate_.beams_skipped;
  if (levels_ != nullptr) {
    estimate.place = levels_
                         ->GroundNear(estimate.map_from_base.translation,
                                      estimate.place.height_m)
                         .value_or(estimate.place);
  }
  estimate_ = estimate;
}

}  // namespace treeline::localization
