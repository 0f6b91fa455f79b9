// The curves of the lost suite.
#ifndef EVALUATION_LOST_LOST_SUITE_PICTURE_H_
#define EVALUATION_LOST_LOST_SUITE_PICTURE_H_

#include "common/image/image.h"
#include "evaluation/lost/lost_suite_report.h"

namespace treeline::lost {

// Detection (0 to 1) against false alarms an hour (0.05 to 500, logarithmic),
// and the shares of kidnaps declared after so many seconds.
image::ColorImage DrawLostReport(const LostReport& report);

}  // namespace treeline::lost

#endif  // EVALUATION_LOST_LOST_SUITE_PICTURE_H_
