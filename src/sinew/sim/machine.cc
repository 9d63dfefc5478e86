#include "sinew/sim/machine.h"

namespace sinew::sim {

bool power_up_from(const LastingState& state, Machine& machine, Instant boot) {
  const double nominal = machine.truth().supply_volts;
  if (!machine.restore(state)) return false;
  machine.disturb({.kind = Disturbance::Kind::kSupply, .value = 0});
  machine.advance(boot);
  machine.disturb({.kind = Disturbance::Kind::kSupply, .value = nominal});
  return true;
}

}  // namespace sinew::sim
