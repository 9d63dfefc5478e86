#include "sinew/runtime/wire_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "sinew/devices/device_kinds.h"
#include "sinew/runtime/wire_reader_parts.h"

namespace sinew::runtime {
namespace wires {
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

}  // namespace wires

std::unique_ptr<WireReader> wire_reader(const Device& device, const DeviceFacts& facts) {
  const auto* arm = std::get_if<BigRobotArmFacts>(&facts);
  return visit_kind(
      wires::Cases{[](const IdealDevice&) { return wires::ideal_reader(); },
                   [arm](const BigRobotArmDevice& settings) {
                     const BigRobotArmWire wire = arm != nullptr ? arm->wire : settings.wire;
                     return wire == BigRobotArmWire::kByte ? wires::bigrobotarm_byte_reader()
                                                           : wires::bigrobotarm_text_reader();
                   },
                   [](const AxisRegistersDevice& settings) {
                     return wires::axis_registers_reader(settings);
                   },
                   [](const AxisLinkDevice&) { return wires::axis_link_reader(); },
                   [](const LscDevice& settings) { return wires::lsc_reader(settings); },
                   [](const MaxArmDevice&) { return wires::maxarm_reader(); },
                   [](const IcpDevice& settings) { return wires::icp_reader(settings); }},
      device.settings);
}

std::string text_of(const WireMessage& message) {
  std::string text(message.name);
  std::ranges::replace(text, '_', ' ');
  const char* before = ": ";
  for (const WireField& field : message.fields) {
    text += before + std::string(field.name) + " ";
    std::visit(wires::Cases{[&](std::int64_t value) { text += std::to_string(value); },
                            [&](double value) { text += fmt::format("{:.6g}", value); },
                            [&](const std::string& value) { text += value; }},
               field.value);
    before = ", ";
  }
  return text;
}

std::string hex_of(const std::vector<std::uint8_t>& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    text += fmt::format("{}{:02X}", text.empty() ? "" : " ", byte);
  }
  return text;
}

}  // namespace sinew::runtime
