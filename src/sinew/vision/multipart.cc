#include "sinew/vision/multipart.h"

#include <algorithm>

#include "sinew/vision/byte_text.h"
#include "sinew/vision/http_reply.h"

namespace sinew::vision {
namespace {

constexpr std::size_t kBoundaryMax = 200;
constexpr std::size_t kBoundaryLineMax = 256;

std::size_t find_in(Bytes bytes, std::size_t from, std::string_view text) {
  const std::string_view all(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const std::size_t at = all.find(text, from);
  return at == std::string_view::npos ? bytes.size() : at;
}

}  // namespace

std::expected<Multipart, std::string> Multipart::with_boundary(const std::string& boundary) {
  // DroidCam and others name it with the dashes that stand before it in the body.
  const std::size_t first = boundary.find_first_not_of('-');
  if (first == std::string::npos || boundary.size() > kBoundaryMax) {
    return std::unexpected("sends a multipart stream without a usable boundary");
  }
  return Multipart("--" + boundary.substr(first));
}

void Multipart::drop(std::size_t count) {
  buffer_.erase(buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(count));
  searched_ -= std::min(searched_, count);
}

/// Whether a line with the delimiter was found and left behind.
bool Multipart::pass_boundary() {
  while (true) {
    const std::size_t at = find_in(buffer_, searched_, delimiter_);
    if (at == buffer_.size()) {
      // The beginning of one may be here already.
      drop(buffer_.size() - std::min(buffer_.size(), delimiter_.size() - 1));
      searched_ = 0;
      return false;
    }
    drop(at);
    searched_ = 0;
    const std::size_t end = find_in(buffer_, delimiter_.size(), "\n");
    if (has_at(buffer_, delimiter_.size(), "--")) {
      state_ = State::kEnd;
      buffer_.clear();
      return false;
    }
    if (end == buffer_.size() && end < kBoundaryLineMax) return false;
    const auto is_blank = [](std::uint8_t c) { return c == ' ' || c == '\t' || c == '\r'; };
    const bool is_alone =
        end < buffer_.size() &&
        std::all_of(buffer_.begin() + static_cast<std::ptrdiff_t>(delimiter_.size()),
                    buffer_.begin() + static_cast<std::ptrdiff_t>(end), is_blank);
    if (is_alone) {
      drop(end + 1);
      state_ = State::kHead;
      return true;
    }
    searched_ = 1;  // letters of something else
  }
}

std::expected<bool, std::string> Multipart::read_head() {
  std::size_t size = has_at(buffer_, 0, "\r\n") ? 2 : has_at(buffer_, 0, "\n") ? 1 : 0;
  if (size == 0) {
    const Bytes head(buffer_);
    size = head_bytes(head.first(std::min(head.size(), kReplyHeadMax)));
  }
  if (size == 0) {
    if (buffer_.size() >= kReplyHeadMax) {
      return std::unexpected("sends a part with a head of over 16 kB");
    }
    return false;
  }
  const auto fields = HttpFields::of({reinterpret_cast<const char*>(buffer_.data()), size});
  // A length that is no number is none: the next boundary ends the part.
  const auto length = fields.length("content-length");
  length_ = length ? *length : std::nullopt;
  if (length_ > kStreamedPictureMax) {
    return std::unexpected("sends a picture of " + std::to_string(*length_) +
                           " bytes; at most 16 MB are read");
  }
  drop(size);
  searched_ = 0;
  begun_.reset();
  state_ = State::kBody;
  return true;
}

/// Where the body ends; nothing where its end has not come.
std::optional<std::size_t> Multipart::body_end() {
  if (length_) return buffer_.size() >= *length_ ? length_ : std::nullopt;
  while (true) {
    std::size_t at = find_in(buffer_, searched_, delimiter_);
    if (at == buffer_.size()) {
      searched_ = buffer_.size() - std::min(buffer_.size(), delimiter_.size() - 1);
      return std::nullopt;
    }
    const std::size_t behind = at + delimiter_.size();
    const std::size_t missing = has_at(buffer_, behind, "-") ? 2 : 1;
    if (behind + missing > buffer_.size()) {  // what follows tells whether it is one
      searched_ = at;
      return std::nullopt;
    }
    searched_ = at + 1;
    if (buffer_[behind] > ' ' && !has_at(buffer_, behind, "--")) continue;
    while (at > 0 && buffer_[at - 1] == '-') --at;
    if (at > 0 && buffer_[at - 1] != '\n') continue;  // bytes of the picture that look like one
    if (at > 0) --at;
    if (at > 0 && buffer_[at - 1] == '\r') --at;
    return at;
  }
}

bool Multipart::read_body(std::vector<StreamedPicture>& parts) {
  const auto end = body_end();
  if (!end) return false;
  if (*end > 0 && begun_) {
    parts.push_back(
        {{buffer_.begin(), buffer_.begin() + static_cast<std::ptrdiff_t>(*end)}, *begun_});
  }
  drop(*end);
  searched_ = 0;
  state_ = State::kBoundary;
  return true;
}

std::expected<std::vector<StreamedPicture>, std::string> Multipart::feed(Bytes bytes, Instant now) {
  std::vector<StreamedPicture> parts;
  if (state_ == State::kEnd) return parts;
  buffer_.insert(buffer_.end(), bytes.begin(), bytes.end());
  for (bool goes_on = true; goes_on;) {
    switch (state_) {
      case State::kBoundary:
        goes_on = pass_boundary();
        break;
      case State::kHead: {
        const auto read = read_head();
        if (!read) return std::unexpected(read.error());
        goes_on = *read;
        break;
      }
      case State::kBody:
        if (!begun_ && !buffer_.empty()) begun_ = now;
        goes_on = read_body(parts);
        break;
      case State::kEnd:
        goes_on = false;
        break;
    }
  }
  if (state_ == State::kBody && buffer_.size() > kStreamedPictureMax) {
    return std::unexpected("sends a picture of over 16 MB");
  }
  return parts;
}

std::optional<StreamedPicture> Multipart::end() {
  const bool is_last = state_ == State::kBody && !length_ && begun_;
  state_ = State::kEnd;
  if (!is_last) return std::nullopt;
  return StreamedPicture{std::move(buffer_), *begun_};
}

}  // namespace sinew::vision
