#include "sinew/sim/link_fault.h"

#include <algorithm>

#include "sinew/core/assert.h"

namespace sinew::sim {
namespace {

/// Odd, so that the two directions of one seed have nothing in common.
constexpr std::uint64_t kLaneStride = 0xD1342543DE82EF95ULL;
constexpr std::uint64_t kTimedStride = 0xA0761D6478BD642FULL;

}  // namespace

TimedByteFaults::TimedByteFaults(const LinkFaultSpec& spec)
    : random_{SplitMix64(spec.seed ^ kTimedStride),
              SplitMix64(spec.seed ^ kTimedStride ^ kLaneStride)} {
  for (const TimedByteFault& fault : spec.timed) entries_.push_back({fault});
}

std::optional<Duration> TimedByteFaults::strikes(TimedByteFault::Kind kind,
                                                 std::optional<LinkDirection> direction,
                                                 Duration since) {
  std::optional<Duration> struck;
  for (Entry& entry : entries_) {
    const TimedByteFault& fault = entry.fault;
    const bool this_way = !fault.only || !direction || *fault.only == *direction;
    if (fault.kind != kind || !this_way || entry.spent) continue;
    // Its draw is made at every moment: what befalls the n-th byte hangs on n alone.
    SplitMix64& random = random_[direction == LinkDirection::kToHost ? 1 : 0];
    const bool hit = fault.once || random.uniform(0, 1) < fault.chance;
    if (!hit || since < fault.at || (fault.until && since >= *fault.until)) continue;
    entry.spent = fault.once;
    struck = std::max(struck.value_or(Duration::zero()), fault.delay_time);
  }
  return struck;
}

LinkFaults::LinkFaults(const LinkFaultSpec& spec, Instant start)
    : spec_(spec),
      timed_(spec),
      start_(start),
      lanes_{Lane(SplitMix64(spec.seed).bits()), Lane(SplitMix64(spec.seed ^ kLaneStride).bits())} {
}

bool LinkFaults::is_cut(LinkDirection direction, Instant now) const {
  return std::ranges::any_of(spec_.cuts, [&](const LinkCut& cut) {
    if (cut.only && *cut.only != direction) return false;
    const Duration since = now - start_ - cut.at;
    return since >= Duration::zero() && (!cut.lasts || since < *cut.lasts);
  });
}

void LinkFaults::enqueue(Lane& lane, std::uint8_t byte, Instant arrives) {
  if (lane.size == kCapacity) {
    ++lane.counts.cut;
    return;
  }
  lane.ring[(lane.first + lane.size) % kCapacity] = {arrives, byte};
  ++lane.size;
}

void LinkFaults::push(LinkDirection direction, std::span<const std::uint8_t> bytes, Instant now) {
  Lane& lane = lanes_[static_cast<std::size_t>(direction)];
  const ByteFaults& faults = spec_.bytes[static_cast<std::size_t>(direction)];
  using Kind = TimedByteFault::Kind;
  const auto strikes = [&](Kind kind) { return timed_.strikes(kind, direction, now - start_); };
  for (std::uint8_t byte : bytes) {
    // Every byte costs the same draws, whatever befalls it.
    const bool drop = lane.random.uniform(0, 1) < faults.drop;
    const bool duplicate = lane.random.uniform(0, 1) < faults.duplicate;
    const bool flip = lane.random.uniform(0, 1) < faults.flip;
    const bool delay = lane.random.uniform(0, 1) < faults.delay;
    const std::uint64_t bit = lane.random.bits() % 8;
    ++lane.counts.in;
    if (is_cut(direction, now)) {
      ++lane.counts.cut;
      continue;
    }
    const bool drop_now = strikes(Kind::kDrop).has_value();
    if (drop || drop_now) {
      ++lane.counts.dropped;
      continue;
    }
    const bool flip_now = strikes(Kind::kFlip).has_value();
    if (flip || flip_now) {
      byte = static_cast<std::uint8_t>(byte ^ 1U << bit);
      ++lane.counts.flipped;
    }
    const auto delay_now = strikes(Kind::kDelay);
    if (delay || delay_now) ++lane.counts.delayed;
    const Duration late = std::max(delay ? faults.delay_time : Duration::zero(),
                                   delay_now.value_or(Duration::zero()));
    const Instant arrives = now + late;
    // What comes behind a late byte is late with it.
    lane.last_arrival = std::max(lane.last_arrival, arrives);
    enqueue(lane, byte, lane.last_arrival);
    const bool duplicate_now = strikes(Kind::kDuplicate).has_value();
    if (!duplicate && !duplicate_now) continue;
    ++lane.counts.duplicated;
    enqueue(lane, byte, lane.last_arrival);
  }
}

std::size_t LinkFaults::take(LinkDirection direction, Instant now, std::span<std::uint8_t> out) {
  Lane& lane = lanes_[static_cast<std::size_t>(direction)];
  std::size_t count = 0;
  while (count < out.size() && lane.size > 0 && lane.ring[lane.first].arrives <= now) {
    out[count++] = lane.ring[lane.first].byte;
    lane.first = (lane.first + 1) % kCapacity;
    --lane.size;
  }
  lane.counts.out += count;
  return count;
}

std::optional<Instant> LinkFaults::next_event() const {
  std::optional<Instant> next;
  for (const Lane& lane : lanes_) {
    if (lane.size == 0) continue;
    const Instant arrives = lane.ring[lane.first].arrives;
    next = next ? std::min(*next, arrives) : arrives;
  }
  return next;
}

const LinkCounts& LinkFaults::counts(LinkDirection direction) const {
  return lanes_[static_cast<std::size_t>(direction)].counts;
}

}  // namespace sinew::sim
