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
  for (const ByteFaults& faults : plan.link.bytes) {
    if (faults.drop > 0 || faults.duplicate > 0 || faults.delay > 0) {
      return std::unexpected(
          "drop, duplicate and delay cannot befall SPI, whose bytes are clocked by the host; flip, "
          "cut and half-open can");
    }
  }
  return std::unique_ptr<SpiFaults>(new SpiFaults(machine, plan));
}

SpiFaults::SpiFaults(SpiMachine& machine, const FaultPlan& plan)
    : machine_(machine), plan_(plan), random_(plan.link.seed) {
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
  if (chance <= 0 || random_.uniform(0, 1) >= chance) return byte;
  ++flipped_;
  return static_cast<std::uint8_t>(byte ^ 1U << (random_.bits() & 7U));
}

void SpiFaults::shift(std::span<const std::uint8_t> mosi, std::span<std::uint8_t> miso,
                      std::uint32_t clock_hz, Instant now) {
  advance(now);
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
