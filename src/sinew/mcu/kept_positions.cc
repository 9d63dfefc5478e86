#include "sinew/mcu/kept_positions.h"

namespace sinew {
namespace mcu {
namespace {

constexpr uint32_t kMark = 0x53494E57;

uint32_t check_of(const KeptPositions::Slot& slot) {
  uint32_t sum = slot.mark + slot.number * 3 + slot.starts;
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    // Each word at its own place in the sum: two that changed places do not pass.
    sum = (sum << 1 | sum >> 31) + static_cast<uint32_t>(slot.steps[i]);
  }
  sum += static_cast<uint32_t>(slot.moving) << 8 | static_cast<uint32_t>(slot.uncertain) << 16;
  return ~sum;
}

bool is_whole(const KeptPositions::Slot& slot) {
  return slot.mark == kMark && slot.moving <= 1 && slot.uncertain <= 1 &&
         slot.check == check_of(slot);
}

}  // namespace

const KeptPositions::Slot* KeptPositions::find() {
  const bool first = is_whole(slots[0]);
  const bool second = is_whole(slots[1]);
  if (!first && !second) return nullptr;
  const bool second_is_newer = static_cast<int32_t>(slots[1].number - slots[0].number) > 0;
  last = !first || (second && second_is_newer) ? 1 : 0;
  return &slots[last];
}

void KeptPositions::keep(const Slot& slot) {
  const uint32_t number = slots[last & 1].number + 1;
  last = last == 0 ? 1 : 0;
  Slot& kept = slots[last];
  kept = slot;
  kept.mark = kMark;
  kept.number = number;
  kept.check = check_of(kept);
}

}  // namespace mcu
}  // namespace sinew
