#pragma once

#include <stdint.h>

namespace sinew {
namespace mcu {

constexpr uint8_t kArmAxes = 5;

/// Makes steps of five motors: each millisecond (a slice) has 32 ticks, and an accumulator of 16
/// bits per axis says at which of them it steps. Steps of a slice are spread evenly, to one tick
/// (31 us), and a fraction of a step is kept from slice to slice. @rt
///
/// put() is called once a slice by the slice's interrupt, tick() by an interrupt that may break
/// into it.
class StepPulses {
 public:
  static constexpr uint8_t kTickBits = 5;
  static constexpr uint8_t kTicks = 1 << kTickBits;  ///< per ms

  /// One tick: the axes that step now, a bit each. Directions have to be on the pins first.
  inline uint8_t tick() {
    if (tick_ == 0) begin_slice();
    tick_ = static_cast<uint8_t>((tick_ + 1) & (kTicks - 1));
    uint8_t steps = 0;
    if (advance(0)) steps |= 1;
    if (advance(1)) steps |= 2;
    if (advance(2)) steps |= 4;
    if (advance(3)) steps |= 8;
    if (advance(4)) steps |= 16;
    return steps;
  }
  /// The last tick() began a slice: directions may have changed, and the next slice is due.
  bool slice_began() const { return tick_ == 1; }
  /// Axes whose steps are backwards, a bit each.
  uint8_t backwards() const { return now_.backwards; }

  /// The next slice: how far each axis goes, 65536ths of a step.
  /// @pre |ways| < 2^21 (32 steps); the slice before has begun
  void put(const int32_t* ways);

  /// No pulse from the next tick on. Steps that were put and not made are taken back from made().
  void freeze();

  /// Steps, once the last slice that was put is over.
  int32_t steps(uint8_t axis) const { return steps_[axis]; }
  /// Counts from another step on; where no pulses are under way.
  void set_steps(uint8_t axis, int32_t steps);
  /// Slices that began before put() had given them.
  uint16_t late() const { return late_; }

 private:
  struct Slice {
    uint16_t rates[kArmAxes];  ///< 65536ths of a step per tick
    uint8_t backwards;
  };

  inline bool advance(uint8_t axis) {
    const uint16_t rate = now_.rates[axis];
    const uint16_t sum = static_cast<uint16_t>(phases_[axis] + rate);
    phases_[axis] = sum;
    return sum < rate;
  }
  /// What was put becomes what is made. In line, as tick() is: a call in an interrupt saves many
  /// registers.
  inline void begin_slice() {
    if (!put_) {
      if (moves_) ++late_;
      for (uint8_t i = 0; i < kArmAxes; ++i) now_.rates[i] = 0;
      return;
    }
    uint8_t turned = static_cast<uint8_t>(now_.backwards ^ next_.backwards);
    for (uint8_t i = 0; i < kArmAxes; ++i, turned = static_cast<uint8_t>(turned >> 1)) {
      now_.rates[i] = next_.rates[i];
      if ((turned & 1) != 0) phases_[i] = static_cast<uint16_t>(~phases_[i]);
    }
    now_.backwards = next_.backwards;
    moves_ = next_moves_;
    put_ = false;
  }

  Slice now_ = {};
  uint16_t phases_[kArmAxes] = {0x8000, 0x8000, 0x8000, 0x8000, 0x8000};
  uint8_t tick_ = 0;
  Slice next_ = {};
  volatile bool put_ = false;
  uint16_t late_ = 0;
  bool moves_ = false;  ///< the slice under way has a rate
  bool next_moves_ = false;

  // What put() counts on.
  uint16_t end_phases_[kArmAxes] = {0x8000, 0x8000, 0x8000, 0x8000, 0x8000};
  int8_t next_steps_[kArmAxes] = {};  ///< of the slice that was put last
  int8_t rests_[kArmAxes] = {};       ///< ways below a rate's unit, for the next slice
  int32_t steps_[kArmAxes] = {};
};

}  // namespace mcu
}  // namespace sinew
