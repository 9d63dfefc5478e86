#pragma once

// Runs as bytes: integers only, for both ends of a wire.

#include <cstddef>
#include <cstdint>
#include <span>

#include "sinew/motion/step_timing.h"

namespace sinew::motion {

/// How finely the numbers of a run are said, in bits behind the binary point. Depends on the length
/// alone, so it needs no bytes. @rt
struct StepRunPrecision {
  explicit StepRunPrecision(std::uint32_t count);
  int interval = 0, add = 0, add2 = 0;
};

/// Bytes for runs, and back: 6 to 9 a run. A run's numbers are said to the bit that its length
/// needs, and as differences from where the run before leads. Integers only. @rt
class StepRunCode {
 public:
  static constexpr std::size_t kBytesMax = 32;

  /// @return  bytes written to `out`, which has room for kBytesMax.
  std::size_t encode(const StepRun& run, std::span<std::uint8_t> out);
  /// @return  bytes read; 0: not a whole run, or none that encode() makes.
  std::size_t decode(std::span<const std::uint8_t> in, StepRun& run);

 private:
  void follow(const StepRun& run);
  std::int64_t interval_ = 0;  ///< 2^-shift_ ticks: what would come after the last run
  std::int64_t add_ = 0;
  int shift_ = 0;
  std::int8_t direction_ = 0;
};

}  // namespace sinew::motion
