#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "sinew/core/cubic.h"
#include "sinew/core/fixed_vector.h"
#include "sinew/core/instant.h"
#include "sinew/devices/ideal/ideal_wire.h"
#include "sinew/model/robot_model.h"

namespace sinew::ideal {

/// Moves that wait or are under way.
inline constexpr std::size_t kMovesMax = 8;

/// A device that does what is asked of it, exactly: each move is the cubic from the end of the one
/// before it, and its sensors are perfect. It brakes on its path, as hard as the joint allows that
/// has to brake longest. What keeps a host honest is all there: a move that leaves a joint's range
/// or is faster than its speed anywhere on its way is refused, a silent host stops it, and moves
/// that end in motion do.
///
///   phase     | what ends it                              | then
///   ----------+-------------------------------------------+------------------------------
///   kRest     | a move                                    | kMoving
///   kMoving   | the last move ends at rest                | kRest
///             | the last move does not                    | kStopping, held: starved
///             | 100 ms without a line                     | kStopping, held: silent
///             | a joint meets something                   | kHeld: blocked
///             | stop                                      | kStopping
///   kStopping | it stands                                 | kRest, or kHeld with the reason
///   kHeld     | clear                                     | kRest
///   any       | its power is back                         | kHeld: started; moves count from 0
///
/// Time is handed in and never runs back. @rt
class IdealDevice {
 public:
  /// @param joints  1 to 8, kept as they are
  IdealDevice(std::span<const Joint> joints, const std::optional<JawGripper>& gripper,
              Instant boot);

  void advance(Instant now);
  /// Advances first.
  Reply answer(const Request& request, Instant now);

  std::span<const double> q() const { return {q_.data(), q_.size()}; }     ///< rad or m
  std::span<const double> qd() const { return {qd_.data(), qd_.size()}; }  ///< per s
  double jaws() const { return jaws_; }  ///< m between them; 0 without a gripper
  bool moving() const { return phase_ == Phase::kMoving || phase_ == Phase::kStopping; }
  /// The joint that met something since the last move; -1: none did.
  int blocked_joint() const { return held_ == Held::kBlocked ? blocked_joint_ : -1; }

  // What happens to it.

  /// The joint cannot pass this place, rad or m, from the side on which it is now.
  void block(std::size_t joint, double at);
  void unblock(std::size_t joint);
  /// Something is between the jaws: they close no further than to this width, m.
  void block_jaws(double width) { jaws_least_ = width; }
  void unblock_jaws() { jaws_least_ = 0; }
  /// It is there from now on.
  void place(std::span<const double> q);
  /// Stands at once.
  void lose_power();

 private:
  struct Piece {
    std::uint16_t number = 0;
    double duration = 0;  ///< s
    FixedVector<Cubic, kJointsMax> joints;

    bool ends_at_rest() const;
  };
  struct Free {
    double lower = 0, upper = 0;  ///< between what blocks it
  };

  State state() const;
  bool allows(std::size_t joint, double from, const Cubic& way) const;
  Reply take(const Move& move);
  Reply take(const Jaws& jaws);
  void begin_stop(Held held);
  void end_at(Phase phase);
  void stand();
  void step(double dt);
  void put_joints();
  bool runs_into_something();

  FixedVector<Joint, kMaxJoints> joints_;
  std::optional<double> width_max_;
  Instant now_;
  Instant heard_;

  Phase phase_ = Phase::kHeld;
  Held held_ = Held::kStarted;
  int blocked_joint_ = 0;
  std::uint16_t taken_ = 0;
  std::uint16_t done_ = 0;
  JointVector q_, qd_;
  FixedVector<Free, kMaxJoints> free_;
  double jaws_ = 0;
  double jaws_to_ = 0;
  double jaws_least_ = 0;

  FixedVector<Piece, kMovesMax> pieces_;
  double time_ = 0;        ///< s into the first piece, or beyond the last one while it brakes
  double rate_ = 1;        ///< of the pieces' own time against time: it brakes by this
  double brake_time_ = 0;  ///< s from rate 1 to rate 0
};

}  // namespace sinew::ideal
