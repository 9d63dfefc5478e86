#include "sinew/runtime/control_loop.h"

#include <algorithm>
#include <variant>

namespace sinew::runtime {

using control::Command;
using control::Controller;

ControlLoop::ControlLoop(const RobotModel& robot, Driver& driver,
                         const control::ControllerSettings& settings,
                         const control::ControllerStart& start, JournalPump* pump,
                         control::ClientId client)
    : controller_(robot, driver, settings, start), machine_(controller_, client), pump_(pump) {}

bool ControlLoop::post(const Command& command) {
  if (posted_.full()) return false;
  posted_.push_back(command);
  return true;
}

void ControlLoop::step(Instant now, const std::function<void()>& between) {
  // A client that answers each event with a command that is refused must not hold the loop.
  constexpr int kStepsMax = 16;
  for (int k = 0; k < kStepsMax; ++k) {
    step_once(now);
    if (between) between();
    if (!machine_.has_commands() && posted_.empty()) return;
  }
}

void ControlLoop::step_once(Instant now) {
  const auto own = machine_.commands(now);
  const std::size_t room = Controller::kCommandsMax - own.size();
  const std::span posted(posted_.data(), std::min(room, posted_.size()));
  commands_.clear();
  // Stops go last: what somebody asks for in the same cycle comes to nothing.
  for (const bool stops : {false, true}) {
    for (const auto& part : {own, std::span<const Command>(posted)}) {
      for (const Command& command : part) {
        if (std::holds_alternative<control::Stop>(command.what) == stops) {
          commands_.push_back(command);
        }
      }
    }
  }
  posted_.drop_front(posted.size());
  const control::Outputs& outputs =
      controller_.step({.commands = {commands_.data(), commands_.size()},
                        .port_open = port_open_,
                        .durable_sequence = pump_ != nullptr ? pump_->durable_sequence() : 0,
                        .journal_failed = pump_ != nullptr && pump_->failed(),
                        .closing = closing_,
                        .wall_ns = wall_ns_},
                       now);
  for (const JournalRecord& record : outputs.records) {
    // The controller never has more on their way than the queue holds.
    if (pump_ != nullptr) pump_->offer(record);
  }
  machine_.take(outputs);
  if (look) look(outputs, now);
}

}  // namespace sinew::runtime
