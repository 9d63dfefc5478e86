#include "sinew/devices/lsc/lsc_device_bus_limits.h"

namespace sinew {
namespace {

constexpr std::size_t kWritten = 13;  // bytes of command 27
constexpr std::uint8_t kCelsius = 30;

std::uint16_t word(const lsc::Parameters& bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] | bytes[at + 1] << 8);
}

void push_word(lsc::Parameters& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
  bytes.push_back(static_cast<std::uint8_t>(value >> 8));
}

}  // namespace

std::optional<std::pair<std::uint8_t, BusServoLimits>> read_limits(const lsc::Parameters& bytes) {
  if (bytes.size() != kWritten) return std::nullopt;
  const BusServoLimits limits{word(bytes, 1), word(bytes, 3), word(bytes, 5), word(bytes, 7),
                              word(bytes, 9), bytes[11],      bytes[12]};
  const bool ordered = limits.position_min < limits.position_max && limits.position_max <= 1000 &&
                       limits.millivolts_min < limits.millivolts_max;
  if (!ordered) return std::nullopt;
  return std::pair{bytes[0], limits};
}

lsc::Parameters written_info(std::uint8_t id, const BusServoLimits& limits,
                             const BusServoSenses& senses) {
  lsc::Parameters bytes;
  bytes.push_back(id);
  push_word(bytes, limits.position_min);
  push_word(bytes, limits.position_max);
  push_word(bytes, limits.millivolts_min);
  push_word(bytes, limits.millivolts_max);
  push_word(bytes, limits.celsius_max);
  bytes.push_back(limits.led);
  bytes.push_back(limits.led_warnings);
  bytes.push_back(static_cast<std::uint8_t>(senses.offset));
  push_word(bytes, static_cast<std::uint16_t>(senses.position));
  bytes.push_back(kCelsius);
  push_word(bytes, senses.millivolts);
  return bytes;
}

}  // namespace sinew
