// The modes of a few points in space (thesis 5.4.4).
#ifndef SERVER_CORE_TRAINING_MEAN_SHIFT_H_
#define SERVER_CORE_TRAINING_MEAN_SHIFT_H_

#include <cstddef>
#include <span>
#include <vector>

#include "server/core/training/split_objective.h"

namespace treeline::training {

// Mean shift with a flat kernel (Comaniciu, Meer, "Mean Shift", 2002): from
// each point, step to the mean of all points within bandwidth_m until nothing
// changes. Where that ends closer together than half the bandwidth is one
// mode. Returns the points (indices into `points`) of each mode, the largest
// mode first and at most max_modes of them; a mode's points keep their order.
// Work grows with the square of the number of points up to some hundreds, then
// linearly: only some points are started from.
std::vector<std::vector<size_t>> MeanShiftModes(std::span<const Label> points,
                                                double bandwidth_m,
                                                size_t max_modes);

}  // namespace treeline::training

#endif  // SERVER_CORE_TRAINING_MEAN_SHIFT_H_
