#pragma once

#include "firmware/emulation/cortex_m.h"

namespace sinew::emulation {

/// The flash interface of an STM32 (PM0075 for the F103, RM0368 3.6 for the F401): what the program
/// erases and writes, and a supply that fails in between. What the chip would refuse, or quietly
/// spoil, breaks the run: writing while it is locked, or over bytes that were not erased.
class Stm32Flash : public Peripheral {
 public:
  Stm32Flash(CortexM& core, bool is_f103);

  std::uint32_t read(std::uint32_t offset) override { return word_[offset / 4]; }
  void write(std::uint32_t offset, std::uint32_t value) override;
  void reset();

  /// The supply fails in the middle of that operation, counted from now: 0 is the next one.
  void cut_power_in(std::optional<int> operations) { cut_in_ = operations; }
  bool power_cut() const { return power_cut_; }
  /// Erased pages and sectors, and written units, since the beginning.
  int operations() const { return operations_; }

 private:
  bool locked() const;
  bool cut_now();
  void erase(std::uint32_t address, std::uint32_t size, double seconds);
  void program(std::uint32_t address, std::uint32_t value, unsigned size);

  CortexM& core_;
  bool is_f103_;
  std::array<std::uint32_t, 6> word_{};
  int keys_ = 0;
  int operations_ = 0;
  std::optional<int> cut_in_;
  bool power_cut_ = false;
};

}  // namespace sinew::emulation
