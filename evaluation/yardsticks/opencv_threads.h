// How many threads OpenCV uses within a call of ours.
#ifndef EVALUATION_YARDSTICKS_OPENCV_THREADS_H_
#define EVALUATION_YARDSTICKS_OPENCV_THREADS_H_

namespace treeline::yardsticks {

// From the first call on OpenCV runs on the calling thread alone: queries and
// training have threads of their own. Thread-safe, where cv::setNumThreads is
// not: two calls of that at once take OpenCV's pool down twice, and crash.
void RunOpenCvOnCallingThread();

}  // namespace treeline::yardsticks

#endif  // EVALUATION_YARDSTICKS_OPENCV_THREADS_H_
