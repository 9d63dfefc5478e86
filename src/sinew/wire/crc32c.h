#pragma once

#include <cstdint>
#include <span>

namespace sinew {

/// CRC-32C (Castagnoli): polynomial 1EDC6F41, reflected, all ones before and after; the nine
/// characters "123456789" give E3069283.
///
/// Source: RFC 3720, B.4. On 16 bytes of which it is the last 4 it finds every error of up to 7
/// bits and every burst of up to 32 bits (crc32c_test.cc proves both); the CRC-32 of Ethernet finds
/// 6 bits there. @rt
std::uint32_t crc32c(std::span<const std::uint8_t> bytes);

}  // namespace sinew
