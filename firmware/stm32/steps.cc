#include "firmware/stm32/steps.h"

#include <algorithm>

#include "firmware/stm32/board.h"
#include "firmware/stm32/chip.h"
#include "firmware/stm32/pins.h"

namespace sinew::stm32 {
namespace {

constexpr std::uint32_t kPrescaler = 8;
constexpr std::uint32_t kTimerHz = chip::kClockHz / kPrescaler;
constexpr std::uint32_t kTickCounts = kTimerHz / 1000 * Steps::kTick.count();
static_assert(kTickCounts <= 0xFFFF && Steps::kPulsesMax <= 256);  // widths of counter and RCR
constexpr std::uint32_t kTickCycles = kTickCounts * kPrescaler;
/// Cycles between the last pulse of a tick and the next tick: TIM1 must have stopped.
constexpr std::uint32_t kGap = 32;
constexpr std::uint32_t kPulse = chip::kClockHz / 200'000;  // 5 us; slow drivers need 2.5

constexpr std::uint32_t kEnabled = 1;                 // CR1: CEN
constexpr std::uint32_t kOnePulse = 1U << 3;          // CR1: OPM
constexpr std::uint32_t kPreload = 1U << 7;           // CR1: ARPE
constexpr std::uint32_t kLoadNow = 1;                 // EGR: UG
constexpr std::uint32_t kStartedByTim4 = 0b011'0110;  // SMCR: TS = ITR3, SMS = trigger mode
constexpr std::uint32_t kCountsTim1 = 0b000'0111;     // SMCR: TS = ITR0, SMS = external clock

Timer& tim1() {
  return chip::tim1();
}

}  // namespace

void Steps::start() {
  set_output(board::kDirection, false);
  chip::set_pin(board::kStep.port, board::kStep.pin, chip::Pin::kFunction, chip::kTimer1Function);

  tim1().psc = kPrescaler - 1;
  tim1().ccmr1 = 0b111U << 4 | 1U << 3;  // PWM mode 2: the pulse ends the period; preloaded
  tim1().ccr1 = kTickCounts;
  tim1().arr = kTickCounts;
  tim1().ccer = 1;
  tim1().bdtr = 1U << 15;    // MOE
  tim1().cr2 = 0b100U << 4;  // TRGO: the pulses
  tim1().cr1 = kPreload | kOnePulse | 1U << 2;
  tim1().egr = kLoadNow;

  tim3().smcr = kCountsTim1;
  tim3().arr = 0xFFFF;
  tim3().cr1 = kEnabled;

  tim4().psc = kPrescaler - 1;
  tim4().arr = kTickCounts - 1;
  tim4().cr2 = 0b010U << 4;  // TRGO: its update
  tim4().egr = kLoadNow;
  tim4().sr = 0;
  tim4().dier = 1;
  enable(Line::kTim4, 1);
  tim4().cr1 = kEnabled;
}

void Steps::go_to(std::int64_t count) {
  const InterruptsOff off;
  // What a tick cannot make is not owed: it would run on behind a stop.
  wanted_ = std::clamp<std::int64_t>(count, planned_ - kPulsesMax, planned_ + kPulsesMax);
}

std::int64_t Steps::made() const {
  const InterruptsOff off;
  return made_ + (running_ < 0 ? -1 : 1) * counted();
}

std::uint16_t Steps::counted() const {
  return static_cast<std::uint16_t>(tim3().cnt - counted_);
}

/// What TIM3 has counted belongs to the tick that ran.
void Steps::account() {
  const std::uint16_t pulses = counted();
  made_ += (running_ < 0 ? -1 : 1) * pulses;
  counted_ = static_cast<std::uint16_t>(counted_ + pulses);
}

void Steps::stop() {
  const InterruptsOff off;
  tim1().smcr = 0;
  // A pulse that has begun keeps its length: it is counted, so it must be made.
  for (int i = 0; i < 200 && level(board::kStep); ++i) {
  }
  tim1().cr1 &= ~kEnabled;
  tim1().egr = kLoadNow;
  account();
  running_ = loaded_ = 0;
  wanted_ = planned_ = made_;
}

void Steps::on_tick() {
  tim4().sr = 0;
  account();
  running_ = loaded_;
  const std::int64_t left = wanted_ - planned_;
  auto pulses = static_cast<std::int32_t>(std::clamp<std::int64_t>(left, -kPulsesMax, kPulsesMax));
  if (pulses != 0 && (pulses < 0) != backwards_) {
    // The direction changes in a tick without pulses, and the one behind it is the first.
    if (running_ == 0) {
      backwards_ = pulses < 0;
      set_output(board::kDirection, backwards_);
    } else {
      pulses = 0;
    }
  }
  load(pulses);
}

void Steps::load(std::int32_t pulses) {
  planned_ += pulses;
  loaded_ = pulses;
  if (pulses == 0) {
    tim1().smcr = 0;
    return;
  }
  const auto count = static_cast<std::uint32_t>(pulses < 0 ? -pulses : pulses);
  // As fine as its 16 bits allow: what a tick cannot be divided into evenly is left at its end.
  std::uint32_t prescaler = kPrescaler;
  while (prescaler > 1 && kTickCycles / count / (prescaler / 2) <= 0xFFFF) prescaler /= 2;
  const std::uint32_t period = (kTickCycles - kGap) / count / prescaler;
  tim1().psc = prescaler - 1;
  tim1().arr = period - 1;
  tim1().ccr1 = period - std::min(kPulse / prescaler, period / 2);
  tim1().rcr = count - 1;
  // While TIM1 runs it takes these over by itself, when its last pulse is made.
  if (running_ == 0) tim1().egr = kLoadNow;
  tim1().smcr = kStartedByTim4;
}

}  // namespace sinew::stm32
