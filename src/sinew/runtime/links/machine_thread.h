#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "sinew/runtime/links/machine_server.h"

namespace sinew::runtime {

/// A simulated machine in a thread of its own, behind a real pseudo-terminal.
class MachineThread {
 public:
  static io::IoResult<std::unique_ptr<MachineThread>> start(
      std::unique_ptr<sim::ByteMachine> machine, const io::Clock& clock,
      const SimulatedCable& cable);
  ~MachineThread() { end(); }
  MachineThread(const MachineThread&) = delete;
  MachineThread& operator=(const MachineThread&) = delete;

  /// What a host opens.
  const std::string& path() const { return path_; }
  /// As of some 50 ms ago at most.
  sim::Truth truth() const;
  /// The machine runs no further; this is where it stands.
  sim::Truth end();

 private:
  MachineThread(std::unique_ptr<sim::ByteMachine> machine, io::Port port, const io::Clock& clock,
                const SimulatedCable& cable);

  std::unique_ptr<sim::ByteMachine> machine_;
  io::Port port_;
  std::string path_;
  ByteLog log_;
  std::atomic<bool> stop_ = false;
  mutable std::mutex mutex_;
  sim::Truth truth_;  ///< under the mutex
  std::thread thread_;
};

}  // namespace sinew::runtime
