#pragma once

#include <functional>
#include <memory>

#include "sinew/sim/cube_world.h"

namespace sinew::sim {

/// Cubes that several machines work on, and others look at.
class SharedCubes {
 public:
  virtual ~SharedCubes() = default;
  /// Calls `what` at once; it is alone with the world meanwhile.
  virtual void with(const std::function<void(CubeWorld&)>& what) = 0;
};

/// A machine whose hand works on a world of cubes: it feels what is between its jaws and what hangs
/// on it, and the cubes go where it takes them.
///
/// Jaws are stopped by a Disturbance kBlock on the number behind the last joint, what is held is a
/// kPayload. A robot without a hand that sim::hand_of() knows is passed through unchanged. Other
/// disturbances, bytes and the lasting state go to the machine as they are.
class CubeTable : public ByteMachine {
 public:
  /// @param machine  of `model`, at the time `boot`
  /// @param X_WB     its base in the world
  /// @param cubes    outlive this one
  /// @param which    number of its hand among them
  CubeTable(std::unique_ptr<ByteMachine> machine, const RobotModel& model,
            const Pose<frame::World, frame::Base>& X_WB, SharedCubes& cubes, std::size_t which,
            Instant boot);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override { return machine_->next_event(); }
  Truth truth() const override { return machine_->truth(); }
  void disturb(const Disturbance& what) override { machine_->disturb(what); }
  LastingState lasting_state() const override { return machine_->lasting_state(); }
  bool restore(const LastingState& state) override;
  void receive(std::span<const std::uint8_t> bytes, Instant now) override;
  std::size_t take_output(std::span<std::uint8_t> out) override {
    return machine_->take_output(out);
  }

 private:
  void move_hand();
  void feel(std::optional<double> blocked, double payload);

  std::unique_ptr<ByteMachine> machine_;
  RobotModel model_;
  Pose<frame::World, frame::Base> X_WB_;
  SharedCubes& cubes_;
  std::size_t which_;
  Instant now_;
  std::optional<double> blocked_;  ///< m, as the machine knows it
  double payload_ = 0;             ///< kg, as the machine knows it
};

}  // namespace sinew::sim
