#include "sinew/devices/axis/axis_machine_bus.h"

#include "sinew/core/assert.h"

namespace sinew::sim {
namespace {

bool has(std::uint8_t bits, std::size_t i) {
  return (bits >> i & 1) != 0;
}

std::uint8_t bit(std::size_t i) {
  return static_cast<std::uint8_t>(1 << i);
}

}  // namespace

void AxisBus::attach(SpiSlave& slave, SelectKind kind, std::uint8_t bus) {
  ports_.push_back({&slave, kind, bus, bit(ports_.size()), true, false});
}

void AxisBus::wire_select(std::size_t axis, std::uint8_t slaves) {
  ports_[axis].reaches = slaves;
}

void AxisBus::set_powered(std::size_t axis, bool powered) {
  ports_[axis].powered = powered;
}

void AxisBus::select(std::uint8_t select) {
  std::uint8_t pulled = 0;
  clocked_ = select == 0 ? 0xFF : 0;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    if (!has(select, i)) continue;
    pulled |= ports_[i].reaches;
    // The host clocks the bus that it believes the axis is on, whatever the chip select reaches.
    for (std::size_t k = 0; k < ports_.size(); ++k) {
      if (ports_[k].bus == ports_[i].bus) clocked_ |= bit(k);
    }
  }
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    Port& port = ports_[i];
    const bool selected = has(pulled, i);
    if (selected != port.selected && port.powered) port.slave->select(selected);
    port.selected = selected;
  }
}

std::uint8_t AxisBus::shift(std::uint8_t mosi) {
  std::uint8_t low_wins = kIdle;
  std::uint8_t high_wins = 0;
  bool driven = false;
  for (std::size_t i = 0; i < ports_.size(); ++i) {
    const Port& port = ports_[i];
    const bool listens = port.selected || port.kind == SelectKind::kSoft;
    if (!port.powered || !listens || !has(clocked_, i)) continue;
    const std::uint8_t miso = port.slave->shift(mosi);
    low_wins &= miso;
    high_wins |= miso;
    driven = true;
  }
  if (!driven) return kIdle;
  if (low_wins != high_wins) ++contended_;
  return low_wins;
}

}  // namespace sinew::sim
