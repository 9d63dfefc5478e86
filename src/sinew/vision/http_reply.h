#pragma once

#include <cstddef>
#include <cstdint>
#include <expected>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// Replies of HTTP servers as cameras give them: read leniently where nothing can be misunderstood,
/// since many are a few hundred lines on a small chip. Source: RFC 9110, RFC 9112.
namespace sinew::vision {

/// Of a head with its empty line, and of the head of a part, bytes.
inline constexpr std::size_t kReplyHeadMax = std::size_t{16} << 10U;
/// Of one picture, bytes.
inline constexpr std::size_t kStreamedPictureMax = std::size_t{16} << 20U;

/// Header fields; names in lower case, values without the blanks around them.
class HttpFields {
 public:
  /// Of lines that end with LF or CR LF; what is no field is passed over.
  static HttpFields of(std::string_view lines);

  /// The value of the first field of that name, given in lower case; empty where there is none.
  std::string_view value(std::string_view name) const;
  /// The value of the field as a length; nothing where there is none.
  /// @error  it is there and no number
  std::expected<std::optional<std::uint64_t>, std::string> length(std::string_view name) const;

 private:
  std::vector<std::pair<std::string, std::string>> fields_;
};

struct HttpReplyHead {
  int status = 0;
  std::string reason;
  HttpFields fields;
};

/// How long a head is that ends with an empty line; 0 where its end has not come.
std::size_t head_bytes(std::span<const std::uint8_t> bytes);

/// @param head  whole, with its empty line
/// @error  a sentence: no reply of HTTP
std::expected<HttpReplyHead, std::string> read_reply_head(std::string_view head);

/// A parameter of a field's value: boundary in `multipart/x-mixed-replace; boundary="a b"`; empty
/// where it is not there.
std::string field_parameter(std::string_view value, std::string_view name);

std::string lower_letters(std::string_view text);

/// Takes a body out of its transfer coding: chunked, of a known length, or up to the end of the
/// connection.
class HttpBody {
 public:
  /// @error  a sentence: a coding other than chunked, a length that is no number
  static std::expected<HttpBody, std::string> of(const HttpFields& fields);

  /// Appends what of these bytes belongs to the body.
  /// @error  a sentence: broken chunks
  std::expected<void, std::string> feed(std::span<const std::uint8_t> bytes,
                                        std::vector<std::uint8_t>& body);
  /// Whether all of it has come; false for a body that only the connection's end ends.
  bool is_whole() const { return state_ == State::kWhole; }

 private:
  enum class State : std::uint8_t { kBytes, kChunkSize, kChunkEnd, kTrailer, kWhole };

  std::expected<void, std::string> take_line();

  State state_ = State::kBytes;
  bool is_chunked_ = false;
  bool is_open_ = false;    ///< its length is not known
  std::uint64_t left_ = 0;  ///< of the body or of a chunk
  std::string line_;        ///< of a chunk's size or the trailer, as far as it has come
};

}  // namespace sinew::vision
