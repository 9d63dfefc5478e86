#include "firmware/emulation/stm32_timers.h"

#include <algorithm>

namespace sinew::emulation {
namespace {

constexpr std::uint32_t kEnabled = 1;
constexpr std::uint32_t kTriggered = 0b011'0110;  // SMCR: ITR3 starts it
constexpr std::uint32_t kCounting = 0b000'0111;   // SMCR: ITR0 is its clock
constexpr std::uint32_t kEncoder = 0b011;         // SMCR: both edges of both inputs
constexpr int kTim4Line = 30;

}  // namespace

Stm32Timers::Stm32Timers(CortexM& core)
    : core_(core), tim1_(*this, 1), tim2_(*this, 2), tim3_(*this, 3), tim4_(*this, 4) {
  reset();
}

void Stm32Timers::reset() {
  values_ = {};
  for (Values& timer : values_) timer[kArr] = 0xFFFF;
  if (high_) on_pulse(core_.now(), false);
  high_ = runs_ = false;
}

void Stm32Timers::turn_encoder(std::int32_t counts) {
  Values& timer = values_[2];
  const bool counted = timer[kSmcr] == kEncoder && (timer[kCr1] & kEnabled) != 0;
  if (counted) timer[kCnt] = (timer[kCnt] + static_cast<std::uint32_t>(counts - encoder_)) & 0xFFFF;
  encoder_ = counts;
}

bool Stm32Timers::step_level() {
  advance(core_.now());
  return high_;
}

std::uint32_t Stm32Timers::read(int number, std::uint32_t offset) {
  return values_[number].word[offset / 4];
}

void Stm32Timers::write(int number, std::uint32_t offset, std::uint32_t value) {
  Values& timer = values_[number];
  const bool was_on = (timer[kCr1] & kEnabled) != 0;
  if (offset == kSr) {
    timer[kSr] &= value;  // flags are cleared by writing 0
    return;
  }
  if (offset == kEgr) {
    if (number == 1) load_tim1();
    return;
  }
  timer.word[offset / 4] = value;
  if (offset != kCr1) return;
  const bool is_on = (value & kEnabled) != 0;
  if (number == 1 && was_on && !is_on) runs_ = false;
  if (number == 4 && !was_on && is_on) {
    next_update_ = core_.now() + Cycles{timer[kArr] + 1} * (timer[kPsc] + 1);
  }
}

/// An update event: the preloaded values count, and the counter stands at 0.
void Stm32Timers::load_tim1() {
  const Values& timer = values_[1];
  period_ = (timer[kArr] + 1) * (timer[kPsc] + 1);
  compare_ = timer[kCcr1] * (timer[kPsc] + 1);
  repetitions_ = timer[kRcr];
  if (high_) {
    high_ = false;
    on_pulse(core_.now(), false);
  }
}

std::optional<Cycles> Stm32Timers::next_event() const {
  if ((values_[4][kCr1] & kEnabled) == 0) return std::nullopt;
  return next_update_;
}

/// The next edge of TIM1 that is not later than `until`.
bool Stm32Timers::edge_tim1(Cycles until) {
  if (!runs_) return false;
  const Cycles at = period_began_ + (high_ ? period_ : compare_);
  if (at > until) return false;
  high_ = !high_;
  on_pulse(at, high_);
  if (high_) {
    Values& counter = values_[3];
    const bool counts = counter[kSmcr] == kCounting && (counter[kCr1] & kEnabled) != 0;
    if (counts) counter[kCnt] = (counter[kCnt] + 1) & counter[kArr];
    return true;
  }
  period_began_ = at;
  if (--periods_left_ == 0) {
    runs_ = false;
    values_[1][kCr1] &= ~kEnabled;
    load_tim1();
  }
  return true;
}

void Stm32Timers::update_tim4(Cycles at) {
  Values& timer = values_[4];
  timer[kSr] |= 1;
  if ((timer[kDier] & 1) != 0) core_.raise(kTim4Line);
  next_update_ = at + Cycles{timer[kArr] + 1} * (timer[kPsc] + 1);
  if (values_[1][kSmcr] != kTriggered || runs_) return;
  runs_ = true;
  values_[1][kCr1] |= kEnabled;
  period_began_ = at;
  periods_left_ = repetitions_ + 1;
}

void Stm32Timers::advance(Cycles now) {
  for (;;) {
    const bool ticks = (values_[4][kCr1] & kEnabled) != 0 && next_update_ <= now;
    if (edge_tim1(ticks ? next_update_ : now)) continue;
    if (!ticks) return;
    update_tim4(next_update_);
  }
}

}  // namespace sinew::emulation
