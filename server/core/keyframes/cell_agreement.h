// Where in the picture the scene looks otherwise.
#ifndef SERVER_CORE_KEYFRAMES_CELL_AGREEMENT_H_
#define SERVER_CORE_KEYFRAMES_CELL_AGREEMENT_H_

#include <array>
#include <cstddef>

#include "server/core/keyframes/brightness_moments.h"
#include "server/core/keyframes/parameters.h"

namespace treeline::keyframes {

// Points that should be seen, gathered by the cells of the picture that they
// are seen in. At a place that only looks like the scene's the points disagree
// together, in a few cells; noise, blur and poses that are a little off spread
// over all of them.
class CellAgreement {
 public:
  // Of a picture of this size (px).
  CellAgreement(int width, int height);

  // A point at pixel (u, v), which the picture contains: what brightness it
  // should have there, and has (grey levels).
  void Add(float u, float v, float expected, float brightness, bool agrees);

  // Of the cells with enough points to tell, the share that look like something
  // else: most of their points do not agree, nor does their brightness go with
  // the expected one, as it would in another light. 0 without cells.
  double Contradicted() const;

 private:
  struct Cell {
    BrightnessMoments moments;
    int agreeing = 0;

    bool Tells() const;
    bool Contradicts() const;
  };

  float columns_per_px_;
  float rows_per_px_;
  std::array<Cell, static_cast<size_t>(kCellColumns) * kCellRows> cells_{};
};

}  // namespace treeline::keyframes

#endif  // SERVER_CORE_KEYFRAMES_CELL_AGREEMENT_H_
