#include "sinew/devices/axis/axis_device_setup.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <type_traits>

#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/wire/crc32c.h"
#include "sinew/wire/little_words.h"

namespace sinew {
namespace {

constexpr std::uint8_t kVersion = 2;  // 1: without joint_node
constexpr std::size_t kChecksum = 4;

/// Every field, in the order of the bytes; this is the one list of them.
template <class Field, class Setup>
constexpr void for_each_field(Setup& setup, Field&& field) {
  field(setup.axis_number);
  auto& axis = setup.axis;
  field(axis.lower);
  field(axis.upper);
  field(axis.limits.velocity);
  field(axis.limits.acceleration);
  field(axis.limits.jerk);
  field(axis.tracking_jerk);
  field(axis.gear_ratio);
  field(axis.backlash);
  field(axis.give);
  field(axis.full_steps_per_turn);
  field(axis.microsteps);
  field(axis.step_rate_max);
  field(axis.encoders.joint);
  field(axis.encoders.joint_node);
  field(axis.encoders.joint_counts_per_turn);
  field(axis.encoders.motor_counts_per_turn);
  field(axis.encoders.gear_ratio);
  field(axis.encoders.speed_max);
  field(axis.encoders.gap_max);
  field(axis.homing.direction);
  field(axis.homing.end_stop_angle);
  field(axis.homing.approach_speed);
  field(axis.homing.slow_speed);
  field(axis.homing.back_off);
  field(axis.homing.back_off_max);
  field(axis.homing.clear_angle);
  field(axis.homing.travel_max);
  field(axis.homing.debounce);
  field(axis.cascade.position_gain);
  field(axis.cascade.velocity_gain);
  field(axis.cascade.integral_gain);
  field(axis.cascade.feed_forward);
  field(axis.cascade.integral_share);
  field(axis.cascade.rate_max);
  field(axis.cascade.dead_band);
  field(axis.supervision.following_error);
  field(axis.supervision.following_time);
  field(axis.supervision.stall_angle);
  field(axis.supervision.stall_time);
  field(axis.supervision.disagreement);
  field(axis.supervision.disagreement_filter);
  field(axis.supervision.supply_min);
  field(axis.supervision.supply_off);
  field(axis.supervision.temperature_max);
  field(axis.supervision.supply_time);
  field(axis.emergency_stop);
  field(axis.position_tolerance);
  auto& registers = setup.registers;
  field(registers.registers.homing);
  field(registers.registers.move_angle);
  field(registers.registers.diag_control);
  field(registers.registers.diag_status);
  field(registers.registers.emergency_stop);
  field(registers.encoding);
  field(registers.slave_id);
  field(registers.zero);
}

/// A field as a whole number of so many bytes.
template <class T>
constexpr std::size_t size_of() {
  if constexpr (std::is_same_v<T, Duration>)
    return 8;
  else
    return sizeof(T);
}
template <class T>
std::uint64_t bits_of(T value) {
  if constexpr (std::is_same_v<T, double>)
    return std::bit_cast<std::uint64_t>(value);
  else if constexpr (std::is_same_v<T, Duration>)
    return static_cast<std::uint64_t>(value.count());
  else
    return static_cast<std::uint64_t>(value);
}
template <class T>
T from_bits(std::uint64_t bits) {
  if constexpr (std::is_same_v<T, double>)
    return std::bit_cast<double>(bits);
  else if constexpr (std::is_same_v<T, Duration>)
    return Duration{static_cast<std::int64_t>(bits)};
  else
    return static_cast<T>(bits);
}

constexpr bool positive(double value) {
  return value > 0;
}

/// No number of an axis is larger; what is counted in 2^-26 fits into 64 bits then.
constexpr double kMost = 1 << 20;

/// What AxisController and the wires assume of their settings; a NaN fails every comparison.
bool is_sound(const AxisSetup& setup) {
  bool numbers = true;
  for_each_field(setup, [&]<class T>(const T& value) {
    if constexpr (std::is_same_v<T, double>) numbers = numbers && std::abs(value) <= kMost;
    if constexpr (std::is_same_v<T, Duration>) {
      numbers = numbers && value >= Duration::zero() && value <= std::chrono::seconds(1);
    }
  });
  const AxisSettings& axis = setup.axis;
  const auto& encoders = axis.encoders;
  const auto& cascade = axis.cascade;
  const auto& homing = axis.homing;
  const auto& supervision = axis.supervision;
  const bool limits = axis.lower < axis.upper && axis_link::to_units(axis.lower) &&
                      axis_link::to_units(axis.upper) && positive(axis.limits.velocity) &&
                      positive(axis.limits.acceleration) && positive(axis.limits.jerk) &&
                      axis.tracking_jerk >= axis.limits.jerk;
  const bool drive = axis.gear_ratio >= 1e-3 && axis.full_steps_per_turn >= 1 &&
                     axis.microsteps >= 1 && positive(axis.step_rate_max) &&
                     axis.step_rate_max <= kStepRateMost && axis.backlash >= 0 && axis.give >= 0;
  const bool sensors = encoders.gear_ratio >= 1e-3 && positive(encoders.speed_max) &&
                       std::abs(encoders.joint_counts_per_turn) >= 1 &&
                       std::abs(encoders.motor_counts_per_turn) >= 1 &&
                       encoders.joint <= JointEncoder::kAs5600 &&
                       (!encoders.joint_node || encoders.joint == JointEncoder::kAs5600);
  const bool loop = cascade.rate_max >= axis.limits.velocity && cascade.position_gain >= 0 &&
                    cascade.velocity_gain >= 0 && cascade.integral_gain >= 0 &&
                    cascade.feed_forward >= 0 && cascade.integral_share >= 0 &&
                    cascade.dead_band >= 0;
  const bool search = std::abs(homing.direction) == 1 && positive(homing.approach_speed) &&
                      positive(homing.slow_speed) && positive(homing.travel_max) &&
                      positive(homing.back_off) && homing.back_off_max >= homing.back_off;
  const bool watch = positive(supervision.following_error) && positive(supervision.stall_angle) &&
                     positive(supervision.disagreement) &&
                     axis.emergency_stop <= EmergencyStopAction::kPowerOff;
  return numbers && setup.axis_number < axis_link::kAxes && limits && drive && sensors && loop &&
         search && watch && setup.registers.encoding <= AngleEncoding::kF32Le;
}

constexpr std::size_t fields_size() {
  std::size_t size = 1;
  AxisSetup setup;
  for_each_field(setup, [&]<class T>(const T&) { size += size_of<T>(); });
  return size;
}
static_assert((fields_size() + 3) / 4 * 4 + kChecksum == kSetupSize);

}  // namespace

SetupBytes encode_setup(const AxisSetup& setup) {
  SetupBytes bytes{kVersion};
  std::size_t place = 1;
  for_each_field(setup, [&]<class T>(const T& value) {
    const std::uint64_t bits = bits_of(value);
    for (std::size_t i = 0; i < size_of<T>(); ++i) {
      bytes[place++] = static_cast<std::uint8_t>(bits >> 8 * i);
    }
  });
  constexpr std::size_t kEnd = kSetupSize - kChecksum;
  put_little_word(bytes, kEnd / 4, crc32c(std::span(bytes).first<kEnd>()));
  return bytes;
}

std::optional<AxisSetup> decode_setup(std::span<const std::uint8_t, kSetupSize> bytes) {
  constexpr std::size_t kEnd = kSetupSize - kChecksum;
  if (crc32c(bytes.first<kEnd>()) != little_word(bytes, kEnd / 4) || bytes[0] != kVersion) {
    return std::nullopt;
  }
  AxisSetup setup;
  std::size_t place = 1;
  for_each_field(setup, [&]<class T>(T& value) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size_of<T>(); ++i) bits |= std::uint64_t{bytes[place++]} << 8 * i;
    value = from_bits<T>(bits);
  });
  if (!is_sound(setup)) return std::nullopt;
  return setup;
}

SetupStore::SetupStore(SetupMemory& memory) : memory_(memory) {
  written_.fill(0xFF);
  for (const int which : {0, 1}) {
    const auto count = count_of(which);
    // Counts go round: the newer one of two that follow each other is ahead by less than half.
    const bool newer = count && (!setup_ || static_cast<std::int32_t>(*count - count_) > 0);
    if (!newer) continue;
    const auto bytes = memory.place(which).first<kSetupSize>();
    const auto setup = decode_setup(bytes);
    if (!setup) continue;
    setup_ = setup;
    count_ = *count;
    newest_ = which;
    std::ranges::copy(bytes, written_.begin());
  }
}

/// Of a copy that is whole.
std::optional<std::uint32_t> SetupStore::count_of(int which) const {
  const auto copy = memory_.place(which);
  if (copy.size() < kCopySize) return std::nullopt;
  if (crc32c(copy.first(kCopySize - 4)) != little_word(copy, kCopySize / 4 - 1))
    return std::nullopt;
  return little_word(copy, kSetupWords);
}

std::optional<std::uint32_t> SetupStore::word(std::size_t index) const {
  if (index >= kSetupWords) return std::nullopt;
  constexpr std::uint32_t kErased = 0xFFFF'FFFF;
  return setup_ ? little_word(memory_.place(newest_), index) : kErased;
}

bool SetupStore::set_word(std::size_t index, std::uint32_t value) {
  if (index >= kSetupWords) return false;
  put_little_word(written_, index, value);
  return true;
}

bool SetupStore::store() {
  if (!decode_setup(written_)) return false;
  std::array<std::uint8_t, kCopySize> copy{};
  std::ranges::copy(written_, copy.begin());
  put_little_word(copy, kSetupWords, count_ + 1);
  put_little_word(copy, kCopySize / 4 - 1, crc32c(std::span(copy).first<kCopySize - 4>()));
  const int which = 1 - newest_;
  if (!memory_.erase(which) || !memory_.append(which, copy)) return false;
  if (!std::ranges::equal(memory_.place(which).first(kCopySize), copy)) return false;
  newest_ = which;
  ++count_;
  setup_ = decode_setup(written_);
  return true;
}

}  // namespace sinew
