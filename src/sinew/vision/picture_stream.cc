#include "sinew/vision/picture_stream.h"

#include <algorithm>
#include <cctype>

#include "sinew/vision/byte_text.h"

namespace sinew::vision {
namespace {

constexpr std::string_view kOtherPath =
    "; the pictures of most camera apps are at /video, /videofeed or /stream";

/// Text of a server, for a sentence: without control characters, and not too long.
std::string shown(std::string_view text) {
  constexpr std::size_t kShownMax = 100;
  std::string result(text.substr(0, kShownMax));
  std::ranges::replace_if(
      result, [](unsigned char c) { return std::iscntrl(c) != 0 || c >= 0x7F; }, '?');
  return result;
}

/// Why there are no pictures in a reply with this status.
std::string status_fault(const HttpReplyHead& head) {
  const std::string fault = "replies " + std::to_string(head.status) + " " + shown(head.reason);
  if (head.status == 401) {
    const std::string scheme = lower_letters(head.fields.value("www-authenticate"));
    return fault + (scheme.starts_with("digest")
                        ? "; it asks for digest authentication. Choose basic authentication, or "
                          "none, in the camera's settings"
                        : "; write its user and password: http://USER:PASSWORD@HOST/PATH");
  }
  if (head.status >= 300 && head.status < 400) {
    const std::string where = shown(head.fields.value("location"));
    return fault + (where.empty() ? std::string() : "; give its other address: " + where);
  }
  return fault + std::string(head.status == 404 ? kOtherPath : std::string_view());
}

bool may_be_picture(const std::string& type) {
  return type.empty() || type.starts_with("image/") || type.starts_with("application/octet-stream");
}

}  // namespace

std::expected<void, std::string> PictureStream::begin(const HttpReplyHead& head) {
  if (head.status != 200) return std::unexpected(status_fault(head));
  const std::string_view value = head.fields.value("content-type");
  const std::string type = lower_letters(value);
  if (type.starts_with("multipart/")) {
    auto parts = Multipart::with_boundary(field_parameter(value, "boundary"));
    if (!parts) return std::unexpected(parts.error());
    parts_ = std::move(*parts);
  } else if (!may_be_picture(type)) {
    return std::unexpected("replies with '" + shown(type) + "', which is no picture" +
                           std::string(kOtherPath));
  }
  auto body = HttpBody::of(head.fields);
  if (!body) return std::unexpected(body.error());
  body_ = std::move(*body);
  return {};
}

/// Whether the head is whole; what came behind it stays in head_.
std::expected<bool, std::string> PictureStream::read_head() {
  const std::size_t size = head_bytes(Bytes(head_).first(std::min(head_.size(), kReplyHeadMax)));
  if (size == 0) {
    constexpr std::string_view kMark = "HTTP/1.";
    const bool is_http = has_at(head_, 0, kMark.substr(0, std::min(kMark.size(), head_.size())));
    if (!is_http) return std::unexpected("replies with something other than HTTP");
    if (head_.size() >= kReplyHeadMax) return std::unexpected("replies with an endless head");
    return false;
  }
  const auto head = read_reply_head({reinterpret_cast<const char*>(head_.data()), size});
  if (!head) return std::unexpected(head.error());
  head_.erase(head_.begin(), head_.begin() + static_cast<std::ptrdiff_t>(size));
  if (head->status < 200) return head_.empty() ? false : read_head();  // 100 Continue
  if (auto begun = begin(*head); !begun) return std::unexpected(begun.error());
  return true;
}

std::expected<std::vector<StreamedPicture>, std::string> PictureStream::feed(Bytes bytes,
                                                                             Instant now) {
  std::vector<std::uint8_t> rest;
  if (!body_) {
    head_.insert(head_.end(), bytes.begin(), bytes.end());
    const auto is_whole = read_head();
    if (!is_whole) return std::unexpected(is_whole.error());
    if (!*is_whole) return std::vector<StreamedPicture>();
    rest.swap(head_);
    bytes = rest;
  }
  std::vector<std::uint8_t> body;
  if (auto fed = body_->feed(bytes, body); !fed) return std::unexpected(fed.error());
  if (parts_) {
    auto parts = parts_->feed(body, now);
    is_over_ = body_->is_whole();
    return parts;
  }
  if (!begun_ && !body.empty()) begun_ = now;
  if (single_.size() + body.size() > kStreamedPictureMax) {
    return std::unexpected("sends a picture of over 16 MB");
  }
  single_.insert(single_.end(), body.begin(), body.end());
  return body_->is_whole() ? end() : std::vector<StreamedPicture>();
}

std::vector<StreamedPicture> PictureStream::end() {
  std::vector<StreamedPicture> last;
  if (is_over_) return last;
  is_over_ = true;
  if (parts_) {
    if (auto part = parts_->end()) last.push_back(std::move(*part));
  } else if (begun_) {
    last.push_back({std::move(single_), *begun_});
  }
  return last;
}

}  // namespace sinew::vision
