// What befalls a process from its computer, for tests: a library that is loaded before the C
// library's own functions. SINEW_MISFORTUNE says what, and how many ms after its first clock call:
//   full@800          every write to a plain file fails, since the disk is full
//   jump@800:3600000  clocks are so many ms ahead from then on

#include <dlfcn.h>
#include <pthread.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>

namespace {

constexpr std::int64_t kNsPerMs = 1'000'000;
constexpr std::int64_t kNsPerS = 1'000'000'000;

std::int64_t monotonic_ns() {
  timespec now{};
  ::syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNsPerS + now.tv_nsec;
}

struct Plan {
  bool full = false;
  std::int64_t at_ns = INT64_MAX;  // since begin
  std::int64_t jump_ns = 0;
  std::int64_t begin_ns = monotonic_ns();

  Plan() {
    const char* text = std::getenv("SINEW_MISFORTUNE");
    long long at = 0;
    long long by = 0;
    if (text == nullptr) return;
    if (std::sscanf(text, "full@%lld", &at) == 1)
      full = true;
    else if (std::sscanf(text, "jump@%lld:%lld", &at, &by) != 2)
      return;
    at_ns = at * kNsPerMs;
    jump_ns = by * kNsPerMs;
  }
  bool has_come() const { return monotonic_ns() - begin_ns >= at_ns; }
};

const Plan& plan() {
  static const Plan plan;
  return plan;
}

bool refuses(int file) {
  if (!plan().full || !plan().has_come()) return false;
  struct stat status{};
  return ::fstat(file, &status) == 0 && S_ISREG(status.st_mode);
}

}  // namespace

extern "C" {

int clock_gettime(clockid_t clock, timespec* out) noexcept {
  const auto result = static_cast<int>(::syscall(SYS_clock_gettime, clock, out));
  const bool of_time =
      clock == CLOCK_MONOTONIC || clock == CLOCK_BOOTTIME || clock == CLOCK_REALTIME;
  if (result != 0 || !of_time || plan().jump_ns == 0 || !plan().has_come()) return result;
  const std::int64_t ns = out->tv_nsec + plan().jump_ns;
  out->tv_sec += ns / kNsPerS;
  out->tv_nsec = ns % kNsPerS;
  return result;
}

/// The kernel's clock has not jumped: waiting until a time that follows from clock_gettime() is
/// shorter by that.
int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const timespec* until) {
  using Wait = int (*)(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*);
  static const auto wait = reinterpret_cast<Wait>(::dlsym(RTLD_NEXT, "pthread_cond_clockwait"));
  timespec earlier = *until;
  if (plan().jump_ns != 0 && plan().has_come()) earlier.tv_sec -= plan().jump_ns / kNsPerS;
  return wait(condition, mutex, clock, &earlier);
}

ssize_t write(int file, const void* bytes, size_t size) {
  if (refuses(file)) {
    errno = ENOSPC;
    return -1;
  }
  return ::syscall(SYS_write, file, bytes, size);
}

ssize_t pwrite(int file, const void* bytes, size_t size, off_t offset) {
  if (refuses(file)) {
    errno = ENOSPC;
    return -1;
  }
  return ::syscall(SYS_pwrite64, file, bytes, size, offset);
}

}  // extern "C"
