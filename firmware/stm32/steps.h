#pragma once

#include <chrono>
#include <cstdint>

namespace sinew::stm32 {

/// Step and direction of one motor, by timers alone: pulses never wait for the processor.
///
/// TIM4 cuts time into ticks. Its update starts TIM1 by hardware, which makes the pulses of a tick,
/// evenly, and stops by itself (one-pulse mode with its repetition counter). The interrupt of each
/// tick loads the next one. TIM3 counts the pulses. TIM1 counts the processor's clock, or as much
/// of it as its 16 bits allow; the rest of a tick that is no whole number of its counts comes at
/// the end: no step is more than 3 us early, and none is late.
///
/// Between two ticks with pulses of different direction there is one without, so that the
/// direction stands for a tick before and behind.
class Steps {
 public:
  static constexpr std::chrono::milliseconds kTick{4};
  /// Pulses of a tick, at most: 40,000 a second.
  static constexpr std::int32_t kPulsesMax = 160;

  void start();
  /// The count to reach, evenly, within the next tick; called once a tick, at any time of it.
  void go_to(std::int64_t count);
  /// No further pulse begins. What was not made is not made up for.
  void stop();
  /// Pulses made since start, signed.
  std::int64_t made() const;

  /// From the interrupt of TIM4: a tick begins.
  void on_tick();

 private:
  void load(std::int32_t pulses);
  std::uint16_t counted() const;
  void account();

  std::int64_t wanted_ = 0;
  std::int64_t planned_ = 0;  ///< handed to the timers
  std::int64_t made_ = 0;     ///< but for what TIM3 has counted since `counted_`
  std::uint16_t counted_ = 0;
  std::int32_t running_ = 0;  ///< pulses of the tick that runs, signed
  std::int32_t loaded_ = 0;   ///< of the next one
  bool backwards_ = false;
};

}  // namespace sinew::stm32
