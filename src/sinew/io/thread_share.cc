#include "sinew/io/thread_share.h"

#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <ctime>

namespace sinew::io {

void let_others_go_first(Share share) {
  // On Linux this is the thread's own; each step takes a fifth of the share.
  const int nicer = share == Share::kServing ? 5 : 15;
  static_cast<void>(::setpriority(PRIO_PROCESS, 0, nicer));
}

void give_memory_back() {
#ifdef __GLIBC__
  static_cast<void>(::malloc_trim(0));
#endif
}

IoResult<RealtimeStart> RealtimeStart::begin() {
  // Before ordinary programs, behind the kernel's own threads, which run at 50.
  const sched_param before_others{.sched_priority = 20};
  if (const int refused = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &before_others);
      refused != 0) {
    IoError error = system_error("real time", refused);
    error.sentence += "; root may, and whoever has rtprio and memlock in /etc/security/limits.d";
    return std::unexpected(error);
  }
  RealtimeStart start;
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    IoError error = system_error("real time: memory that stays", errno);
    error.sentence += "; root may, and whoever has memlock in /etc/security/limits.d";
    return std::unexpected(error);
  }
  return start;
}

RealtimeStart::~RealtimeStart() {
  if (!active_) return;
  const sched_param as_all{};
  static_cast<void>(::pthread_setschedparam(::pthread_self(), SCHED_OTHER, &as_all));
}

std::chrono::nanoseconds processor_time() {
  timespec used{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &used);
  return std::chrono::seconds(used.tv_sec) + std::chrono::nanoseconds(used.tv_nsec);
}

}  // namespace sinew::io
