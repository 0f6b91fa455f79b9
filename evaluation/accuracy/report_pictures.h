// Pictures of single frames for a report: what the localizer saw, and which of
// its predictions agreed.
#ifndef EVALUATION_ACCURACY_REPORT_PICTURES_H_
#define EVALUATION_ACCURACY_REPORT_PICTURES_H_

#include <string>
#include <vector>

#include "common/dataset/dataset.h"
#include "evaluation/accuracy/evaluation.h"
#include "server/core/localizer/localizer.h"

namespace treeline::accuracy {

enum class PictureKind { kWorst, kMedian, kBest };

struct PictureChoice {
  int frame = 0;  // index into the results
  PictureKind kind = PictureKind::kWorst;
};

// Up to `worst` frames with the largest errors (those not localized first),
// then frames around the median error and the best ones, never one twice, and
// frames next to each other, which show the same, only where there are no
// others. Frames that could not be read are not chosen.
std::vector<PictureChoice> ChoosePictures(
    const std::vector<FrameResult>& results, int worst = 6, int median = 3,
    int best = 3);

struct ReportPicture {
  PictureChoice choice;
  std::string jpeg;
  // Size of the frame, in whose pixels the correspondences are; the JPEG may
  // be smaller.
  int width = 0;
  int height = 0;
  std::vector<localizer::Correspondence> correspondences;
};

// Reads the chosen frames and localizes them again, with the options of the
// evaluation, to learn their correspondences. A frame that fails is left out.
std::vector<ReportPicture> TakePictures(
    const localizer::Localizer& localizer, const dataset::Dataset& dataset,
    const std::vector<PictureChoice>& choices,
    const EvaluationOptions& options);

}  // namespace treeline::accuracy

#endif  // EVALUATION_ACCURACY_REPORT_PICTURES_H_
