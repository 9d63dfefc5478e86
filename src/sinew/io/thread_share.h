#pragma once

#include <chrono>
#include <cstdint>

#include "sinew/io/io_error.h"

namespace sinew::io {

/// How much less of the processor a thread gets where there is not enough for all.
enum class Share : std::uint8_t {
  kServing,   ///< answers clients: a third of what a control thread gets
  kThinking,  ///< what clients wait for anyway: a tenth of that
};
/// Of this thread, and those that it starts from now on.
void let_others_go_first(Share share);
/// What this thread has used of a processor so far; waiting is none of it.
std::chrono::nanoseconds processor_time();

/// Memory that this process has freed goes back to the system, where its library keeps it.
void give_memory_back();

/// While it lives, this thread, and for good those that it starts meanwhile, come before everything
/// else on this computer (SCHED_FIFO), and no memory of the process is paged out.
class RealtimeStart {
 public:
  /// @error  the system does not allow it; a sentence with the remedy
  static IoResult<RealtimeStart> begin();
  RealtimeStart(RealtimeStart&& other) noexcept : active_(other.active_) { other.active_ = false; }
  RealtimeStart& operator=(RealtimeStart&&) = delete;
  ~RealtimeStart();

 private:
  RealtimeStart() = default;
  bool active_ = true;
};

}  // namespace sinew::io
