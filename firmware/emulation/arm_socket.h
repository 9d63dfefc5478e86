#pragma once

#include <array>
#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "firmware/emulation/emulated_arm.h"

namespace sinew::emulation {

/// An emulated arm behind a simwire socket, for programs of their own. Its time is the host's,
/// which stamps every request, so a host waits as long as the emulator needs.
class ArmSocket {
 public:
  /// Of each axis, by its pulses.
  using Steps = std::array<std::int64_t, 6>;

  /// @param arm  is left alone until end()
  ArmSocket(EmulatedArm& arm, const RobotModel& model, const std::string& path);
  ~ArmSocket() { end(); }
  ArmSocket(const ArmSocket&) = delete;
  ArmSocket& operator=(const ArmSocket&) = delete;

  /// As a host names it.
  std::string port() const { return "simwire:unix:" + path_; }
  /// Of the first axis, now.
  std::int64_t first_axis() const { return first_axis_; }
  /// Milliseconds that have passed.
  std::size_t ticks() const { return ticks_; }
  /// Ends the serving.
  void end();
  /// Of each millisecond; after end().
  const std::vector<Steps>& steps() const { return steps_; }

 private:
  void serve(EmulatedArm& arm, const RobotModel& model);

  std::string path_;
  std::vector<Steps> steps_;
  std::atomic<std::int64_t> first_axis_ = 0;
  std::atomic<std::size_t> ticks_ = 0;
  std::atomic<bool> listens_ = false;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace sinew::emulation
