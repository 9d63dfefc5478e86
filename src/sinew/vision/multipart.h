#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/core/instant.h"

namespace sinew::vision {

/// A picture as a camera sent it.
struct StreamedPicture {
  std::vector<std::uint8_t> file;  ///< JPEG or PNG, as far as the camera says
  Instant begun;                   ///< when its first byte came
};

/// The parts of a body of the type multipart/x-mixed-replace. Source: RFC 2046, 5.1; and what
/// cameras make of it: boundaries that are given with their dashes, line feeds alone, parts with
/// and without a length, or with a wrong one.
class Multipart {
 public:
  /// @error  a sentence: a boundary of nothing but dashes, or over 200 bytes
  static std::expected<Multipart, std::string> with_boundary(const std::string& boundary);

  /// Parts that these bytes completed, in their order.
  /// @error  a sentence: a part or its head is too large
  std::expected<std::vector<StreamedPicture>, std::string> feed(std::span<const std::uint8_t> bytes,
                                                                Instant now);

  /// The connection has ended: the part that only this ends.
  std::optional<StreamedPicture> end();

 private:
  enum class State : std::uint8_t { kBoundary, kHead, kBody, kEnd };

  explicit Multipart(std::string delimiter) : delimiter_(std::move(delimiter)) {}
  bool pass_boundary();
  std::expected<bool, std::string> read_head();
  bool read_body(std::vector<StreamedPicture>& parts);
  std::optional<std::size_t> body_end();
  void drop(std::size_t count);

  std::string delimiter_;  ///< two dashes and the boundary without its own
  State state_ = State::kBoundary;
  std::vector<std::uint8_t> buffer_;   ///< what has come and was not used yet
  std::size_t searched_ = 0;           ///< no delimiter begins before this byte of it
  std::optional<std::size_t> length_;  ///< of the part, where it says so
  std::optional<Instant> begun_;       ///< of the part
};

}  // namespace sinew::vision
