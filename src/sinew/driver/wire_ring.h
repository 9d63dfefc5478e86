#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "sinew/core/instant.h"

namespace sinew {

enum class WireWay : std::uint8_t { kToDevice, kToHost };

/// What passed over a wire at one instant, one way.
struct WirePiece {
  Instant at{};
  WireWay way = WireWay::kToDevice;
  std::uint8_t select = 0;  ///< SPI: bit i is axis i; 0 on a serial line
  std::vector<std::uint8_t> bytes;
};

/// The last pieces of a wire. One thread writes, @rt: it waits for nobody and overwrites what is
/// oldest. Others read at their own pace, each with a place of its own, and hear how much they
/// were too slow for.
class WireRing {
 public:
  static constexpr std::size_t kSlots = 4096;
  static constexpr std::size_t kSlotBytes = 32;  ///< a longer piece takes several slots

  /// Where a reader is, in slots since the beginning.
  using Place = std::uint64_t;

  WireRing() : slots_(std::make_unique<std::array<Slot, kSlots>>()) {}

  void add(WireWay way, std::span<const std::uint8_t> bytes, Instant now, std::uint8_t select = 0) {
    while (!bytes.empty()) {
      const std::size_t size = std::min(bytes.size(), kSlotBytes);
      const bool goes_on = size < bytes.size();
      put(way, bytes.first(size), goes_on, now, select);
      bytes = bytes.subspan(size);
    }
  }

  /// Appends what has come since `place`, which moves on. @return slots that were overwritten
  /// before they could be read
  std::uint64_t read(Place& place, std::vector<WirePiece>& out) const {
    const Place end = written_.load(std::memory_order_acquire);
    std::uint64_t lost = 0;
    bool goes_on = false;
    while (place < end) {
      const Slot& slot = (*slots_)[place % kSlots];
      std::array<std::uint64_t, kWords> words;
      for (std::size_t k = 0; k < kWords; ++k) {
        words[k] = slot.words[k].load(std::memory_order_acquire);
      }
      // A word of a later piece shows that its writing had begun.
      const Place begun = begun_.load(std::memory_order_relaxed);
      if (begun > place + kSlots) {
        const Place oldest = begun - kSlots;
        lost += oldest - place;
        place = oldest;
        goes_on = false;
        continue;
      }
      ++place;
      take(words, goes_on, out);
    }
    return lost;
  }

 private:
  static constexpr std::size_t kWords = 2 + kSlotBytes / 8;
  struct Slot {
    std::array<std::atomic<std::uint64_t>, kWords> words{};
  };

  void put(WireWay way, std::span<const std::uint8_t> bytes, bool goes_on, Instant now,
           std::uint8_t select) {
    const Place place = begun_.load(std::memory_order_relaxed);
    begun_.store(place + 1, std::memory_order_relaxed);
    std::array<std::uint64_t, kWords> words{};
    words[0] = static_cast<std::uint64_t>(now.time_since_epoch().count());
    words[1] = bytes.size() | (std::uint64_t{select} << 8) |
               (std::uint64_t{way == WireWay::kToHost} << 16) | (std::uint64_t{goes_on} << 17);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      words[2 + i / 8] |= std::uint64_t{bytes[i]} << (8 * (i % 8));
    }
    Slot& slot = (*slots_)[place % kSlots];
    // Released one by one: whoever sees one of them sees begun_ as well.
    for (std::size_t k = 0; k < kWords; ++k) {
      slot.words[k].store(words[k], std::memory_order_release);
    }
    written_.store(place + 1, std::memory_order_release);
  }

  /// @param goes_on  the slot before belongs to the same piece
  static void take(const std::array<std::uint64_t, kWords>& words, bool& goes_on,
                   std::vector<WirePiece>& out) {
    if (!goes_on || out.empty()) {
      WirePiece piece;
      piece.at = Instant{Duration{static_cast<std::int64_t>(words[0])}};
      piece.select = static_cast<std::uint8_t>(words[1] >> 8);
      piece.way = ((words[1] >> 16) & 1) != 0 ? WireWay::kToHost : WireWay::kToDevice;
      out.push_back(std::move(piece));
    }
    const std::size_t size = words[1] & 0xFF;
    for (std::size_t i = 0; i < size; ++i) {
      out.back().bytes.push_back(static_cast<std::uint8_t>(words[2 + i / 8] >> (8 * (i % 8))));
    }
    goes_on = ((words[1] >> 17) & 1) != 0;
  }

  std::unique_ptr<std::array<Slot, kSlots>> slots_;
  std::atomic<Place> begun_ = 0;    ///< slots whose writing has begun
  std::atomic<Place> written_ = 0;  ///< slots that are whole
};

}  // namespace sinew
