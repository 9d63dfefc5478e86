#include "sinew/runtime/links/machine_thread.h"

namespace sinew::runtime {

MachineThread::MachineThread(std::unique_ptr<sim::ByteMachine> machine, io::Port port,
                             const io::Clock& clock, const SimulatedCable& cable)
    : machine_(std::move(machine)),
      port_(std::move(port)),
      path_(port_.path()),
      truth_(machine_->truth()),
      thread_([this, clock, cable] {
        // A port that fails shows at the other end, where somebody waits.
        static_cast<void>(serve_machine(*machine_, port_, clock, cable, log_,
                                        {.stop = [this] { return stop_.load(); },
                                         .look =
                                             [this](Instant) {
                                               const std::scoped_lock lock(mutex_);
                                               truth_ = machine_->truth();
                                             }}));
      }) {}

sim::Truth MachineThread::truth() const {
  const std::scoped_lock lock(mutex_);
  return truth_;
}

io::IoResult<std::unique_ptr<MachineThread>> MachineThread::start(
    std::unique_ptr<sim::ByteMachine> machine, const io::Clock& clock,
    const SimulatedCable& cable) {
  auto port = io::Port::open_pseudo_terminal();
  if (!port) return std::unexpected(port.error());
  return std::unique_ptr<MachineThread>(
      new MachineThread(std::move(machine), std::move(*port), clock, cable));
}

sim::Truth MachineThread::end() {
  stop_ = true;
  if (thread_.joinable()) thread_.join();
  return machine_->truth();
}

}  // namespace sinew::runtime
