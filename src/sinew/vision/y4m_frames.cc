#include "sinew/vision/y4m_frames.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "sinew/vision/byte_text.h"

namespace sinew::vision {
namespace {

constexpr std::size_t kLineMax = 1024;  // bytes; real ones have below 100
constexpr std::string_view kMagic = "YUV4MPEG2";

struct ChromaName {
  std::string_view name;
  Chroma chroma;
};

constexpr std::array<ChromaName, 7> kChromas{{{"420", Chroma::k420Centre},
                                              {"420jpeg", Chroma::k420Centre},
                                              {"420mpeg2", Chroma::k420Left},
                                              {"420paldv", Chroma::k420Left},
                                              {"422", Chroma::k422},
                                              {"444", Chroma::k444},
                                              {"mono", Chroma::kNone}}};

std::string_view text_of_bytes(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// 0 where it is no number of pixels.
int pixels_in(std::string_view digits) {
  int value = 0;
  const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool is_whole = end.ec == std::errc{} && end.ptr == digits.data() + digits.size();
  return is_whole && value > 0 ? value : 0;
}

/// One word of the header; what is wrong with it.
std::optional<std::string> read_word(std::string_view word, PlaneLayout& layout) {
  const std::string_view value = word.substr(1);
  switch (word.front()) {
    case 'W':
      layout.width = pixels_in(value);
      break;
    case 'H':
      layout.height = pixels_in(value);
      break;
    case 'I':
      if (value == "t" || value == "b" || value == "m") {
        return "an interlaced Y4M file; take it out first: ffmpeg -i FILE -vf yadif OUT.y4m";
      }
      break;
    case 'C': {
      const auto known = std::ranges::find(kChromas, value, &ChromaName::name);
      if (known == kChromas.end()) {
        return "a Y4M file with the chroma 'C" + std::string(value) +
               "'; C420, C422, C444 and Cmono are read. Convert it: ffmpeg -i FILE -pix_fmt "
               "yuv420p OUT.y4m";
      }
      layout.chroma = known->chroma;
      break;
    }
    case 'X':
      if (value == "COLORRANGE=FULL") layout.range = LumaRange::kFull;
      break;
    default:
      break;
  }
  return std::nullopt;
}

}  // namespace

std::expected<Y4mHeader, std::string> read_y4m_header(Bytes text) {
  const std::string_view all = text_of_bytes(text.first(std::min(text.size(), kLineMax)));
  const std::size_t end = all.find('\n');
  if (!all.starts_with(kMagic) || end == std::string_view::npos) {
    return std::unexpected("no Y4M file");
  }
  Y4mHeader header{{}, end + 1};
  std::string_view rest = all.substr(kMagic.size(), end - kMagic.size());
  while (!rest.empty()) {
    const std::size_t blank = std::min(rest.find(' '), rest.size());
    const std::string_view word = rest.substr(0, blank);
    rest.remove_prefix(std::min(blank + 1, rest.size()));
    if (word.empty()) continue;
    if (auto fault = read_word(word, header.layout)) return std::unexpected(std::move(*fault));
  }
  if (!frame_bytes(header.layout)) {
    return std::unexpected("a Y4M file without a size, or with frames over 64 million pixels");
  }
  return header;
}

std::expected<Y4mFrames, std::string> Y4mFrames::open(ReadAt read) {
  const auto header = read_y4m_header(read(0, kLineMax));
  if (!header) return std::unexpected(header.error());
  return Y4mFrames(std::move(read), *header);
}

std::optional<Picture> Y4mFrames::next() {
  const auto line = read_(at_, kLineMax);
  const std::string_view text = text_of_bytes(line);
  const std::size_t end = text.find('\n');
  if (!text.starts_with("FRAME") || end == std::string_view::npos) return std::nullopt;
  const std::size_t size = frame_bytes(header_.layout).value_or(0);
  const auto frame = read_(at_ + end + 1, size);
  if (frame.size() < size) return std::nullopt;
  at_ += end + 1 + size;
  auto picture = picture_from_planes(frame, header_.layout);
  if (!picture) return std::nullopt;
  return std::move(*picture);
}

}  // namespace sinew::vision
