#pragma once

#include <array>
#include <string_view>

#include "sinew/devices/axis_link/axis_link_wire.h"
#include "sinew/devices/axis_registers/axis_registers_wire.h"

/// What the axis boards of both wires tell, in names for machines.
namespace sinew {

template <class Status>
struct AxisFlagWord {
  bool Status::* flag;
  std::string_view name;
};

}  // namespace sinew

namespace sinew::axis_registers {

/// In the order of the bits of DIAG_STATUS.
inline constexpr std::array kStatusWords = std::to_array<AxisFlagWord<Status>>({
    {&Status::motor_ok, "motor_ok"},
    {&Status::sensor_ok, "sensor_ok"},
    {&Status::communication_ok, "communication_ok"},
    {&Status::position_ok, "position_ok"},
    {&Status::homed, "homed"},
    {&Status::moving, "moving"},
    {&Status::end_stop, "end_stop"},
    {&Status::emergency_stop, "emergency_stop"},
});

constexpr std::string_view name(Register which) {
  constexpr std::array<std::string_view, 7> kNames{
      "homing",         "move_angle",   "diag_control",   "diag_status",
      "emergency_stop", "enable_motor", "firmware_update"};
  return kNames[static_cast<std::size_t>(which) % kNames.size()];
}

constexpr std::string_view name(Verdict verdict) {
  constexpr std::array<std::string_view, 9> kNames{"ok",       "start_byte", "frame_id",
                                                   "slave_id", "register",   "size",
                                                   "end_byte", "crc",        "operation"};
  return kNames[static_cast<std::size_t>(verdict) % kNames.size()];
}

}  // namespace sinew::axis_registers

namespace sinew::axis_link {

inline constexpr std::array kStateWords = std::to_array<AxisFlagWord<State>>({
    {&State::motor_ok, "motor_ok"},
    {&State::sensor_ok, "sensor_ok"},
    {&State::communication_ok, "communication_ok"},
    {&State::position_ok, "position_ok"},
    {&State::homed, "homed"},
    {&State::homing, "homing"},
    {&State::moving, "moving"},
    {&State::end_stop, "end_stop"},
    {&State::emergency_stopped, "emergency_stop"},
});

constexpr std::string_view name(Mode mode) {
  constexpr std::array<std::string_view, kModeLast + 1> kNames{
      "read",        "hold",           "track",       "move",         "home",      "cancel",
      "stop",        "emergency_stop", "release",     "clear_faults", "self_test", "hello",
      "read_health", "read_setup",     "write_setup", "store_setup"};
  return kNames[static_cast<std::size_t>(mode) % kNames.size()];
}

constexpr std::string_view name(Verdict verdict) {
  constexpr std::array<std::string_view, 7> kNames{
      "accepted",          "not_homed", "out_of_limits", "faulted",
      "emergency_stopped", "busy",      "no_session"};
  return kNames[static_cast<std::size_t>(verdict) % kNames.size()];
}

}  // namespace sinew::axis_link
