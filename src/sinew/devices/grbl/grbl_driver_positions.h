#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "sinew/devices/grbl/grbl_settings.h"
#include "sinew/devices/grbl/grbl_wire.h"
#include "sinew/driver/driver.h"

namespace sinew {

/// What a host may believe of the joints of a board that counts steps and nothing else: for each
/// joint a zero, the joint's position where the board counts 0.
///
///   what the first status behind an opened port says   | what is believed then
///   ---------------------------------------------------+--------------------------------------
///   declared without a count                           | the declared place; its zero follows
///   each joint's count lies where it was left, and one | that place: the board has counted on
///   of them is away from 0, or the board has our mark  |
///   likewise, but it was left in a motion and the mark | lost: counts inside a whole motion could
///   is gone                                            | be those of a restart, too
///   anything else                                      | lost: it may have restarted
///   the board says that it has restarted               | lost, where a count was relied on
///
/// Behind a homing cycle the zeros are those of the robot's file. A count that no longer belongs to
/// the joints (an alarm that cut a motion off) makes all of them lost. @rt
class GrblPositions {
 public:
  explicit GrblPositions(const GrblDevice& device);

  /// What is known from elsewhere; before the first status it is kept for that.
  void declare(std::span<const JointPosition> positions);
  /// The board has restarted: its counts mean other places.
  void restart();
  /// Where the joints are is not known, nor what their counts mean.
  void lose();
  /// It has found its switches.
  void homed();
  /// The port went away, or others may have used it: the next count is judged.
  /// @param reach  as far as a motion may go on by itself; empty: it stands
  void leave(std::span<const JointInterval> reach = {});
  /// Whether the board has a mark of ours that it forgets with its power.
  void see_mark(bool there) { mark_ = there; }
  /// A status, machine coordinates.
  void count(const grbl::Values& counts);

  /// The joint where the board counts so much, and back; rad (m) and units. @pre its zero is known
  double place(std::size_t joint, double count) const;
  double count_of(std::size_t joint, double place) const;
  /// Units of a count for so many rad or m.
  double units(std::size_t joint, double way) const {
    return device_.sign(joint) * device_.to_units(joint, way);
  }
  /// The first joint that is not known; nothing: all are.
  std::optional<std::size_t> unknown() const;
  std::optional<JointInterval> counted(std::size_t joint) const;
  /// Joints, a bit each, whose count is not 0.
  std::uint8_t away_from_zero() const;
  const grbl::Values& counts() const { return counts_; }
  /// As counted last; until then as it was left. @param gone  rad or m that a joint may have gone
  /// since, either way
  JointPosition position(std::size_t joint, double gone) const;
  /// Of a board that moves along its lines. @param ahead  counts it may have come to, units
  JointPosition position(std::size_t joint, double gone, const JointInterval& ahead) const;

 private:
  struct Tie {
    std::optional<double> zero;  ///< rad or m where it counts 0
    bool known = false;          ///< and the joint is where that says
  };

  void judge();
  double slack_of(std::size_t joint) const;
  bool still_counts(std::span<const JointPosition> left) const;

  GrblDevice device_;
  FixedVector<Tie, grbl::kAxesMax> ties_;
  grbl::Values counts_;
  bool judged_ = false;
  bool restarted_ = false;    ///< since the port was opened
  std::optional<bool> mark_;  ///< nothing: it does not show
  /// Left on record, or declared, before the first status.
  FixedVector<JointPosition, grbl::kAxesMax> left_;
};

}  // namespace sinew
