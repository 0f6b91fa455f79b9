// Random patterns in the plane, as functions of position and seed.
#ifndef SIMULATION_WORLDS_NOISE_H_
#define SIMULATION_WORLDS_NOISE_H_

#include <cstdint>
#include <vector>

namespace treeline::worlds {

// A random number in [0, 1) that belongs to the grid cell (x, y).
float CellNoise(int x, int y, uint64_t seed);

// Smooth noise in [0, 1): random values at integer positions, interpolated.
// It repeats after `period` units in both directions; 0: never.
float ValueNoise(float x, float y, uint64_t seed, int period = 0);

// Octaves of ValueNoise, each of twice the frequency and half the amplitude of
// the one before, scaled to [0, 1). It remembers the cells that it was last
// asked for, so that asking along rows costs a third of asking at random; the
// answers are the same.
class FractalNoise {
 public:
  // `period` of the first octave; 0: none.
  FractalNoise(uint64_t seed, int octaves, int period = 0);

  float At(float x, float y);

 private:
  struct Octave {
    uint64_t seed = 0;
    int period = 0;
    float amplitude = 0;
    // Of the last question: its row, its cell, and the noise at the cell's
    // left and right edges in that row.
    float y = 0;
    int cell_x = 0;
    bool is_known = false;
    float left = 0;
    float right = 0;
  };
  std::vector<Octave> octaves_;
};

}  // namespace treeline::worlds

#endif  // SIMULATION_WORLDS_NOISE_H_
