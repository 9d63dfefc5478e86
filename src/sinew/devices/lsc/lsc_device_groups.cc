#include "sinew/devices/lsc/lsc_device_groups.h"

#include <algorithm>
#include <utility>

namespace sinew {

const LscGroups::Group* LscGroups::find(std::uint8_t number) const {
  for (const Group& group : groups_) {
    if (group.number == number) return &group;
  }
  return nullptr;
}

LscGroups::Group* LscGroups::find(std::uint8_t number) {
  for (Group& group : groups_) {
    if (group.number == number) return &group;
  }
  return nullptr;
}

bool LscGroups::store(std::uint8_t group, std::size_t index, const lsc::Move& action) {
  if (group > kGroupMax || index >= kActions) return false;
  Group* held = find(group);
  if (held == nullptr) {
    if (groups_.full()) return false;
    groups_.push_back({group, 100, {}});
    held = &groups_.back();
  }
  if (index == 0) held->actions.clear();
  // Actions come in order; one that was lost leaves no hole that would be run as nonsense.
  if (index != held->actions.size()) return false;
  held->actions.push_back(action);
  return true;
}

void LscGroups::erase(std::uint8_t group) {
  if (running_ && group_ == group) running_ = false;
  Group* held = find(group);
  if (held == nullptr) return;
  *held = groups_.back();
  groups_.pop_back();
}

void LscGroups::erase_all() {
  running_ = false;
  groups_.clear();
}

void LscGroups::set_speed(std::uint8_t group, std::uint16_t percent) {
  for (Group& held : groups_) {
    if (group == lsc::kAllGroups || held.number == group) held.percent = percent;
  }
}

void LscGroups::forget_speeds() {
  set_speed(lsc::kAllGroups, 100);
}

bool LscGroups::run(std::uint8_t group, std::uint16_t times, Instant now) {
  const Group* held = find(group);
  if (held == nullptr || held->actions.empty()) return false;
  running_ = true;
  group_ = group;
  times_ = times;
  rounds_left_ = times;
  place_ = 0;
  due_ = now;
  return true;
}

bool LscGroups::stop() {
  return std::exchange(running_, false);
}

std::optional<Instant> LscGroups::due() const {
  if (!running_) return std::nullopt;
  return due_;
}

std::optional<lsc::Move> LscGroups::next() {
  const Group* held = find(group_);
  if (!running_ || held == nullptr) return std::nullopt;
  if (place_ >= held->actions.size()) {
    place_ = 0;
    if (times_ != 0 && --rounds_left_ == 0) {
      running_ = false;
      return std::nullopt;
    }
  }
  lsc::Move action = held->actions[place_++];
  // A group for ever whose actions take no time would never let time pass.
  const std::uint32_t percent = std::max<std::uint32_t>(held->percent, 1);
  const std::uint32_t time = std::max<std::uint32_t>(action.time_ms * 100U / percent, 20U);
  action.time_ms = static_cast<std::uint16_t>(std::min<std::uint32_t>(time, 0xFFFF));
  due_ += std::chrono::milliseconds(time);
  return action;
}

namespace {

void push_word(LscGroups::Memory& memory, std::uint16_t value) {
  memory.push_back(static_cast<std::uint8_t>(value & 0xFF));
  memory.push_back(static_cast<std::uint8_t>(value >> 8));
}

/// Takes numbers off the front; what is missing reads as 0, and `whole` is false from then on.
struct MemoryReader {
  std::span<const std::uint8_t> bytes;
  bool whole = true;

  std::uint8_t byte() {
    if (bytes.empty()) {
      whole = false;
      return 0;
    }
    const std::uint8_t first = bytes.front();
    bytes = bytes.subspan(1);
    return first;
  }
  std::uint16_t word() {
    const std::uint8_t low = byte();
    return static_cast<std::uint16_t>(low | byte() << 8);
  }
};

std::optional<lsc::Move> read_action(MemoryReader& reader) {
  lsc::Move action{.time_ms = reader.word(), .servos = {}};
  const std::uint8_t servos = reader.byte();
  if (servos > lsc::kServosMax) return std::nullopt;
  for (std::uint8_t i = 0; i < servos; ++i) {
    const std::uint8_t id = reader.byte();
    action.servos.push_back({id, reader.word()});
  }
  return reader.whole ? std::optional(action) : std::nullopt;
}

}  // namespace

LscGroups::Memory LscGroups::memory() const {
  Memory memory;
  memory.push_back(static_cast<std::uint8_t>(groups_.size()));
  for (const Group& group : groups_) {
    memory.push_back(group.number);
    memory.push_back(static_cast<std::uint8_t>(group.actions.size()));
    for (const lsc::Move& action : group.actions) {
      push_word(memory, action.time_ms);
      memory.push_back(static_cast<std::uint8_t>(action.servos.size()));
      for (const lsc::ServoValue& servo : action.servos) {
        memory.push_back(servo.id);
        push_word(memory, servo.value);
      }
    }
  }
  return memory;
}

bool LscGroups::set_memory(std::span<const std::uint8_t> bytes) {
  erase_all();
  MemoryReader reader{bytes};
  const std::uint8_t groups = reader.byte();
  bool fits = true;
  for (std::uint8_t i = 0; i < groups && fits; ++i) {
    const std::uint8_t number = reader.byte();
    const std::uint8_t actions = reader.byte();
    fits = !has(number);
    for (std::uint8_t k = 0; k < actions && fits; ++k) {
      const auto action = read_action(reader);
      fits = action && store(number, k, *action);
    }
  }
  fits = fits && reader.whole && reader.bytes.empty();
  if (!fits) erase_all();
  return fits;
}

}  // namespace sinew
