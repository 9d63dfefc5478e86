#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "faults/fault_cell.h"
#include "faults/ledger.h"
#include "sinew/motion/rest_to_rest.h"
#include "support/property.h"

namespace sinew::test {

/// How a joint's position comes back after it was lost.
enum class Regain : std::uint8_t {
  kDeclare,   ///< whoever looks at the machine says it
  kSlowMove,  ///< a slow move to a known place
  kHome,      ///< by its end stops
  kMeasured,  ///< by itself
};

/// What a wire promises, and how hard it is tried. Its document in docs/wires/ says why.
struct WireRules {
  std::string robot;
  std::optional<std::string> profile;
  std::optional<std::string> wire;
  Regain regain = Regain::kMeasured;
  /// Any damaged frame is known as such: no wrong motion and no wrong position, ever.
  bool trusted = true;
  /// Where not: what is claimed at rest is true all the same, right behind the faults.
  bool true_at_rest = false;
  /// A damaged order may keep the device away for hours, until somebody cuts its power.
  bool runs_away = false;
  double tolerance = 0;  ///< rad or m: sag, backlash and dead band beyond what is claimed
  double overshoot = 0;  ///< rad or m beyond the way that was asked for
  /// The device knows where it stands, where the host has but an interval: a move is taken.
  bool moves_uncertain = false;
  bool stores_only = false;  ///< the device answers and moves nothing: the truth is where it stood
  bool by_field = false;     ///< the motor's field is what is claimed, not the rotor that trails it
  Duration recovery{};       ///< from the last fault, or the end of a motion, to ready or a fault
  Duration rest{};           ///< then, until what is claimed must be true
  Duration phase{};          ///< longest time with faults
  Duration longest_motion{};  ///< that a damaged order may make
  /// Where moves may go, inside the joints' limits; rad or m.
  std::array<double, kMaxJoints> lower = filled(-1e9);
  std::array<double, kMaxJoints> upper = filled(1e9);
  double way = 0.1;         ///< of a joint's range, the longest move
  double chance_max = 0.3;  ///< of each fault, per byte
  /// Instead of random faults, one flipped bit at a time, with so long between two that the driver
  /// has got over the first; zero: in every exchange.
  std::optional<Duration> single_flips;
  bool closes = true;                          ///< the port goes away now and then
  double excess_max = 1e9;                     ///< rad or m beyond the way, where it may be left
  Duration stray_max = std::chrono::hours(1);  ///< beyond the way, at a stretch
  int episodes = 20;                           ///< with one machine
  /// Where SINEW_FAULTS asks for a number of faults: so many for one, for about a minute of a
  /// million.
  double faults_each = 1;

 private:
  static constexpr std::array<double, kMaxJoints> filled(double value) {
    std::array<double, kMaxJoints> all{};
    all.fill(value);
    return all;
  }
};

/// What a campaign found.
struct CampaignSums {
  std::uint64_t faults = 0;
  std::uint64_t episodes = 0;
  std::uint64_t done = 0;
  std::uint64_t failed = 0;
  std::uint64_t stopped = 0;
  std::uint64_t refused = 0;
  std::uint64_t power_cuts = 0;
  std::uint64_t homings = 0;
  std::uint64_t second_tries = 0;   ///< of motions without any fault
  std::uint64_t slips = 0;          ///< wrong claims of a motor that slipped
  std::uint64_t runaways = 0;       ///< of those, because the machine went on and on
  std::uint64_t wrong_motions = 0;  ///< episodes in which a joint left the way it was asked to go
  std::uint64_t wrong_rests = 0;    ///< episodes after which a claim was not true
  double worst_excess = 0;          ///< rad or m beyond that way
  Duration worst_stray{};           ///< beyond that way, at a stretch
  double worst_error = 0;           ///< rad or m beyond a claim at rest
  Duration worst_recovery{};
  Duration virtual_time{};
  std::map<std::string, std::uint64_t> device_faults;  ///< kFault, by its code
};

/// One machine under random use and random faults. An episode is a phase with faults, the time that
/// the driver needs to find its way back, a rest at which its claims are held against the truth,
/// and a clean motion.
class FaultCase {
 public:
  /// @param robot, rules, sums  outlive it
  FaultCase(const RobotModel& robot, const WireRules& rules, std::uint64_t seed,
            CampaignSums& sums);

  /// Up and at a known place. @return  false: it has complained
  bool begin();
  bool episode();
  /// No faults: motions as people make them.
  bool clean_motions(int count);
  /// Adds what has been counted since it began to the sums.
  void add_counts();
  const std::string& complaint() const { return complaint_; }

 private:
  struct Range {
    double lower = 0;
    double upper = 0;
  };

  void watch(const std::optional<DriverEvent>& event);
  void watch_way();
  void note_stray(std::size_t joint, double excess);
  void flip_now_and_then();
  void widen_way(const JointVector& target);
  double place(const sim::JointTruth& joint) const {
    return rules_.by_field ? joint.believed : joint.q;
  }
  void watch_health();
  void act();
  void ask_move(double speed);
  void ask_tool();
  void feed();
  void reopen();
  void declare();
  bool run_for(Duration duration, bool user);
  bool settle();
  bool resolve_fault();
  bool power_cycle();
  bool regain();
  bool counts_far_away();
  bool clean_motion();
  bool motion_to_its_end();
  bool judge_rest();
  bool known() const;
  sim::LinkFaultSpec draw_faults(Duration phase);
  std::string described() const;
  bool complain(const std::string& what);

  const RobotModel& robot_;
  const WireRules& rules_;
  CampaignSums& sums_;
  Random random_;
  FaultCell cell_;
  Ledger ledger_;
  DriverHealth health_;
  std::optional<Error> last_error_;
  std::string complaint_;
  std::string wrong_claim_;  ///< the last one that was forgiven
  int episode_ = 0;

  Instant next_action_{};
  Instant next_look_{};
  Instant motion_end_{};  ///< of all that was asked for, as predicted
  std::optional<motion::RestToRest> profile_;
  int segments_ = 0;
  int segments_sent_ = 0;
  std::vector<Range> way_;  ///< where each joint may be
  bool anywhere_ = false;   ///< homing: no way to hold it to
  bool strayed_ = false;
  std::optional<Instant> stray_since_;
  bool flipping_ = false;
  Instant next_flip_{};
};

}  // namespace sinew::test
