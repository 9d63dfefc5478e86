#pragma once

#include <cmath>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sinew {

/// Which of the expected failures; their list is core/error_code.h, apart from here so that a new
/// one compiles only what names one.
enum class ErrorCode : std::uint8_t;

/// How a stop ends, after IEC 60204-1.
enum class StopCategory : std::uint8_t {
  kNone,              ///< nothing was moving because of this
  kPowerOff,          ///< category 0: remove power at once
  kStopThenPowerOff,  ///< category 1: decelerate, then remove power
  kStopAndHold,       ///< category 2: decelerate and hold
};

/// What a number in an Error means to people; the value itself is always SI.
enum class Quantity : std::uint8_t {
  kNone,
  kLength,
  kAngle,
  kTime,
  kRatio,
  kCount,
  kVoltage,
  kVelocity,
  kAcceleration,
  kAngularVelocity,
  kAngularAcceleration,
};

/// An expected failure with the values that matter. Text is made at the edge by `describe`.
struct Error {
  ErrorCode code{};
  std::int8_t index = -1;   ///< joint or leg, counted from 0; -1 where there is none
  double measured = 0;      ///< what would be needed or was seen; unit by code
  double limit = 0;         ///< what is allowed; same unit
  std::int16_t other = -1;  ///< the second one where two of them meet

  friend bool operator==(const Error&, const Error&) = default;
};

template <class T>
using Expected = std::expected<T, Error>;

/// The row of the one table of errors.
struct ErrorInfo {
  ErrorCode code;
  std::string_view name;      ///< stable, for machines
  std::string_view sentence;  ///< with {subject} {measured} {limit} {excess}
  Quantity quantity;
  bool position_survives;
  StopCategory stop;
  int http_status;
};

std::span<const ErrorInfo> error_table();
const ErrorInfo& info(ErrorCode code);

/// How far beyond the limit; unit by code. @rt
inline double excess(const Error& error) {
  return std::abs(error.measured - error.limit);
}

/// One sentence in mm, degrees and seconds: "out of reach by 12 mm".
/// @param subject   name of the joint or leg that `error.index` means; "J3" style when empty.
/// @param quantity  of its numbers, where whoever asks knows better than the table: a leg's place
std::string describe(const Error& error, std::string_view subject = {},
                     std::optional<Quantity> quantity = std::nullopt);

}  // namespace sinew
