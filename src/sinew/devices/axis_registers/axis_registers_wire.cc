#include "sinew/devices/axis_registers/axis_registers_wire.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "sinew/core/assert.h"

namespace sinew::axis_registers {

namespace {

constexpr std::uint32_t kPolynomial = 0x04C11DB7;
constexpr std::uint32_t kCrcStart = 0xFFFFFFFF;
constexpr std::size_t kWord = 4;

constexpr std::array<std::uint32_t, 256> make_crc_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t crc = i << 24;
    for (int bit = 0; bit < 8; ++bit) {
      crc = (crc & 0x80000000U) != 0 ? crc << 1 ^ kPolynomial : crc << 1;
    }
    table[i] = crc;
  }
  return table;
}
constexpr std::array<std::uint32_t, 256> kCrcTable = make_crc_table();

constexpr std::uint8_t byte_of(std::uint32_t value, int shift) {
  return static_cast<std::uint8_t>(value >> shift & 0xFF);
}

constexpr std::array<std::uint8_t, 4> big_endian(std::uint32_t value) {
  return {byte_of(value, 24), byte_of(value, 16), byte_of(value, 8), byte_of(value, 0)};
}

std::uint32_t from_big_endian(std::span<const std::uint8_t> bytes) {
  std::uint32_t value = 0;
  for (const std::uint8_t byte : bytes) value = value << 8 | byte;
  return value;
}

std::span<const std::uint8_t> sealed_fields(const HeaderBytes& bytes) {
  return std::span(bytes).subspan(1, 8);
}

bool crc_is_right(const HeaderBytes& bytes) {
  return crc32(sealed_fields(bytes)) == from_big_endian(std::span(bytes).subspan(9, kCrcSize));
}

/// One check of a header; kOk where it passes.
Verdict check_one(Verdict check, const HeaderBytes& bytes, const HeaderRules& rules) {
  const Header header = read_header(bytes);
  const auto row = std::ranges::find(rules.registers, header.address, &RegisterRow::address);
  const bool known = row != rules.registers.end();
  const bool strict = rules.checks == Checks::kDocument;
  bool passes = true;
  switch (check) {
    case Verdict::kOk:
      break;
    case Verdict::kStartByte:
      passes = bytes.front() == kStart;
      break;
    case Verdict::kFrameId:
      passes =
          header.frame_id != rules.last_frame_id && (!strict || header.frame_id >= kFrameIdFirst);
      break;
    case Verdict::kSlaveId:
      passes = header.slave_id == rules.slave_id;
      break;
    case Verdict::kRegister:
      passes = known;
      break;
    case Verdict::kSize:
      passes = strict ? header.size == row->size : header.size >= 1 && header.size <= row->size;
      break;
    case Verdict::kEndByte:
      passes = bytes.back() == kEnd;
      break;
    case Verdict::kCrc:
      passes = crc_is_right(bytes);
      break;
    case Verdict::kOperation:
      passes = (header.operation == static_cast<std::uint8_t>(Operation::kRead) && row->readable) ||
               (header.operation == static_cast<std::uint8_t>(Operation::kWrite) && row->writable);
      break;
  }
  return passes ? Verdict::kOk : check;
}

using Order = std::array<Verdict, 8>;
using enum Verdict;
// In both, the register is known before its size and access are looked at.
constexpr Order kDocumentOrder{kStartByte, kFrameId, kSlaveId, kRegister,
                               kSize,      kEndByte, kCrc,     kOperation};
constexpr Order kAsBuiltOrder{kStartByte, kEndByte, kSlaveId,   kFrameId,
                              kRegister,  kSize,    kOperation, kCrc};

}  // namespace

std::optional<Verdict> verdict_of(std::uint8_t byte) {
  if (byte > static_cast<std::uint8_t>(Verdict::kOperation)) return std::nullopt;
  return static_cast<Verdict>(byte);
}

std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = kCrcStart;
  for (std::size_t word = 0; word < bytes.size(); word += kWord) {
    // The polynomial takes the highest byte of a word first, which is its last one on the wire.
    for (std::size_t k = kWord; k-- > 0;) {
      const std::uint8_t byte = word + k < bytes.size() ? bytes[word + k] : 0;
      crc = crc << 8 ^ kCrcTable[crc >> 24 ^ byte];
    }
  }
  return crc;
}

SealedData seal(std::span<const std::uint8_t> data) {
  SINEW_ASSERT(data.size() <= kDataMax);
  SealedData sealed(data);
  for (const std::uint8_t byte : big_endian(crc32(data))) sealed.push_back(byte);
  return sealed;
}

std::optional<Data> unseal(std::span<const std::uint8_t> sealed) {
  if (sealed.size() < kCrcSize || sealed.size() > kDataMax + kCrcSize) return std::nullopt;
  const auto data = sealed.first(sealed.size() - kCrcSize);
  if (crc32(data) != from_big_endian(sealed.last(kCrcSize))) return std::nullopt;
  return Data(data);
}

HeaderBytes encode_header(const Header& header) {
  HeaderBytes bytes{kStart,
                    header.slave_id,
                    byte_of(header.frame_id, 8),
                    byte_of(header.frame_id, 0),
                    header.operation,
                    byte_of(header.address, 8),
                    byte_of(header.address, 0),
                    byte_of(header.size, 8),
                    byte_of(header.size, 0)};
  std::ranges::copy(big_endian(crc32(sealed_fields(bytes))), bytes.begin() + 9);
  bytes.back() = kEnd;
  return bytes;
}

Header read_header(const HeaderBytes& bytes) {
  const auto u16 = [&](std::size_t at) {
    return static_cast<std::uint16_t>(from_big_endian(std::span(bytes).subspan(at, 2)));
  };
  return {bytes[1], u16(2), bytes[4], u16(5), u16(7)};
}

Verdict check_header(const HeaderBytes& bytes, const HeaderRules& rules) {
  for (const Verdict check : rules.checks == Checks::kDocument ? kDocumentOrder : kAsBuiltOrder) {
    if (const Verdict verdict = check_one(check, bytes, rules); verdict != Verdict::kOk) {
      return verdict;
    }
  }
  return Verdict::kOk;
}

std::expected<Header, Verdict> decode_header(const HeaderBytes& bytes) {
  for (const Verdict check : {Verdict::kStartByte, Verdict::kEndByte, Verdict::kCrc}) {
    if (check_one(check, bytes, {}) != Verdict::kOk) return std::unexpected(check);
  }
  return read_header(bytes);
}

CommitBytes encode_commit(Verdict verdict) {
  SINEW_ASSERT(verdict == Verdict::kOk || verdict == Verdict::kCrc);
  return {kStart, kCommit, static_cast<std::uint8_t>(verdict), kEnd};
}

std::optional<Verdict> decode_commit(std::span<const std::uint8_t> bytes) {
  for (const Verdict verdict : {Verdict::kOk, Verdict::kCrc}) {
    if (std::ranges::equal(bytes, encode_commit(verdict))) return verdict;
  }
  return std::nullopt;
}

Data encode_status(const Status& status) {
  std::uint32_t word = std::uint32_t{status.fault} << 8;
  int bit = 0;
  for (const bool flag :
       {status.motor_ok, status.sensor_ok, status.communication_ok, status.position_ok,
        status.homed, status.moving, status.end_stop, status.emergency_stop}) {
    word |= (flag ? 1U : 0U) << bit++;
  }
  return Data(big_endian(word));
}

std::optional<Status> decode_status(std::span<const std::uint8_t> data) {
  if (data.size() != 4) return std::nullopt;
  const std::uint32_t word = from_big_endian(data);
  if (word > 0xFFFF) return std::nullopt;
  const auto bit = [word](int place) { return (word >> place & 1) != 0; };
  return Status{bit(0), bit(1), bit(2), bit(3), bit(4), bit(5), bit(6), bit(7), byte_of(word, 8)};
}

std::optional<AngleBytes> encode_angle(AngleEncoding encoding, double angle_deg) {
  if (!std::isfinite(angle_deg)) return std::nullopt;
  switch (encoding) {
    case AngleEncoding::kDegU32: {
      const double units = std::round(angle_deg);
      if (units < 0 || units > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
      return big_endian(static_cast<std::uint32_t>(units));
    }
    case AngleEncoding::kMdegI32: {
      const double units = std::round(angle_deg * 1000);
      if (std::abs(units) > std::numeric_limits<std::int32_t>::max()) return std::nullopt;
      return big_endian(static_cast<std::uint32_t>(static_cast<std::int32_t>(units)));
    }
    case AngleEncoding::kF32Be:
    case AngleEncoding::kF32Le: {
      if (std::abs(angle_deg) > std::numeric_limits<float>::max()) return std::nullopt;
      AngleBytes bytes = big_endian(std::bit_cast<std::uint32_t>(static_cast<float>(angle_deg)));
      if (encoding == AngleEncoding::kF32Le) std::ranges::reverse(bytes);
      return bytes;
    }
  }
  return std::nullopt;
}

std::optional<double> decode_angle(AngleEncoding encoding, const AngleBytes& bytes) {
  AngleBytes ordered = bytes;
  if (encoding == AngleEncoding::kF32Le) std::ranges::reverse(ordered);
  const std::uint32_t word = from_big_endian(ordered);
  if (encoding == AngleEncoding::kDegU32) return static_cast<double>(word);
  if (encoding == AngleEncoding::kMdegI32) return static_cast<std::int32_t>(word) / 1000.0;
  const auto angle_deg = std::bit_cast<float>(word);
  if (!std::isfinite(angle_deg)) return std::nullopt;
  return static_cast<double>(angle_deg);
}

double angle_unit_deg(AngleEncoding encoding, double angle_deg) {
  if (encoding == AngleEncoding::kDegU32) return 1;
  if (encoding == AngleEncoding::kMdegI32) return 1e-3;
  const auto here = static_cast<float>(std::abs(angle_deg));
  return static_cast<double>(std::nextafter(here, std::numeric_limits<float>::infinity())) -
         static_cast<double>(here);
}

}  // namespace sinew::axis_registers
