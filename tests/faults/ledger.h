#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "sinew/driver/driver.h"

namespace sinew::test {

/// Holds a driver to the contract of its events: each accepted command ends exactly once, with
/// kDone, kFailed or kStopped. Beside that an open() may fail, and a stop() with nothing under way
/// is answered.
class Ledger {
 public:
  void accepted() { ++under_way_; }
  void stop_asked() { ++stops_; }
  /// clear_fault() was accepted: some drivers say kDone when it is over, some kReady.
  void clearing() { ++clears_; }
  /// open(), or the device is being found again: may fail by itself.
  void may_fail() { may_fail_ = true; }

  /// @return  what the contract does not allow
  std::optional<std::string> take(const DriverEvent& event) {
    using Kind = DriverEvent::Kind;
    if (event.kind == Kind::kNotice || event.kind == Kind::kReady) return {};
    if (event.kind == Kind::kDone) ++done_;
    if (event.kind == Kind::kFailed) ++failed_;
    if (event.kind == Kind::kStopped) ++stopped_;
    if (under_way_ > 0) {
      --under_way_;
      if (event.kind == Kind::kStopped && under_way_ == 0) stops_ = 0;
      return {};
    }
    if (event.kind == Kind::kStopped && stops_ > 0) {
      --stops_;
      return {};
    }
    if (clears_ > 0) {
      --clears_;
      return {};
    }
    if (event.kind == Kind::kFailed && (may_fail_ || stops_ > 0)) return {};
    return "an event ends a command that nobody gave: kind " +
           std::to_string(static_cast<int>(event.kind)) + ", " +
           std::string(info(event.error.code).name);
  }

  std::uint64_t under_way() const { return under_way_; }
  std::uint64_t done() const { return done_; }
  std::uint64_t failed() const { return failed_; }
  std::uint64_t stopped() const { return stopped_; }

 private:
  std::uint64_t under_way_ = 0;
  std::uint64_t stops_ = 0;
  std::uint64_t clears_ = 0;
  bool may_fail_ = false;
  std::uint64_t done_ = 0;
  std::uint64_t failed_ = 0;
  std::uint64_t stopped_ = 0;
};

}  // namespace sinew::test
