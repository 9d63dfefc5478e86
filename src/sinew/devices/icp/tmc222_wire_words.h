#pragma once

#include <array>
#include <string_view>

#include "sinew/devices/icp/tmc222_wire.h"

/// What a TMC222 tells, in words: a name for machines and a text for people.
namespace sinew::tmc222 {

struct FlagWord {
  bool Flags::* flag;
  std::string_view name;
  std::string_view text;
};

inline constexpr std::array kFlagWords = std::to_array<FlagWord>({
    {&Flags::vdd_reset, "vdd_reset", "lost its supply"},
    {&Flags::step_loss, "step_loss", "step loss"},
    {&Flags::electrical_defect, "electrical_defect", "electrical defect"},
    {&Flags::under_voltage, "under_voltage", "supply too low"},
    {&Flags::thermal_shutdown, "thermal_shutdown", "thermal shutdown"},
    {&Flags::thermal_warning, "thermal_warning", "hot"},
    {&Flags::over_current_1, "over_current_1", "over-current in coil 1"},
    {&Flags::over_current_2, "over_current_2", "over-current in coil 2"},
    {&Flags::charge_pump_failure, "charge_pump_failure", "charge pump failure"},
});

struct Words {
  std::string_view name;
  std::string_view text;
};

constexpr Words words(Motion motion) {
  constexpr std::array<Words, 8> kWords{{{"at_target", "at its target"},
                                         {"accelerating_up", "accelerating"},
                                         {"decelerating_up", "decelerating"},
                                         {"top_speed_up", "at full speed"},
                                         {"not_at_target", "stopped beside it"},
                                         {"accelerating_down", "accelerating back"},
                                         {"decelerating_down", "decelerating back"},
                                         {"top_speed_down", "at full speed back"}}};
  return kWords[static_cast<std::size_t>(motion) % kWords.size()];
}

/// tsd, tw and the two temperature bits say it together.
constexpr std::string_view temperature_name(const Flags& flags) {
  constexpr std::array<std::string_view, 4> kNames{"normal", "cold", "hot", "shut_down"};
  return kNames[flags.temperature % kNames.size()];
}

}  // namespace sinew::tmc222
