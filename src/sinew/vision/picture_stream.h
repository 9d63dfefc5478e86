#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/vision/http_reply.h"
#include "sinew/vision/multipart.h"

namespace sinew::vision {

/// The pictures in one reply of an HTTP server: a stream of the type multipart/x-mixed-replace, or
/// one picture. Needs at most twice kStreamedPictureMax of memory, and what one feed() brings.
class PictureStream {
 public:
  /// Pictures that these bytes completed, in their order. After an error the reply is of no use.
  /// @error  what the server does, a sentence without its subject, with the remedy: "replies 404
  ///         Not Found; ..."
  std::expected<std::vector<StreamedPicture>, std::string> feed(std::span<const std::uint8_t> bytes,
                                                                Instant now);

  /// The server closed the connection: what only this completes.
  std::vector<StreamedPicture> end();

  /// Whether the reply's head came and promises pictures.
  bool has_begun() const { return body_.has_value(); }
  /// Whether it is one picture, and the next has to be requested.
  bool is_single() const { return has_begun() && !parts_; }
  /// Whether nothing more comes in this reply.
  bool is_over() const { return is_over_; }

 private:
  std::expected<bool, std::string> read_head();
  std::expected<void, std::string> begin(const HttpReplyHead& head);

  std::vector<std::uint8_t> head_;  ///< as far as it has come
  std::optional<HttpBody> body_;
  std::optional<Multipart> parts_;
  std::vector<std::uint8_t> single_;
  std::optional<Instant> begun_;  ///< of the single picture
  bool is_over_ = false;
};

}  // namespace sinew::vision
