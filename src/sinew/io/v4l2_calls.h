#pragma once

#include <cstddef>
#include <functional>

#include "sinew/core/instant.h"

struct pollfd;

namespace sinew::io {

/// What a V4L2 camera needs of the kernel; tests put a camera without hardware behind it. Each
/// returns what the system call of its name does, with errno set where that failed.
struct V4l2Calls {
  std::function<int(const char* path, int flags)> open;
  std::function<int(int descriptor)> close;
  std::function<int(int descriptor, unsigned long request, void* argument)> ioctl;
  std::function<void*(std::size_t length, int descriptor, std::size_t offset)> mmap;
  std::function<int(void* address, std::size_t length)> munmap;
  /// Of one descriptor; of none where `waiting` is null, as a pause.
  std::function<int(pollfd* waiting, int timeout_ms)> poll;
  /// CLOCK_MONOTONIC, by which drivers stamp their frames.
  std::function<Duration()> now;
};

/// Those of the system.
const V4l2Calls& system_v4l2_calls();

}  // namespace sinew::io
