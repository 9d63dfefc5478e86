#include "sinew/io/v4l2_calls.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

namespace sinew::io {

const V4l2Calls& system_v4l2_calls() {
  static const V4l2Calls kCalls{
      .open = [](const char* path, int flags) { return ::open(path, flags); },
      .close = [](int descriptor) { return ::close(descriptor); },
      .ioctl = [](int descriptor, unsigned long request,
                  void* argument) { return ::ioctl(descriptor, request, argument); },
      .mmap =
          [](std::size_t length, int descriptor, std::size_t offset) {
            return ::mmap(nullptr, length, PROT_READ, MAP_SHARED, descriptor,
                          static_cast<off_t>(offset));
          },
      .munmap = [](void* address, std::size_t length) { return ::munmap(address, length); },
      .poll =
          [](pollfd* waiting, int timeout_ms) {
            return ::poll(waiting, waiting != nullptr ? 1 : 0, timeout_ms);
          },
      .now =
          [] {
            timespec now{};
            ::clock_gettime(CLOCK_MONOTONIC, &now);
            return Duration(std::chrono::seconds(now.tv_sec) +
                            std::chrono::nanoseconds(now.tv_nsec));
          },
  };
  return kCalls;
}

}  // namespace sinew::io
