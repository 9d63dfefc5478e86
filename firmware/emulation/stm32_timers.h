#pragma once

#include <functional>

#include "firmware/emulation/cortex_m.h"

namespace sinew::emulation {

/// The timers of an STM32 as far as the boards use them: TIM4 counts up and triggers, TIM1 makes a
/// number of pulses on channel 1 when it is triggered, TIM3 counts them, and TIM2 counts the edges
/// of an encoder.
class Stm32Timers {
 public:
  explicit Stm32Timers(CortexM& core);

  Peripheral& tim1() { return tim1_; }
  Peripheral& tim2() { return tim2_; }
  Peripheral& tim3() { return tim3_; }
  Peripheral& tim4() { return tim4_; }
  void reset();

  /// The encoder on TIM2 is at `counts` now; its counter has 16 bits of it.
  void turn_encoder(std::int32_t counts);
  /// Level of channel 1 of TIM1, now.
  bool step_level();
  /// Channel 1 of TIM1 changes, at exactly that cycle.
  std::function<void(Cycles, bool high)> on_pulse = [](Cycles, bool) {};

 private:
  enum Offset : std::uint32_t {
    kCr1 = 0x00,
    kCr2 = 0x04,
    kSmcr = 0x08,
    kDier = 0x0C,
    kSr = 0x10,
    kEgr = 0x14,
    kCcmr1 = 0x18,
    kCcer = 0x20,
    kCnt = 0x24,
    kPsc = 0x28,
    kArr = 0x2C,
    kRcr = 0x30,
    kCcr1 = 0x34,
    kBdtr = 0x44,
  };
  class Block : public Peripheral {
   public:
    Block(Stm32Timers& timers, int number) : timers_(timers), number_(number) {}
    std::uint32_t read(std::uint32_t offset) override { return timers_.read(number_, offset); }
    void write(std::uint32_t offset, std::uint32_t value) override {
      timers_.write(number_, offset, value);
    }
    std::optional<Cycles> next_event() const override {
      return number_ == 4 ? timers_.next_event() : std::nullopt;
    }
    void advance(Cycles now) override { timers_.advance(now); }

   private:
    Stm32Timers& timers_;
    int number_;
  };
  struct Values {
    std::array<std::uint32_t, 20> word{};
    std::uint32_t& operator[](Offset offset) { return word[offset / 4]; }
    std::uint32_t operator[](Offset offset) const { return word[offset / 4]; }
  };

  std::uint32_t read(int number, std::uint32_t offset);
  void write(int number, std::uint32_t offset, std::uint32_t value);
  std::optional<Cycles> next_event() const;
  void advance(Cycles now);
  void update_tim4(Cycles at);
  void load_tim1();
  bool edge_tim1(Cycles until);

  CortexM& core_;
  Block tim1_, tim2_, tim3_, tim4_;
  std::array<Values, 5> values_;  ///< by number
  std::int32_t encoder_ = 0;

  bool runs_ = false;  ///< TIM1
  Cycles period_began_ = 0;
  bool high_ = false;
  std::uint32_t periods_left_ = 0;
  std::uint32_t period_ = 1, compare_ = 1, repetitions_ = 0;  ///< what it works with
  Cycles next_update_ = 0;                                    ///< of TIM4
};

}  // namespace sinew::emulation
