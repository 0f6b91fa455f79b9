// A world after people have lived in it: furniture that was moved about, or is
// gone.
#ifndef SIMULATION_WORLDS_REARRANGE_H_
#define SIMULATION_WORLDS_REARRANGE_H_

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"
#include "simulation/worlds/world.h"

namespace treeline::worlds {

// Each of the world's pieces is changed with probability `share`: three in ten
// of those are gone, the others stand up to 1 m away, turned by up to 60
// degrees, on the same level ground, and touch nothing; where there is no room,
// they are gone, too. Tour, named places and the ways of people stay free, and
// what stands as high as a hand-held camera stays off the walk area. What is
// fixed stays as it is, to the last bit. A function of world and seed. Pieces
// that are gone have no surfaces.
void Rearrange(const Rearrangement& rearranged, World& world);

// "SEED:SHARE", as command lines and files have it: "3:0.4". INVALID_ARGUMENT
// for others.
absl::StatusOr<Rearrangement> ParseRearrangement(absl::string_view text);

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_REARRANGE_H_
