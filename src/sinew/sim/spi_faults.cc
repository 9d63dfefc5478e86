#include "sinew/sim/spi_faults.h"

#include <algorithm>
#include <array>

#include "sinew/core/stable_sort.h"

namespace sinew::sim {
namespace {

constexpr std::size_t kPiece = 64;  // bytes

}  // namespace

std::expected<std::unique_ptr<SpiFaults>, std::string> SpiFaults::create(SpiMachine& machine,
                                                                         const FaultPlan& plan) {
  using Kind = TimedByteFault::Kind;
  const auto& [to_device, to_host] = plan.link.bytes;
  bool delays = to_device.delay > 0 || to_host.delay > 0;
  bool one_way = to_device.drop != to_host.drop || to_device.duplicate != to_host.duplicate;
  for (const TimedByteFault& fault : plan.link.timed) {
    delays |= fault.kind == Kind::kDelay;
    one_way |= fault.only && (fault.kind == Kind::kDrop || fault.kind == Kind::kDuplicate);
  }
  if (delays) {
    return std::unexpected(
        "delay cannot befall SPI: the host clocks each byte itself, so none can come late; drop, "
        "duplicate, flip, cut and half-open can");
  }
  if (one_way) {
    return std::unexpected(
        "drop and duplicate have no direction on SPI: a transfer goes both ways at once, and is "
        "lost or doubled as a whole");
  }
  return std::unique_ptr<SpiFaults>(new SpiFaults(machine, plan));
}

SpiFaults::SpiFaults(SpiMachine& machine, const FaultPlan& plan)
    : machine_(machine), plan_(plan), timed_(plan.link), random_(plan.link.seed) {
  stable_sort_by(plan_.disturbances, &TimedDisturbance::at);
}

void SpiFaults::advance(Instant now) {
  if (!start_) start_ = now;
  while (next_blow_ < plan_.disturbances.size() &&
         *start_ + plan_.disturbances[next_blow_].at <= now) {
    const TimedDisturbance& blow = plan_.disturbances[next_blow_++];
    machine_.advance(*start_ + blow.at);
    machine_.disturb(blow.what);
  }
  machine_.advance(now);
}

void SpiFaults::select(std::uint8_t mask, Instant now) {
  advance(now);
  selected_ = mask;
  machine_.select(mask, now);
}

bool SpiFaults::is_cut(LinkDirection direction, Instant now) const {
  return std::ranges::any_of(plan_.link.cuts, [&](const LinkCut& cut) {
    const Instant begin = start_.value_or(now) + cut.at;
    const bool this_way = !cut.only || *cut.only == direction;
    return this_way && now >= begin && (!cut.lasts || now < begin + *cut.lasts);
  });
}

std::uint8_t SpiFaults::spoiled(std::uint8_t byte, LinkDirection direction, Instant now) {
  if (is_cut(direction, now)) return 0xFF;
  const double chance = plan_.link.bytes[static_cast<std::size_t>(direction)].flip;
  const bool drawn = chance > 0 && random_.uniform(0, 1) < chance;
  const Duration since = now - start_.value_or(now);
  const bool struck = timed_.strikes(TimedByteFault::Kind::kFlip, direction, since).has_value();
  if (!drawn && !struck) return byte;
  ++flipped_;
  return static_cast<std::uint8_t>(byte ^ 1U << (random_.bits() & 7U));
}

bool SpiFaults::befalls(TimedByteFault::Kind kind, double chance, Instant now) {
  const bool drawn = chance > 0 && random_.uniform(0, 1) < chance;
  const Duration since = now - start_.value_or(now);
  return timed_.strikes(kind, std::nullopt, since).has_value() || drawn;
}

void SpiFaults::shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
                      std::uint32_t clock_hz, Instant now) {
  advance(now);
  if (befalls(TimedByteFault::Kind::kDrop, plan_.link.bytes[0].drop, now)) {
    ++dropped_;
    std::ranges::fill(miso, 0xFF);
    return;
  }
  if (befalls(TimedByteFault::Kind::kDuplicate, plan_.link.bytes[0].duplicate, now)) {
    ++duplicated_;
    transfer(mosi, miso, clock_hz, now);
    // A transfer of its own for the boards; the host's clock knows of one only.
    machine_.select(0, now);
    machine_.select(selected_, now);
  }
  transfer(mosi, miso, clock_hz, now);
}

void SpiFaults::transfer(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
                         std::uint32_t clock_hz, Instant now) {
  // In pieces, so that nothing is allocated; a piece begins where the last one ended.
  std::array<std::uint8_t, kPiece> bytes;
  const Duration byte_time{8'000'000'000 / clock_hz};
  for (std::size_t begin = 0; begin < mosi.size(); begin += kPiece) {
    const std::size_t size = std::min(kPiece, mosi.size() - begin);
    const Instant at = now + byte_time * static_cast<std::int64_t>(begin);
    for (std::size_t i = 0; i < size; ++i) {
      bytes[i] = spoiled(mosi[begin + i], LinkDirection::kToDevice, at);
    }
    machine_.shift({bytes.data(), size}, miso.subspan(begin, size), clock_hz, at);
    for (std::uint8_t& byte : miso.subspan(begin, size)) {
      byte = spoiled(byte, LinkDirection::kToHost, at);
    }
  }
}

}  // namespace sinew::sim
