#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>

#include "sinew/driver/driver.h"

namespace sinew {

/// A driver's accepted commands and its events: each command ends with exactly one event, and a
/// stop ends what was under way, or itself where that was nothing. @rt
class DriverCommands {
 public:
  using Kind = DriverEvent::Kind;

  void accept() { ++open_; }
  /// Accepted, and without their last event.
  std::size_t open() const { return open_; }
  bool stop_asked() const { return stop_asked_; }
  void ask_stop() { stop_asked_ = true; }

  /// The oldest one.
  void done() {
    --open_;
    tell(Kind::kDone);
  }
  void end_all(Kind kind, const Error& error = {}) {
    for (; open_ > 0; --open_) tell(kind, error);
  }
  /// Told also where no command was under way.
  void fail(const Error& error) {
    open_ = std::max<std::size_t>(open_, 1);
    end_all(Kind::kFailed, error);
  }
  /// The stop that was asked for, if any, has taken effect.
  void end_stop() {
    if (!stop_asked_) return;
    stop_asked_ = false;
    open_ = std::max<std::size_t>(open_, 1);
    end_all(Kind::kStopped);
  }
  /// Of a stop at rest: once, where the last one was not heard yet.
  void tell_stopped() {
    if (events_.empty() || events_.back().kind != Kind::kStopped) tell(Kind::kStopped);
  }
  void tell(Kind kind, const Error& error = {}) {
    if (!events_.full()) events_.push_back({kind, error});
  }
  std::optional<DriverEvent> take() { return events_.take_front(); }

 private:
  std::size_t open_ = 0;
  bool stop_asked_ = false;
  FixedVector<DriverEvent, 32> events_;
};

}  // namespace sinew
