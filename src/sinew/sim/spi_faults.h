#pragma once

#include <expected>
#include <memory>
#include <string>

#include "sinew/sim/link_fault.h"
#include "sinew/sim/machine.h"

namespace sinew::sim {

/// Boards on a bus whose wires are bad, and that get blows at their moments. A clocked wire loses
/// no byte and holds none back: bits flip, and in a cut both sides hear ones. Moments count from
/// the first advance().
class SpiFaults : public SpiMachine {
 public:
  /// @error  a sentence: what the plan asks for cannot befall a clocked wire
  static std::expected<std::unique_ptr<SpiFaults>, std::string> create(SpiMachine& machine,
                                                                       const FaultPlan& plan);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override { return machine_.next_event(); }
  Truth truth() const override { return machine_.truth(); }
  void disturb(const Disturbance& what) override { machine_.disturb(what); }
  void select(std::uint8_t mask, Instant now) override;
  void shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
             std::uint32_t clock_hz, Instant now) override;
  bool ready_pin(std::size_t axis) const override { return machine_.ready_pin(axis); }

  std::uint64_t flipped() const { return flipped_; }

 private:
  SpiFaults(SpiMachine& machine, const FaultPlan& plan);
  bool is_cut(LinkDirection direction, Instant now) const;
  std::uint8_t spoiled(std::uint8_t byte, LinkDirection direction, Instant now);

  SpiMachine& machine_;
  FaultPlan plan_;
  SplitMix64 random_;
  std::optional<Instant> start_;
  std::size_t next_blow_ = 0;
  std::uint64_t flipped_ = 0;
};

}  // namespace sinew::sim
