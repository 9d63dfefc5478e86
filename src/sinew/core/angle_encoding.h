#pragma once

#include <cstdint>

namespace sinew {

/// How four bytes say an angle; axis boards of different ages disagree.
enum class AngleEncoding : std::uint8_t {
  kDegU32,   ///< whole degrees from the joint's zero, unsigned, big endian: the document
  kMdegI32,  ///< thousandths of a degree, two's complement, big endian
  kF32Be,    ///< degrees, IEEE float, big endian
  kF32Le,    ///< degrees, IEEE float, little endian
};

}  // namespace sinew
