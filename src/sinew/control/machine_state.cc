#include "sinew/control/machine_state.h"

namespace sinew::control {

std::string_view name(MachineState state) {
  static constexpr std::array<std::string_view, kMachineStates> kNames{
      "off", "enabling", "ready", "moving", "stopping", "held", "fault", "recovering"};
  return kNames[static_cast<std::size_t>(state)];
}

std::string_view name(Signal signal) {
  static constexpr std::array<std::string_view, kSignals> kNames{
      "enable", "enabled",     "doubt",        "begin",  "recover", "arrived",     "hold",   "stop",
      "rested", "rested_held", "rested_fault", "resume", "fault",   "acknowledge", "disable"};
  return kNames[static_cast<std::size_t>(signal)];
}

}  // namespace sinew::control
