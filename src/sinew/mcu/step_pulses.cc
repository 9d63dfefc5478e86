#include "sinew/mcu/step_pulses.h"

#include "sinew/mcu/interrupts.h"

namespace sinew {
namespace mcu {

void StepPulses::put(const int32_t* ways) {
  Slice slice = {};
  slice.backwards = next_.backwards;
  bool moves = false;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    const uint8_t bit = static_cast<uint8_t>(1 << i);
    const int32_t way = ways[i] + rests_[i];
    const bool back = way < 0;
    const uint32_t length = static_cast<uint32_t>(back ? -way : way);
    const uint16_t rate = static_cast<uint16_t>(length >> kTickBits);
    const int8_t rest = static_cast<int8_t>(length & (kTicks - 1));
    rests_[i] = static_cast<int8_t>(back ? -rest : rest);
    next_steps_[i] = 0;
    if (rate == 0) continue;
    moves = true;
    if (back != ((slice.backwards & bit) != 0)) {
      slice.backwards = static_cast<uint8_t>(slice.backwards ^ bit);
      // The way back to the last step's place is what is left to the next one.
      end_phases_[i] = static_cast<uint16_t>(~end_phases_[i]);
    }
    slice.rates[i] = rate;
    const uint32_t sum = end_phases_[i] + (static_cast<uint32_t>(rate) << kTickBits);
    end_phases_[i] = static_cast<uint16_t>(sum);
    const int8_t made = static_cast<int8_t>(sum >> 16);
    next_steps_[i] = static_cast<int8_t>(back ? -made : made);
    steps_[i] += next_steps_[i];
  }
  const InterruptsOff off;
  next_ = slice;
  next_moves_ = moves;
  put_ = true;
}

void StepPulses::freeze() {
  const InterruptsOff off;
  const uint8_t left = static_cast<uint8_t>((kTicks - tick_) & (kTicks - 1));
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    if (put_) steps_[i] -= next_steps_[i];
    const uint32_t sum = phases_[i] + static_cast<uint32_t>(now_.rates[i]) * left;
    const int32_t lost = static_cast<int32_t>(sum >> 16);
    steps_[i] += (now_.backwards >> i & 1) != 0 ? lost : -lost;
    now_.rates[i] = 0;
    next_steps_[i] = 0;
    rests_[i] = 0;
    phases_[i] = end_phases_[i] = 0x8000;
  }
  next_.backwards = now_.backwards;
  put_ = moves_ = false;
}

void StepPulses::set_steps(uint8_t axis, int32_t steps) {
  const InterruptsOff off;
  steps_[axis] = steps;
}

}  // namespace mcu
}  // namespace sinew
