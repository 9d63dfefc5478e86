#pragma once

#include <memory>
#include <span>

#include "sinew/control/journal_record.h"
#include "sinew/driver/driver.h"
#include "sinew/planning/collision/cell_way.h"

namespace sinew::control {

/// A motion from rest to rest that somebody has planned, in the pieces in which its device takes
/// it. Pieces are made while the motion goes on, so that it can be changed under way. All members
/// are @rt but where a derived class says otherwise.
class MotionSource {
 public:
  virtual ~MotionSource() = default;

  /// Where the machine has to stand when it begins.
  virtual const JointVector& q_start() const = 0;
  /// The next piece; the same one until taken(). Null where it has come to rest: at its end, or
  /// because it is held. @param now  of the cycle; what a jog's commands are dated by
  virtual const JointMove* next(Instant now) = 0;
  /// The driver has it.
  virtual void taken() = 0;
  /// Nothing is left to do.
  virtual bool finished() const = 0;

  /// To rest on the way, as soon as the limits allow; pieces of the braking follow.
  virtual void hold() = 0;
  /// On from there.
  virtual void resume() = 0;
  /// The pace from now on, a share of the planned one; 0 is a hold that ends with the next one.
  /// @error kTaskNotSupported, kMoveInput (no number, or out of range)
  virtual Expected<void> set_feed(double share) = 0;

  /// Pairs of links that are too near to each other where it begins, and that it leads apart.
  virtual std::span<const LinkPair> overlaps() const { return {}; }
  /// All that its joints may do until its end; empty where nobody knows.
  virtual std::span<const JointInterval> whole() const { return {}; }
  /// What its joints do until its end, as its device makes it; null where nobody knows. It may
  /// refer to this. Allocates.
  virtual std::unique_ptr<planning::CellWay> way() const { return nullptr; }
  /// Share of it that was handed over, 0..1.
  virtual double progress() const = 0;
  /// s until it is at rest, of what was not handed over yet; nobody's promise.
  virtual double time_left() const = 0;
};

}  // namespace sinew::control
