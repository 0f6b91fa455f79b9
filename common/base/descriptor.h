// A file descriptor that closes itself.
#ifndef COMMON_BASE_DESCRIPTOR_H_
#define COMMON_BASE_DESCRIPTOR_H_

#include <unistd.h>

namespace treeline::base {

// Owns what open() returned; negative: nothing.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  const int fd_;
};

}  // namespace treeline::base

#endif  // COMMON_BASE_DESCRIPTOR_H_
