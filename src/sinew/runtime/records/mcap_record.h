#pragma once

#include <array>
#include <cstdint>
#include <span>

/// What writer and reader of MCAP files share. Source: https://mcap.dev/spec, version 0.
namespace sinew::runtime::mcap {

inline constexpr std::array<std::uint8_t, 8> kMagic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Opcode : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0B,
  kMetadata = 0x0C,
  kMetadataIndex = 0x0D,
  kSummaryOffset = 0x0E,
  kDataEnd = 0x0F,
};

/// Opcode and length in front of each record, bytes.
inline constexpr std::size_t kRecordHead = 9;

/// CRC-32 of Ethernet and zlib: polynomial 04C11DB7, reflected; the nine characters "123456789"
/// give CBF43926.
/// @param before  of the bytes in front of these, 0 at the beginning
std::uint32_t crc32(std::span<const std::uint8_t> bytes, std::uint32_t before = 0);

}  // namespace sinew::runtime::mcap
