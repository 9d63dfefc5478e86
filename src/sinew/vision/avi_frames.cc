#include "sinew/vision/avi_frames.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

#include "sinew/vision/byte_text.h"

namespace sinew::vision {
namespace {

/// A file of nothing but empty chunks is given up after so many.
constexpr int kChunksMax = 100'000;
constexpr std::size_t kHeaderBytes = 8;
constexpr std::size_t kListBytes = 12;

std::uint32_t number_at(Bytes bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= static_cast<std::uint32_t>(bytes[at + i]) << (8 * i);
  }
  return value;
}

std::string letters_at(Bytes bytes, std::size_t at) {
  return {bytes.begin() + static_cast<std::ptrdiff_t>(at),
          bytes.begin() + static_cast<std::ptrdiff_t>(at) + 4};
}

/// Codes of four letters and blanks; what is none comes of a file that was spoiled.
bool is_code(std::string_view id) {
  return std::ranges::all_of(id, [](unsigned char c) { return c >= 0x20 && c < 0x7F; });
}

bool is_opened(const std::string& kind) {
  constexpr std::array<std::string_view, 6> kOpened{"AVI ", "AVIX", "hdrl", "strl", "movi", "rec "};
  return std::ranges::find(kOpened, kind) != kOpened.end();
}

bool is_motion_jpeg(std::string code) {
  std::ranges::transform(code, code.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  constexpr std::array<std::string_view, 5> kCodes{"MJPG", "JPEG", "AVRN", "DMB1", "MJLS"};
  return std::ranges::find(kCodes, code) != kCodes.end();
}

}  // namespace

std::optional<AviFrames::Header> AviFrames::header() const {
  const auto bytes = read_(at_, kListBytes);
  if (bytes.size() < kHeaderBytes) return std::nullopt;
  Header header{letters_at(bytes, 0), number_at(bytes, 4), {}};
  if (!is_code(header.id)) return std::nullopt;
  if (header.id == "RIFF" || header.id == "LIST") {
    if (bytes.size() < kListBytes) return std::nullopt;
    header.kind = letters_at(bytes, kHeaderBytes);
  }
  return header;
}

void AviFrames::pass(const Header& header) {
  // Into lists that may hold frames, whatever length they claim: a recorder writes it at the end.
  at_ += is_opened(header.kind) ? kListBytes
                                : kHeaderBytes + std::uint64_t{header.size} + header.size % 2;
}

std::optional<std::string> AviFrames::read_stream(const Header& header) {
  constexpr std::size_t kEnough = 20;
  if (header.id == "strh") {
    const auto bytes = read_(at_ + kHeaderBytes, std::min<std::size_t>(header.size, kEnough));
    is_in_video_ = video_ < 0 && has_at(bytes, 0, "vids");
    if (is_in_video_) video_ = streams_;
    ++streams_;
  } else if (header.id == "strf" && is_in_video_) {
    is_in_video_ = false;
    // BITMAPINFOHEADER: its coding lies behind size, width, height, planes and bits.
    const auto bytes = read_(at_ + kHeaderBytes, std::min<std::size_t>(header.size, kEnough));
    const std::string code = bytes.size() == kEnough ? letters_at(bytes, 16) : "?";
    if (!is_motion_jpeg(code)) {
      return "an AVI file with video coded as '" + (is_code(code) ? code : "?") +
             "'; Motion JPEG is read. Convert it: ffmpeg -i FILE -c:v mjpeg -q:v 2 OUT.avi";
    }
  }
  return std::nullopt;
}

std::expected<AviFrames, std::string> AviFrames::open(ReadAt read) {
  AviFrames frames(std::move(read));
  const auto first = frames.header();
  if (!first || first->id != "RIFF" || first->kind != "AVI ") {
    return std::unexpected("no AVI file");
  }
  for (int i = 0; i < kChunksMax; ++i) {
    const auto header = frames.header();
    if (!header) break;
    if (header->kind == "movi") break;
    if (auto fault = frames.read_stream(*header)) return std::unexpected(std::move(*fault));
    frames.pass(*header);
  }
  if (frames.video_ < 0 || !frames.header()) {
    return std::unexpected("an AVI file without video in it");
  }
  return frames;
}

std::optional<std::vector<std::uint8_t>> AviFrames::next() {
  const std::string stream{static_cast<char>('0' + video_ / 10 % 10),
                           static_cast<char>('0' + video_ % 10)};
  for (int i = 0; i < kChunksMax; ++i) {
    const auto header = this->header();
    if (!header) return std::nullopt;
    const std::uint64_t data = at_ + kHeaderBytes;
    pass(*header);
    const bool is_frame = header->id == stream + "dc" || header->id == stream + "db";
    if (!is_frame || header->size == 0 || header->size > kFrameMax) continue;
    auto frame = read_(data, header->size);
    if (frame.size() < header->size) return std::nullopt;  // the file was cut off here
    return frame;
  }
  return std::nullopt;
}

}  // namespace sinew::vision
