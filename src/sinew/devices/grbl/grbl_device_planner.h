#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sinew/core/fixed_vector.h"
#include "sinew/devices/grbl/grbl_wire.h"

namespace sinew::grbl {

/// How fast an axis goes at most, as the board's settings say. Units are deg or mm.
struct AxisRates {
  double rate = 0;          ///< units/s
  double acceleration = 0;  ///< units/s^2
};

/// The motion planner of a GRBL board: straight motions of all axes together, one behind the other,
/// each with a trapezoid of speed. It looks ahead over all that wait, so that it can always come to
/// rest at the end of the last one, and passes corners at the speed that the junction deviation
/// allows (gnea/grbl, planner.c: circle tangent to both motions, deviation = its distance from the
/// corner). Lengths are Euclidean over the axes' units. @rt
class Planner {
 public:
  /// 16 blocks in GRBL 1.1, of which one stays free.
  static constexpr std::size_t kBlocks = 15;

  /// @param deviation  setting $11, units
  Planner(std::span<const AxisRates> axes, double deviation);

  bool full() const { return blocks_.full(); }
  bool empty() const { return blocks_.empty(); }
  std::size_t size() const { return blocks_.size(); }
  /// A motion to there from the end of the last one. Nothing where it is no way.
  /// @param duration  s; it takes longer where an axis is not fast enough
  /// @pre not full
  void push(const Values& to, double duration);
  /// Brakes on the path, and stands until resume().
  void hold() { held_ = true; }
  void resume() { held_ = false; }
  bool held() const { return held_; }
  bool at_rest() const { return speed_ == 0 && (held_ || empty()); }
  /// Drops everything; it stands where it is.
  void clear();
  /// Where it stands. @pre empty
  void place(const Values& at) { at_ = at; }

  /// @param dt  s
  void advance(double dt);
  const Values& position() const { return at_; }
  /// units/s on the path
  double speed() const { return speed_; }
  /// Of one axis, units/s.
  double velocity(std::size_t axis) const;

 private:
  struct Block {
    Values from, direction;  ///< `direction` has length 1
    double length = 0;
    double acceleration = 0;
    double nominal = 0;    ///< units/s
    double entry_max = 0;  ///< (units/s)^2
    double entry = 0;      ///< (units/s)^2, so that all behind it can be braked for
  };

  double corner(const Block& before, const Block& after) const;
  double most(const Values& direction, double AxisRates::* limit) const;
  void look_ahead();
  double run(double dt);
  double brake(double dt);
  double end_block(double left);

  FixedVector<AxisRates, kAxesMax> axes_;
  double deviation_;
  FixedVector<Block, kBlocks> blocks_;
  Values at_;
  double along_ = 0;  ///< units into the first block
  double speed_ = 0;
  bool held_ = false;
};

}  // namespace sinew::grbl
