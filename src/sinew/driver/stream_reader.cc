#include "sinew/driver/stream_reader.h"

#include <algorithm>

namespace sinew::wires {
namespace {

/// A message that is not complete after so long never will be: the longest one takes 80 ms at 9600
/// baud.
constexpr Duration kStale = std::chrono::milliseconds(500);

}  // namespace

void StreamReader::tell(const WirePiece& piece, Begun& begun, std::size_t size, Told told,
                        std::vector<WireMessage>& out) {
  const auto end = begun.bytes.begin() + static_cast<std::ptrdiff_t>(size);
  out.push_back({begun.at,
                 piece.way,
                 piece.select,
                 {begun.bytes.begin(), end},
                 told.name,
                 std::move(told.fields),
                 told.kind});
  begun.bytes.erase(begun.bytes.begin(), end);
  begun.noise = 0;
  begun.at = piece.at;
}

void StreamReader::end_stale(const WirePiece& piece, std::vector<WireMessage>& out) {
  for (const WireWay way : {WireWay::kToDevice, WireWay::kToHost}) {
    Begun& begun = begun_[static_cast<std::size_t>(way)];
    if (begun.bytes.empty() || piece.at - begun.at < kStale) continue;
    WirePiece own = piece;
    own.way = way;
    tell(own, begun, begun.bytes.size(), bad("unfinished"), out);
    reset(way);
  }
}

void StreamReader::read(const WirePiece& piece, std::vector<WireMessage>& out) {
  end_stale(piece, out);
  Begun& begun = begun_[static_cast<std::size_t>(piece.way)];
  bool ended = false;
  for (const std::uint8_t byte : piece.bytes) {
    if (ended && belongs(piece.way, byte)) {
      static_cast<void>(push(piece.way, byte));
      out.back().bytes.push_back(byte);
      ended = false;
      continue;
    }
    ended = false;
    if (begun.bytes.empty()) begun.at = piece.at;
    begun.bytes.push_back(byte);
    if (auto told = push(piece.way, byte)) {
      const std::size_t all = begun.bytes.size();
      const std::size_t own = told->size > 0 ? std::min(told->size, all) : all - begun.noise;
      if (own < all) tell(piece, begun, all - own, bad("noise"), out);
      tell(piece, begun, own, std::move(*told), out);
      ended = true;
    } else if (between(piece.way)) {
      begun.noise = begun.bytes.size();
    }
  }
  if (begun.noise > 0) tell(piece, begun, begun.noise, bad("noise"), out);
}

void StreamReader::forget() {
  for (Begun& begun : begun_) begun = {};
  reset(WireWay::kToDevice);
  reset(WireWay::kToHost);
}

}  // namespace sinew::wires
