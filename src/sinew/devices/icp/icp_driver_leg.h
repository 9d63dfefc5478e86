#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "sinew/devices/icp/icp_settings.h"
#include "sinew/devices/icp/icp_wire.h"
#include "sinew/driver/driver.h"
#include "sinew/model/device.h"

namespace sinew {

/// What the host knows of one leg: whole position units from the place where it was declared, and
/// how far the truth may be from that on either side. No sensor tells; only what was sent and what
/// was acknowledged. All members are @rt.
class IcpLegClaim {
 public:
  /// What two power cuts in a row may turn the motor by, 23 electrical turns, 0.32 mm of leg:
  ///
  ///   to where the magnets hold it without current, half a full step, and its lag   11
  ///   to the home phase when the current comes back, two full steps                 32
  ///   a second cut in that swing: it runs on until friction has used its energy   1277
  ///   the current comes back before it rests: until the windings have braked it     95
  ///
  /// A rotor on top of its magnetic hill holds 2 T/Z = 8.8 mJ (T = 0.22 Nm, Z = 50 pole pairs);
  /// 3.5 mNm of dry spindle, the least that is assumed, use it up in 2.51 rad = 1277 units, and
  /// with the fifth of T that windings brake with in 0.19 rad = 95 units. One cut alone: 43. The
  /// simulated motor made 615 at most, over all moments of both cuts, 2026-11. Only a module that
  /// wakes up can swing, so a third cut counts when the next status or silence tells of it.
  static constexpr std::int64_t kPowerCutUnits = IcpDevice::kPowerCutUnits;
  /// Where the current comes back, the rotor may rest on top of its magnetic hill, held by friction
  /// alone: a quarter of all motors do, since without current it rests at one of four places of an
  /// electrical turn. The first step lets it fall two full steps to either side, and swing as far
  /// again. What is declared before that step is only as good as this.
  static constexpr std::int64_t kHillUnits = 64;

  enum class Verdict : std::uint8_t {
    kGood,
    kDoubtful,  ///< may be a damaged answer: nothing that a second reading would not show again
    kBad,       ///< flags, which the reading has cleared
  };

  IcpLegClaim(std::int8_t index, const IcpLeg& leg, double units_per_m,
              std::int64_t units_per_down);

  /// From a record: as good as it says.
  void declare(const JointPosition& position);
  /// Somebody says where it stands, with the current on.
  void declare_standing(const JointPosition& position);
  JointPosition position() const;
  bool known() const { return known_; }
  /// Width of the interval, units.
  std::int64_t uncertainty() const { return upper() - lower(); }

  /// Direction bit of the wire; direction is +1 (longer) or -1.
  bool wire_bit(int direction) const { return (direction < 0) != invert_; }
  /// Steps that bring it nearest to q, m, without going beyond it.
  std::int64_t steps_to(double q) const;
  /// m that so many steps change it by.
  double way_of(std::int64_t steps) const;

  /// The step was acknowledged.
  void stepped(int direction);
  /// Nobody knows whether it was made.
  void maybe_stepped(int direction);
  /// A status was asked for, its flags are cleared, and the answer did not come: the last step may
  /// have been lost without a trace.
  void status_lost();

  /// Stepped since the last good status.
  bool moved() const { return moved_; }
  /// @return  the verdict, and in `error` what is wrong.
  Verdict judge(const icp::Status& status, Error& error) const;
  /// Its module holds a target position that only a power cut or a lost step would take away.
  bool tagged() const { return tag_ != 0 || counted_; }
  /// A run before left it with one.
  void expect_tag() { counted_ = true; }
  /// All is well: what was sent was done.
  void confirm(const icp::Status& status);
  /// Anything since the last good status may not have been done.
  void withdraw(const icp::Status& status);
  /// The status tells of a supply that was away or too low, which all legs share.
  bool shows_supply_loss(const icp::Status& status) const;
  /// Another leg tells of the supply: until round_passed() the interval holds all that this one may
  /// have done since the last good round, and kPowerCutUnits. Withdrawn, its own status decides.
  void suspect_supply() { suspected_ = suspected_ || !withdrawn_; }
  /// Nobody answers. The same, and for good where the leg is withdrawn: its module holds nothing
  /// any more that another power cut could take away.
  void suspect_silence() { suspected_ = true; }
  /// Every status of a round was good: the modules have kept what they held.
  void round_passed();

 private:
  bool forgot(const icp::Status& status) const;
  std::int64_t size_of(int direction) const { return wire_bit(direction) ? units_per_down_ : 1; }
  std::int64_t lower() const;
  std::int64_t upper() const;
  void widen(std::int64_t lower, std::int64_t upper);
  void widen_by_power_cut();
  void grow_hull();

  std::int8_t index_;
  bool invert_;
  std::uint8_t address_;
  double units_per_m_;
  std::int64_t units_per_down_;

  bool known_ = false;
  double origin_ = 0;       ///< m, at 0 units
  std::int64_t units_ = 0;  ///< best guess
  std::int64_t below_ = 0;  ///< the truth is in [units - below, units + above]
  std::int64_t above_ = 0;
  std::int64_t hull_lower_ = 0;  ///< of all that the truth may have been since a good round
  std::int64_t hull_upper_ = 0;
  bool suspected_ = false;  ///< the supply may have been away since then
  bool confirmed_ = false;  ///< in the round under way
  bool withdrawn_ = false;  ///< and not moved since: no target position shows another power cut
  bool moved_ = false;
  bool on_hill_ = true;      ///< no step is known since the current may have come back
  std::int64_t slack_ = 0;   ///< units that a declared place may be off by, on either side
  std::int64_t tag_ = 0;     ///< |target position| that the module must show; 0: anything
  bool counted_ = false;     ///< |target position| is not 0, unless its power was away
  bool last_maybe_ = false;  ///< a later step may or may not have been made
  int last_direction_ = 1;
  /// Steps by direction bit whose size no status has shown yet.
  std::array<std::int64_t, 2> unseen_{};
};

}  // namespace sinew
