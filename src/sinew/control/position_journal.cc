#include "sinew/control/position_journal.h"

#include <algorithm>
#include <cmath>

#include "sinew/core/assert.h"

namespace sinew {
namespace {

JointInterval interval_of(const JointPosition& joint) {
  return {joint.lower, joint.upper};
}

bool is_lost(const JointPosition& joint) {
  return joint.quality == PositionQuality::kLost;
}

/// What a record may say: nothing that is not a number, no guess outside its interval.
JointPosition recordable(const JointPosition& joint) {
  const bool finite =
      std::isfinite(joint.lower) && std::isfinite(joint.upper) && std::isfinite(joint.q);
  JointPosition result = joint;
  if (joint.count_zero && !std::isfinite(*joint.count_zero)) result.count_zero.reset();
  if (is_lost(joint) || !finite || !(joint.lower <= joint.upper)) {
    return {.count_zero = result.count_zero};
  }
  result.q = std::clamp(joint.q, joint.lower, joint.upper);
  return result;
}

JournalPositions recordable(std::span<const JointPosition> positions) {
  JournalPositions result;
  for (const JointPosition& joint : positions) result.push_back(recordable(joint));
  return result;
}

/// What is recorded says all that is to be said. Sensors are never still: the record has room.
bool says(const JointPosition& recorded, const JointPosition& now) {
  if (recorded.quality != now.quality || recorded.count_zero != now.count_zero) return false;
  if (now.quality == PositionQuality::kMeasured) {
    return covers(interval_of(recorded), interval_of(now));
  }
  return recorded.q == now.q && recorded.lower == now.lower && recorded.upper == now.upper;
}

}  // namespace

PositionJournal::PositionJournal(const JournalSettings& settings, const JournalEnd& end)
    : settings_(settings), sequence_(end.sequence), generation_(end.generation) {
  SINEW_ASSERT(!settings.joints.empty() && settings.generation_records > 0);
}

JournalRecord PositionJournal::open(std::span<const JointPosition> positions,
                                    const JournalTime& time) {
  SINEW_ASSERT(!open_);
  open_ = true;
  // Whatever the files look like behind the crash, this run does not add to them.
  ++generation_;
  rest_ = standing(positions);
  const bool lost = std::ranges::any_of(rest_, is_lost);
  return hand_out(JournalKind::kOpened, lost ? JournalCause::kRecovery : JournalCause::kNone, rest_,
                  time);
}

JournalRecord PositionJournal::hand_out(JournalKind kind, JournalCause cause,
                                        const JournalPositions& positions,
                                        const JournalTime& time) {
  SINEW_ASSERT(open_ && positions.size() == settings_.joints.size() && !claims_.full());
  const std::uint32_t records_max =
      settings_.generation_records * (kind == JournalKind::kIntent ? 2 : 1);
  if (records_ >= records_max) {
    ++generation_;
    records_ = 0;
  }
  ++records_;
  ++sequence_;
  if (cause == JournalCause::kNone && held_) cause = JournalCause::kHeld;
  claims_.push_back({sequence_, kind, held_, counted_, time.run, positions});
  return {kind, cause, sequence_, generation_, settings_.owner, time, positions, counted_};
}

JournalPositions PositionJournal::standing(std::span<const JointPosition> positions) const {
  JournalPositions result = recordable(positions);
  for (std::size_t k = 0; k < result.size(); ++k) {
    if (result[k].quality != PositionQuality::kMeasured) continue;
    result[k].lower -= settings_.joints[k].slack;
    result[k].upper += settings_.joints[k].slack;
  }
  return result;
}

JointPosition PositionJournal::reserved(std::size_t joint, const JournalMotion& motion) const {
  const JointPosition now = recordable(motion.now[joint]);
  if (is_lost(now)) return now;
  const JointInterval& next = motion.next[joint];
  // A joint that only stands keeps what was known of it at rest.
  if (!is_lost(rest_[joint]) && covers(interval_of(now), next) &&
      covers(interval_of(rest_[joint]), interval_of(now)) &&
      rest_[joint].count_zero == now.count_zero) {
    return rest_[joint];
  }
  const JournalJoint& settings = settings_.joints[joint];
  const double ahead = settings.block + settings.lead;
  JointInterval block{next.lower < now.lower ? next.lower - ahead : next.lower,
                      next.upper > now.upper ? next.upper + ahead : next.upper};
  block.lower = std::max(block.lower, settings.lower);
  block.upper = std::min(block.upper, settings.upper);
  // Where a way to rest leads out of the motion, the next piece's may lead farther out.
  if (!motion.whole.empty()) {
    const JointInterval& whole = motion.whole[joint];
    if (next.lower >= whole.lower) block.lower = std::max(block.lower, whole.lower);
    if (next.upper <= whole.upper) block.upper = std::min(block.upper, whole.upper);
  }
  JointPosition result{PositionQuality::kUncertain, now.q, 0, 0, now.count_zero};
  result.lower = std::min({block.lower, next.lower, now.lower}) - settings.slack;
  result.upper = std::max({block.upper, next.upper, now.upper}) + settings.slack;
  return result;
}

bool PositionJournal::runs_out(std::size_t joint, const JournalMotion& motion) const {
  const JointPosition& written = claims_.back().positions[joint];
  const JointPosition& now = motion.now[joint];
  // Never a tie that no longer holds.
  if (written.count_zero && written.count_zero != now.count_zero) return true;
  if (is_lost(now)) return !is_lost(written);
  if (is_lost(written)) return true;
  const JointInterval& next = motion.next[joint];
  if (!covers(interval_of(written), next) || !covers(interval_of(written), interval_of(now))) {
    return true;
  }
  const JournalJoint& settings = settings_.joints[joint];
  // Towards a limit or the motion's end there is nothing more to reserve.
  double lower_most = settings.lower - settings.slack;
  double upper_most = settings.upper + settings.slack;
  if (!motion.whole.empty()) {
    lower_most = std::max(lower_most, motion.whole[joint].lower - settings.slack);
    upper_most = std::min(upper_most, motion.whole[joint].upper + settings.slack);
  }
  const double left = settings.lead + settings.slack;
  const bool down = next.lower < now.lower && written.lower > lower_most;
  const bool up = next.upper > now.upper && written.upper < upper_most;
  return (down && next.lower - written.lower < left) || (up && written.upper - next.upper < left);
}

std::optional<JournalRecord> PositionJournal::reserve(const JournalMotion& motion,
                                                      const JournalTime& time) {
  SINEW_ASSERT(open_ && motion.now.size() == settings_.joints.size() &&
               motion.next.size() == settings_.joints.size());
  if (claims_.full()) return std::nullopt;
  bool due = claims_.back().kind != JournalKind::kIntent;
  for (std::size_t k = 0; k < settings_.joints.size() && !due; ++k) due = runs_out(k, motion);
  if (!due) return std::nullopt;
  JournalPositions positions;
  for (std::size_t k = 0; k < settings_.joints.size(); ++k) {
    positions.push_back(reserved(k, motion));
  }
  return hand_out(JournalKind::kIntent, JournalCause::kNone, positions, time);
}

bool PositionJournal::may_send(std::span<const JointInterval> next) const {
  SINEW_ASSERT(open_ && next.size() == settings_.joints.size());
  // The first of them is safe: before it is, it is this run's kOpened.
  return std::ranges::all_of(claims_, [&](const Claim& claim) {
    // Lost joints may move under any intent, but under nothing else.
    if (claim.kind != JournalKind::kIntent) return false;
    for (std::size_t k = 0; k < next.size(); ++k) {
      const JointPosition& joint = claim.positions[k];
      if (!is_lost(joint) && !covers(interval_of(joint), next[k])) return false;
    }
    return true;
  });
}

std::optional<JournalRecord> PositionJournal::look(std::span<const JointPosition> positions,
                                                   const JournalTime& time) {
  SINEW_ASSERT(open_ && positions.size() == settings_.joints.size());
  if (claims_.full()) return std::nullopt;
  const Claim& last = claims_.back();
  const JournalPositions now = recordable(positions);
  const bool within = std::ranges::equal(last.positions, now, [](const auto& said, const auto& is) {
    return is_lost(said) || (!is_lost(is) && covers(interval_of(said), interval_of(is)));
  });
  if (within && last.kind == JournalKind::kLook) return std::nullopt;
  // Where a motion is under way its interval stays: it may go on behind the look.
  const bool under_way = within && last.kind == JournalKind::kIntent;
  return hand_out(JournalKind::kLook, JournalCause::kNone, under_way ? last.positions : now, time);
}

bool PositionJournal::may_look() const {
  SINEW_ASSERT(open_);
  return std::ranges::all_of(claims_,
                             [](const Claim& claim) { return claim.kind == JournalKind::kLook; });
}

std::optional<JournalRecord> PositionJournal::stand(JournalKind kind, JournalCause cause,
                                                    std::span<const JointPosition> positions,
                                                    const JournalTime& time) {
  SINEW_ASSERT(open_ && positions.size() == settings_.joints.size());
  if (claims_.full()) return std::nullopt;
  rest_ = standing(positions);
  return hand_out(kind, cause, rest_, time);
}

std::optional<JournalRecord> PositionJournal::at_rest(std::span<const JointPosition> positions,
                                                      const JournalTime& time) {
  const Claim& last = claims_.back();
  const bool stands = last.kind != JournalKind::kIntent && last.kind != JournalKind::kLook;
  if (stands && last.held == held_ && last.counted == counted_ &&
      std::ranges::equal(last.positions, recordable(positions), says)) {
    return std::nullopt;
  }
  return stand(JournalKind::kRest, JournalCause::kNone, positions, time);
}

std::optional<JournalRecord> PositionJournal::told(JournalKind kind,
                                                   std::span<const JointPosition> positions,
                                                   const JournalTime& time) {
  SINEW_ASSERT(kind == JournalKind::kDeclared || kind == JournalKind::kHomed ||
               kind == JournalKind::kMeasured);
  return stand(kind, JournalCause::kNone, positions, time);
}

std::optional<JournalRecord> PositionJournal::lost(std::span<const JointPosition> positions,
                                                   JournalCause cause, const JournalTime& time) {
  return stand(JournalKind::kLost, cause, positions, time);
}

std::optional<JournalRecord> PositionJournal::close(std::span<const JointPosition> positions,
                                                    const JournalTime& time) {
  return stand(JournalKind::kClosed, JournalCause::kNone, positions, time);
}

bool PositionJournal::overdue(Instant now) const {
  const auto* oldest =
      std::ranges::find_if(claims_, [&](const Claim& claim) { return claim.sequence > durable_; });
  return oldest != claims_.end() && now - oldest->written > kOverdue;
}

void PositionJournal::durable(std::uint64_t sequence) {
  durable_ = std::max(durable_, sequence);
  std::size_t older = 0;
  while (older + 1 < claims_.size() && claims_[older + 1].sequence <= durable_) ++older;
  claims_.drop_front(older);
}

}  // namespace sinew
