#pragma once

#include <functional>

#include "sinew/control/controller.h"
#include "sinew/control/local_machine.h"
#include "sinew/runtime/journal/journal_writer.h"

namespace sinew::runtime {

/// A robot's controller on its driver, with its journal's writer and one client in the same thread.
/// It has no clock and no port: step() follows each call of the driver's receive() and poll(),
/// in real time as in virtual time.
class ControlLoop {
 public:
  /// @param robot, driver, pump  outlive this. @param pump  null: nothing is recorded
  ControlLoop(const RobotModel& robot, Driver& driver, const control::ControllerSettings& settings,
              const control::ControllerStart& start, JournalPump* pump,
              control::ClientId client = 1);

  /// What other clients ask for in the next step, at most Controller::kCommandsMax before it.
  /// False: there is no room.
  bool post(const control::Command& command);

  /// One step, and as many more as there are commands of the machine's client which it was asked
  /// for meanwhile (`between` is where it asks).
  void step(Instant now, const std::function<void()>& between = {});

  control::LocalMachine& machine() { return machine_; }
  control::Controller& controller() { return controller_; }
  const control::Controller& controller() const { return controller_; }

  void set_port_open(bool open) { port_open_ = open; }
  /// From now on its last record is made as soon as it rests.
  void begin_closing() { closing_ = true; }
  /// Everything that was to be recorded is safe, or cannot be any more; after begin_closing() the
  /// last record as well.
  bool recorded() const {
    return pump_ == nullptr || pump_->failed() ||
           (controller_.journal_settled() && (!closing_ || controller_.journal_closed()));
  }
  /// Wall clock of `now`, ns since 1970; zero where nobody says.
  void set_wall(std::int64_t wall_ns) { wall_ns_ = wall_ns; }
  /// What each step gave, for records and clients.
  std::function<void(const control::Outputs&, Instant)> look;

 private:
  void step_once(Instant now);

  control::Controller controller_;
  control::LocalMachine machine_;
  JournalPump* pump_;
  FixedVector<control::Command, control::Controller::kCommandsMax> posted_;
  FixedVector<control::Command, control::Controller::kCommandsMax> commands_;
  bool port_open_ = true;
  bool closing_ = false;
  std::int64_t wall_ns_ = 0;
};

}  // namespace sinew::runtime
