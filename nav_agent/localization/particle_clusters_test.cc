#include "nav_agent/localization/particle_clusters.h"

#include <cmath>
#include <numbers>

#include "gtest/gtest.h"

namespace treeline::localization {
namespace {

TEST(BinParticles, NeighboursAreOneClusterAcrossTheTurnOfTheYaw) {
  const double pi = std::numbers::pi;
  const std::vector<Particle> particles = {
      {{{0.1, 0.1}, pi - 0.05}, 1}, {{{-0.1, 0.1}, -pi + 0.05}, 1},
      {{{0.6, 0.6}, pi - 0.05}, 1}, {{{3.1, 0.1}, pi - 0.05}, 1},
      {{{0.1, 0.1}, 0}, 1},         {{{0.2, 0.2}, pi - 0.02}, 1}};
  const PoseBins bins = BinParticles(particles, 0.5, pi / 18);
  EXPECT_EQ(bins.count, 5);
  EXPECT_EQ(CountBins(particles, 0.5, pi / 18), 5);
  EXPECT_EQ(bins.clusters, 3);
  EXPECT_EQ(bins.bin_of_particle[0], bins.bin_of_particle[5]);
  const auto cluster = [&bins](size_t i) {
    return bins.cluster_of_bin[static_cast<size_t>(bins.bin_of_particle[i])];
  };
  EXPECT_EQ(cluster(0), cluster(1));
  EXPECT_EQ(cluster(0), cluster(2));
  EXPECT_NE(cluster(0), cluster(3));
  EXPECT_NE(cluster(0), cluster(4));
}

TEST(HeaviestCluster, HasItsMeanAndCovarianceAlone) {
  const std::vector<Particle> particles = {{{{1.0, 2.0}, 3.1}, 0.3},
                                           {{{1.2, 2.0}, -3.1}, 0.3},
                                           {{{9.0, 9.0}, 0.0}, 0.2},
                                           {{{9.0, 5.0}, 0.0}, 0.2}};
  const PlanarEstimate estimate = HeaviestCluster(particles, 0.5, 0.2);
  EXPECT_NEAR(estimate.share, 0.6, 1e-12);
  EXPECT_NEAR(estimate.map_from_base.translation.x, 1.1, 1e-12);
  EXPECT_NEAR(estimate.map_from_base.translation.y, 2.0, 1e-12);
  EXPECT_NEAR(std::abs(estimate.map_from_base.yaw_rad), std::numbers::pi, 1e-9);
  EXPECT_NEAR(estimate.covariance[0], 0.01, 1e-12);
  EXPECT_NEAR(estimate.covariance[4], 0, 1e-12);
  const double half_rad = std::numbers::pi - 3.1;
  EXPECT_NEAR(estimate.covariance[8], half_rad * half_rad, 1e-9);
  EXPECT_NEAR(estimate.covariance[2], 0.1 * half_rad, 1e-9);
  EXPECT_EQ(estimate.particles, 4);
}

}  // namespace
}  // namespace treeline::localization
