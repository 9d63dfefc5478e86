#pragma once

#include <expected>
#include <memory>
#include <string>

#include "sinew/sim/link_fault.h"
#include "sinew/sim/machine.h"

namespace sinew::sim {

/// Boards on a bus whose wires are bad, and that get blows at their moments. The host clocks both
/// ways at once, so what is lost or doubled is a whole transfer: in a lost one the boards see no
/// clock and the host hears ones; a doubled one the boards get twice, and the host hears the second
/// answer. Bits flip, and in a cut both sides hear ones. Moments count from the first advance().
class SpiFaults : public SpiMachine {
 public:
  /// @error  a sentence: what the plan asks for cannot befall a clocked wire
  static std::expected<std::unique_ptr<SpiFaults>, std::string> create(SpiMachine& machine,
                                                                       const FaultPlan& plan);

  void advance(Instant now) override;
  std::optional<Instant> next_event() const override { return machine_.next_event(); }
  Truth truth() const override { return machine_.truth(); }
  void disturb(const Disturbance& what) override { machine_.disturb(what); }
  LastingState lasting_state() const override { return machine_.lasting_state(); }
  bool restore(const LastingState& state) override { return machine_.restore(state); }
  void select(std::uint8_t mask, Instant now) override;
  void shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
             std::uint32_t clock_hz, Instant now) override;
  Figures figures(std::optional<std::size_t> axis) const override { return machine_.figures(axis); }
  bool ready_pin(std::size_t axis) const override { return machine_.ready_pin(axis); }

  std::uint64_t flipped() const { return flipped_; }
  std::uint64_t dropped() const { return dropped_; }        ///< transfers
  std::uint64_t duplicated() const { return duplicated_; }  ///< transfers

 private:
  SpiFaults(SpiMachine& machine, const FaultPlan& plan);
  bool is_cut(LinkDirection direction, Instant now) const;
  std::uint8_t spoiled(std::uint8_t byte, LinkDirection direction, Instant now);
  bool befalls(TimedByteFault::Kind kind, double chance, Instant now);
  void transfer(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
                std::uint32_t clock_hz, Instant now);

  SpiMachine& machine_;
  FaultPlan plan_;
  TimedByteFaults timed_;
  SplitMix64 random_;
  std::optional<Instant> start_;
  std::size_t next_blow_ = 0;
  std::uint8_t selected_ = 0;
  std::uint64_t flipped_ = 0;
  std::uint64_t dropped_ = 0;
  std::uint64_t duplicated_ = 0;
};

}  // namespace sinew::sim
