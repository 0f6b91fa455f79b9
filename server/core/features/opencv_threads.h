// How many threads OpenCV uses within a call of ours.
#ifndef SERVER_CORE_FEATURES_OPENCV_THREADS_H_
#define SERVER_CORE_FEATURES_OPENCV_THREADS_H_

namespace treeline::features {

// From the first call on OpenCV runs on the calling thread alone: queries and
// training have threads of their own. Thread-safe, where cv::setNumThreads is
// not: two calls of that at once take OpenCV's pool down twice, and crash.
void RunOpenCvOnCallingThread();

}  // namespace treeline::features

#endif  // SERVER_CORE_FEATURES_OPENCV_THREADS_H_
