#pragma once

#include <atomic>
#include <mutex>
#include <string>
#include <thread>

#include "firmware/emulation_avr/mega_board.h"

namespace sinew::emulation {

/// An emulated board behind a pseudo-terminal, for programs of their own. Its time is this
/// computer's, as far as the emulator keeps up.
class MegaPort {
 public:
  MegaPort();
  ~MegaPort();
  MegaPort(const MegaPort&) = delete;
  MegaPort& operator=(const MegaPort&) = delete;

  const std::string& name() const { return name_; }
  /// By the pulses.
  std::int64_t steps(std::size_t axis) const;

 private:
  void serve();

  MegaBoard board_;
  mutable std::mutex mutex_;
  int own_ = -1;    ///< this side
  int other_ = -1;  ///< held open, so that programs may come and go
  std::string name_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace sinew::emulation
