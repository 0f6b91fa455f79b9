#include "evaluation/yardsticks/opencv_threads.h"

#include "opencv2/core.hpp"

namespace treeline::yardsticks {

void RunOpenCvOnCallingThread() {
  static const bool is_set = [] {
    cv::setNumThreads(1);
    return true;
  }();
  static_cast<void>(is_set);
}

}  // namespace treeline::yardsticks
