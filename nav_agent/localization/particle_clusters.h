// Which particles belong together.
#ifndef NAV_AGENT_LOCALIZATION_PARTICLE_CLUSTERS_H_
#define NAV_AGENT_LOCALIZATION_PARTICLE_CLUSTERS_H_

#include <vector>

#include "nav_agent/localization/amcl.h"

namespace treeline::localization {

// A histogram of poses over x, y, yaw and, in steps of 0.6 m, the ground's
// height: which bin each particle is in.
struct PoseBins {
  // One a particle: the number of its bin, in the order in which particles
  // occupy them.
  std::vector<int> bin_of_particle;
  int count = 0;
  // Connected components of occupied bins, neighbours in any of the
  // four directions and diagonally: one a bin.
  std::vector<int> cluster_of_bin;
  int clusters = 0;
};

PoseBins BinParticles(const std::vector<Particle>& particles, double bin_m,
                      double bin_rad);

// Only the number of bins that the particles occupy.
int CountBins(const std::vector<Particle>& particles, double bin_m,
              double bin_rad);

// Mean, covariance, share and mean height of the heaviest cluster. The yaw's
// mean is circular.
PlanarEstimate HeaviestCluster(const std::vector<Particle>& particles,
                               double bin_m, double bin_rad);

}  // namespace treeline::localization

#endif  // NAV_AGENT_LOCALIZATION_PARTICLE_CLUSTERS_H_
