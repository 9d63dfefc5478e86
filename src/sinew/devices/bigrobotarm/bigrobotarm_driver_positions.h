#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>

#include "sinew/devices/bigrobotarm/bigrobotarm_driver_multipliers.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_settings.h"
#include "sinew/devices/bigrobotarm/bigrobotarm_wire.h"
#include "sinew/driver/driver.h"
#include "sinew/model/device.h"

namespace sinew {

/// What a host may believe of a BigRobotArm's joints, from what it asked and what the device told:
/// a zero for each joint (the model's position where the device counts 0), the steps that were last
/// confirmed, and how far the truth may be from there.
///
///   a confirmed status says               | what is believed then
///   --------------------------------------+---------------------------------------------------
///   the first one, after a declaration    | the declared place, its zero follows
///   the first one, with count zeros       | where the board counts it: it was never off, since
///                                         | power-up values would show that. Lost where that
///                                         | lies outside what was declared
///   the first one, nothing declared       | lost
///   the steps we left, or were going to   | those
///   power-up values, at rest before       | the place we left, uncertain by two full steps more
///   power-up values, in motion before     | lost
///   counters kept over a restart          | as they count, uncertain by two full steps more
///   all steps 0 and nobody sent it there  | uncertain from the place we left to the zero: a
///                                         | damaged request reset the counters, or went home
///   other steps, another host between     | lost
///   other steps                           | those: a damaged goto, in the frame as it was; lost
///                                         | where they lie outside the joints' limits (lose())
///   sync mode                             | lost: it moves in a frame of its own
///
/// `commanded` means within one full motor step, by which a rotor may trail its field. Declared
/// after a reset or after a loss it means within three, for every joint that has not turned since
/// by four full steps: a power stage that starts anew, a motor that slipped and a mechanical end
/// leave the rotor anywhere between two rests, and it goes to one of them when its motor turns.
/// With a = 2/pi asin((load + friction) / holding torque) full steps, it stands as far as 2 - a
/// from the pole that it leaves and comes to rest as far as a beyond the next, four on: 2 + 2a from
/// where it was seen, which is three while load and friction are below 0.7 of the holding torque;
/// pressed against an end it stands up to 2 from its own pole and ends up to a beside that. @rt
class BigRobotArmPositions {
 public:
  using Words = bigrobotarm::Words;
  using Angles = std::array<double, bigrobotarm::kJoints>;

  explicit BigRobotArmPositions(const BigRobotArmJoints& joints);

  /// Where the arm stands, from whoever knows and has recorded it; while nothing is heard yet it is
  /// kept for the first status.
  void declare(std::span<const JointPosition> positions);
  /// A goto may be carried out from now on; lasts until arrive() or judge().
  void go(const Words& target);
  /// It was not sent after all.
  void stay() { going_ = false; }
  /// It was, and everything says so.
  void arrive();
  /// Nobody knows what the device understood.
  void doubt();
  /// A port that others may have used is open again.
  void reopen() { reopened_ = heard_; }
  /// It went where its mechanical ends are, and its motors may have slipped there.
  void lose();
  /// A status that two readings agree on.
  void judge(const bigrobotarm::Status& status, BigRobotArmStart start);

  const Words& steps() const { return steps_; }
  const Angles& offset() const { return offset_; }
  /// Where the board counts it, with what ties its count to the joint. A board that was never tied
  /// counts from where it was switched on: the document's home. Nothing where its frame is gone.
  std::optional<JointInterval> counted(std::size_t joint) const;
  /// The first joint that was declared elsewhere than the board counted it, rad; until taken.
  std::optional<Error> take_contradiction() { return std::exchange(contradiction_, std::nullopt); }
  /// The board counts 0 from here on.
  void zero();
  /// The first joint that no move may start from; nothing: all may.
  std::optional<std::size_t> unknown() const;
  bool declared() const { return declared_; }
  bool going() const { return going_; }

  /// @param progress  0..1 of the motion under way.
  void show(double progress, std::span<JointPosition> positions) const;

 private:
  /// How far the truth may be from the nominal place, rad.
  struct Slack {
    bool lost = true;
    bool uncertain = false;
    double lower = 0;
    double upper = 0;
  };

  double angle(std::size_t joint, const Words& steps) const;
  double full_step(std::size_t joint) const;
  void take_declaration(std::span<const JointPosition> positions);
  void settle_by_count(std::span<const JointPosition> said);
  bool is_tied(std::size_t joint) const;
  void widen_by_snap();
  bool turned(std::size_t joint, const Words& from, const Words& to) const;
  void reach_from_zero(const Words& from);

  BigRobotArmJoints joints_;
  Angles offset_{};
  Words steps_{};
  Words target_{};
  bool heard_ = false;     ///< a status was judged
  bool declared_ = false;  ///< since the last thing that moved the frame
  bool going_ = false;
  bool doubted_ = false;
  bool reopened_ = false;
  std::array<bool, bigrobotarm::kJoints> between_rests_{};  ///< its rotor may be, see above
  std::optional<std::array<JointPosition, bigrobotarm::kJoints>> pending_;
  std::array<Slack, bigrobotarm::kJoints> slack_;
  /// Count zeros of joints whose place is not known: evidence, not yet a place.
  std::array<std::optional<double>, bigrobotarm::kJoints> ties_{};
  std::optional<Error> contradiction_;
};

}  // namespace sinew
