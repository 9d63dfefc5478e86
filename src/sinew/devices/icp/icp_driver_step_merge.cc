#include "sinew/devices/icp/icp_driver_step_merge.h"

#include <cstdlib>

#include "sinew/core/assert.h"

namespace sinew {

StepMerge::StepMerge(const Counts& counts) {
  // Products of a count and the total then fit 64 bits.
  constexpr std::int64_t kCountMax = (std::int64_t{1} << 29) - 1;
  for (std::size_t i = 0; i < kLegs; ++i) {
    SINEW_ASSERT(counts[i] <= kCountMax && counts[i] >= -kCountMax);
    legs_[i].count = std::abs(counts[i]);
    legs_[i].direction = counts[i] < 0 ? -1 : 1;
    total_ += legs_[i].count;
  }
  for (Leg& leg : legs_) set_window(leg);
}

void StepMerge::set_window(Leg& leg) const {
  if (leg.made == leg.count) return;
  leg.opens = leg.made * total_ / leg.count;
  leg.closes = ((leg.made + 1) * total_ + leg.count - 1) / leg.count;
}

std::size_t StepMerge::pick() const {
  SINEW_ASSERT(!done());
  std::size_t best = kLegs;
  for (std::size_t i = 0; i < kLegs; ++i) {
    const Leg& leg = legs_[i];
    if (leg.made == leg.count || leg.opens > made_) continue;
    if (best == kLegs || leg.closes < legs_[best].closes) best = i;
  }
  SINEW_ASSERT(best < kLegs);
  return best;
}

StepMerge::Step StepMerge::next() const {
  const std::size_t leg = pick();
  return {leg, legs_[leg].direction};
}

void StepMerge::advance() {
  Leg& leg = legs_[pick()];
  ++leg.made;
  ++made_;
  set_window(leg);
}

}  // namespace sinew
