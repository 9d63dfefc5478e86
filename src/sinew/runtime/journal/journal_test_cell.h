#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "sinew/control/journal_recovery.h"
#include "sinew/control/position_journal.h"
#include "sinew/runtime/journal/journal_writer.h"
#include "sinew/sim/memory_disk.h"
#include "support/property.h"

namespace sinew::runtime::test {

using sinew::test::Random;

inline constexpr double kUnit = 0x1p-12;  ///< rad a step; exact in binary, so that sums are too
inline constexpr Duration kCycle = std::chrono::milliseconds(1);
inline constexpr std::int64_t kEpoch = 1'700'000'000'000'000'000;

/// How often each JournalFinding was met, by its number.
using FindingCounts =
    std::array<std::uint64_t, std::size_t{1} + static_cast<std::size_t>(JournalFinding::kCleanEnd)>;

inline JournalSettings settings_for(std::size_t joints) {
  JournalSettings settings;
  settings.owner = {journal_hash("pretend"), journal_hash("model")};
  for (std::size_t k = 0; k < joints; ++k) {
    settings.joints.push_back({.block = 64 * kUnit, .lead = 48 * kUnit, .slack = 2 * kUnit});
  }
  return settings;
}

inline RecoverySettings recovery_for(std::size_t joints) {
  return {.owner = settings_for(joints).owner, .joints = joints};
}

/// A joint that really is somewhere, what was sent to it, and what its driver knows.
struct PretendJoint {
  double truth = 0;  ///< where it stood when the motion began
  PositionQuality quality = PositionQuality::kCommanded;
  double lower = 0;  ///< the driver's interval for it then
  double upper = 0;
  std::int64_t sent = 0;  ///< steps since then
  std::int64_t made = 0;  ///< of these
  std::int64_t low = 0;   ///< the made ones are in [low, high], as far as the driver knows
  std::int64_t high = 0;
  std::int64_t target = 0;  ///< of the motion under way, steps

  static double at(double from, std::int64_t steps) {
    return from + static_cast<double>(steps) * kUnit;
  }
  double where() const { return at(truth, made); }
  JointInterval interval(std::int64_t from, std::int64_t to) const {
    return {at(lower, from), at(upper, to)};
  }
  std::int64_t step() const { return (target > sent) - (target < sent); }
  JointPosition now() const {
    if (quality == PositionQuality::kLost) return {};
    const auto [from, to] = interval(low, high);
    return {from == to ? PositionQuality::kCommanded : PositionQuality::kUncertain,
            from + (to - from) / 2, from, to};
  }
  JointInterval next() const {
    return interval(std::min(low, sent + step()), std::max(high, sent + step()));
  }
  void settle() {
    truth = where();
    const auto [from, to] = interval(low, high);
    lower = from, upper = to;
    sent = made = low = high = target = 0;
  }
  void be(const JointPosition& position) {
    quality = position.quality;
    lower = position.lower, upper = position.upper;
  }
};

/// How the lives of a cell go.
struct LifeSettings {
  std::int64_t cycles_max = 400;
  bool hold_on_failure = true;
};

/// A machine with a journal on a disk that outlives it. Every life begins with what recovery says,
/// which is held against the truth, and ends in some way.
class Cell {
 public:
  explicit Cell(Random& random, std::size_t joints = 0)
      : random_(&random),
        joints_(joints > 0 ? joints : static_cast<std::size_t>(random.integer(1, 4))),
        settings_(settings_for(joints_.size())) {
    settings_.generation_records = static_cast<std::uint32_t>(random.integer(3, 40));
    recovery_settings_ = recovery_for(joints_.size());
    if (random.chance(0.3)) {
      for (std::size_t k = 0; k < joints_.size(); ++k) {
        recovery_settings_.power_up_way.push_back(32 * kUnit);
      }
    }
    for (PretendJoint& joint : joints_) {
      joint.truth = PretendJoint::at(0, random.integer(-9999, 9999));
    }
    disk.set_sync_time(std::chrono::milliseconds(1),
                       std::chrono::milliseconds(random.integer(2, 60)), random.bits());
  }

  /// Reads the journal as the next life would, and holds it against the truth.
  JournalRecovery look() {
    JournalFiles files(disk, "positions");
    const auto bytes = files.load();
    EXPECT_TRUE(bytes);
    const auto recovery = recover(bytes->files(), recovery_settings_);
    for (std::size_t k = 0; k < joints_.size(); ++k) {
      const JointPosition& said = recovery.positions[k];
      if (said.quality == PositionQuality::kLost) continue;
      EXPECT_LE(said.lower, joints_[k].truth)
          << "joint " << k << ": " << sentence(recovery.finding);
      EXPECT_GE(said.upper, joints_[k].truth)
          << "joint " << k << ": " << sentence(recovery.finding);
      if (said.quality != PositionQuality::kUncertain) {
        EXPECT_EQ(said.q, joints_[k].truth);
      }
    }
    return recovery;
  }

  /// From the start of a process to just before its end; the machine and the disk are as they then
  /// are. Ends early where the disk's power is cut.
  void live(const LifeSettings& life = {}) {
    const JournalRecovery recovery = look();
    findings[static_cast<std::size_t>(recovery.finding)] += 1;
    for (std::size_t k = 0; k < joints_.size(); ++k) joints_[k].be(recovery.positions[k]);
    JournalFiles files(disk, "positions");
    ASSERT_TRUE(files.lock());
    files.continue_after(recovery.end);
    JournalPump pump(files);
    PositionJournal journal(settings_, recovery.end);
    pump_ = &pump;
    files_ = &files;
    journal_ = &journal;
    busy_until_ = now_;
    moving_ = false;
    closing_ = false;
    failed_at_.reset();
    holds_ = false;
    ASSERT_TRUE(pump.offer(journal.open(positions(), time())));
    // Mostly somebody comes and looks before anything else is done.
    says_where_ = random_->chance(0.8);
    const std::int64_t cycles = random_->integer(1, life.cycles_max);
    for (std::int64_t k = 0; k < cycles && !disk.power_is_cut(); ++k) cycle(life);
    if (disk.power_is_cut()) {
      // The other side of the cell lives on until the disk's call would have been over.
      while (now_ < busy_until_ && !random_->chance(0.05)) cycle(life);
    }
    pump_ = nullptr;
    files_ = nullptr;
    journal_ = nullptr;
  }

  /// The process is gone; the device carries out what it has, or some of it.
  void kill() {
    for (PretendJoint& joint : joints_) {
      joint.made += random_->chance(0.5) ? joint.sent - joint.made : 0;
      joint.settle();
    }
    disk.kill_process();
    now_ += kCycle * 1000;
  }
  /// Nobody has power. When it comes back, steppers turn to their home phase, one in four full
  /// steps; where they did so before they stay.
  void lose_power() {
    for (PretendJoint& joint : joints_) {
      joint.settle();
      if (recovery_settings_.power_up_way.empty()) continue;
      joint.truth = std::round(joint.truth / (64 * kUnit)) * (64 * kUnit);
    }
    disk.lose_power(random_->bits());
    now_ += kCycle * 1000;
  }

  std::size_t size() const { return joints_.size(); }
  const PretendJoint& joint(std::size_t k) const { return joints_[k]; }
  Instant now() const { return now_; }

  sim::MemoryDisk disk;
  std::uint64_t sends = 0;
  std::uint64_t motions = 0;
  std::uint64_t records = 0;
  std::uint64_t sends_after_failure = 0;
  Duration longest_to_hold{};
  FindingCounts findings{};

 private:
  JournalTime time() const { return {now_, kEpoch + now_.time_since_epoch().count()}; }
  std::vector<JointPosition> positions() const {
    std::vector<JointPosition> all;
    for (const PretendJoint& joint : joints_) all.push_back(joint.now());
    return all;
  }

  void cycle(const LifeSettings& life) {
    now_ += kCycle;
    disk.set_wall(kEpoch + now_.time_since_epoch().count());
    write();
    journal_->durable(pump_->durable_sequence());
    for (PretendJoint& joint : joints_) move(joint);
    if (pump_->failed() && life.hold_on_failure) return hold();
    if (moving_) return send();
    rest();
  }

  /// The disk's thread: one call of work() at a time, which takes its time.
  void write() {
    if (now_ < busy_until_) return;
    if (!disk.power_is_cut()) pump_->publish();
    if (disk.power_is_cut() || !pump_->work()) return;
    busy_until_ = now_ + disk.take_time();
    if (files_->failure() && !failed_at_) failed_at_ = now_;
    if (disk.power_is_cut()) busy_until_ = now_ + std::chrono::milliseconds(30);
  }

  void move(PretendJoint& joint) {
    if (joint.made != joint.sent && random_->chance(0.7)) {
      joint.made += joint.sent > joint.made ? 1 : -1;
    }
    if (random_->chance(0.5)) {
      joint.low = std::min(joint.made, joint.sent);
      joint.high = std::max(joint.made, joint.sent);
    }
  }

  void hold() {
    if (holds_) return;
    holds_ = true;
    longest_to_hold = std::max(longest_to_hold, now_ - *failed_at_);
  }

  void offer(const std::optional<JournalRecord>& record) {
    if (!record) return;
    ++records;
    EXPECT_TRUE(pump_->offer(*record));
  }

  void send() {
    const auto now = positions();
    std::vector<JointInterval> next;
    std::vector<JointInterval> whole;
    for (const PretendJoint& joint : joints_) {
      next.push_back(joint.next());
      whole.push_back(
          joint.interval(std::min(joint.low, joint.target), std::max(joint.high, joint.target)));
    }
    JournalMotion motion{now, next, {}};
    if (tells_whole_) motion.whole = whole;
    offer(journal_->reserve(motion, time()));
    bool any = false;
    if (journal_->may_send(next)) {
      for (PretendJoint& joint : joints_) {
        any |= joint.step() != 0;
        joint.sent += joint.step();
        joint.low = std::min(joint.low, joint.sent);
        joint.high = std::max(joint.high, joint.sent);
      }
      sends += any ? 1 : 0;
      sends_after_failure += any && failed_at_ ? 1 : 0;
    }
    // Stops and changes of mind under way.
    for (PretendJoint& joint : joints_) {
      if (random_->chance(0.005)) joint.target = joint.sent;
      if (random_->chance(0.005)) joint.target = random_->integer(-300, 300);
    }
    const bool arrived = std::ranges::all_of(joints_, [](const PretendJoint& joint) {
      return joint.target == joint.sent && joint.made == joint.sent && joint.low == joint.high;
    });
    if (!arrived) return;
    for (PretendJoint& joint : joints_) joint.settle();
    moving_ = false;
  }

  void rest() {
    offer(journal_->at_rest(positions(), time()));
    if (says_where_ || random_->chance(0.01)) declare();
    if (random_->chance(0.005)) lose();
    if (!random_->chance(0.1) || closing_) return;
    if (random_->chance(0.1)) {
      const auto record = journal_->close(positions(), time());
      closing_ = record.has_value();
      return offer(record);
    }
    moving_ = true;
    ++motions;
    tells_whole_ = random_->chance(0.5);
    for (PretendJoint& joint : joints_) {
      if (random_->chance(0.7)) joint.target = random_->integer(-300, 300);
    }
  }

  void declare() {
    std::vector<JointPosition> said;
    for (const PretendJoint& joint : joints_) {
      said.push_back({PositionQuality::kCommanded, joint.truth, joint.truth, joint.truth});
    }
    const auto record = journal_->told(JournalKind::kDeclared, said, time());
    if (!record) return;
    says_where_ = false;
    for (std::size_t k = 0; k < size(); ++k) joints_[k].be(said[k]);
    offer(record);
  }

  /// Somebody pushes a joint, and the device tells that it did not hold.
  void lose() {
    const auto k = static_cast<std::size_t>(random_->integer(0, static_cast<int>(size()) - 1));
    auto said = positions();
    said[k] = {};
    const auto record = journal_->lost(said, JournalCause::kDevice, time());
    if (!record) return;
    joints_[k].be({});
    offer(record);
  }

  Random* random_;
  std::vector<PretendJoint> joints_;
  JournalSettings settings_;
  RecoverySettings recovery_settings_;
  JournalPump* pump_ = nullptr;
  JournalFiles* files_ = nullptr;
  PositionJournal* journal_ = nullptr;
  Instant now_{};
  Instant busy_until_{};
  std::optional<Instant> failed_at_;
  bool holds_ = false;
  bool moving_ = false;
  bool closing_ = false;
  bool says_where_ = false;
  bool tells_whole_ = false;
};

}  // namespace sinew::runtime::test
