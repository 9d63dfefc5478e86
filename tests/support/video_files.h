#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sinew/vision/picture.h"
#include "sinew/vision/read_at.h"

/// Video files and pictures for tests.
namespace sinew::test {

using ByteList = std::vector<std::uint8_t>;

inline std::string number_text(std::uint32_t value) {
  std::string text;
  for (int i = 0; i < 4; ++i) text += static_cast<char>(value >> (8 * i) & 0xFFU);
  return text;
}

inline std::string avi_chunk(std::string_view id, std::string_view data) {
  std::string chunk = std::string(id) + number_text(static_cast<std::uint32_t>(data.size()));
  chunk += data;
  if (data.size() % 2 == 1) chunk += '\0';
  return chunk;
}

inline std::string avi_list(std::string_view kind, std::string_view data,
                            std::string_view id = "LIST") {
  return avi_chunk(id, std::string(kind) + std::string(data));
}

/// The description of a stream: "vids" or "auds", and its coding.
inline std::string avi_stream(std::string_view type, std::string_view coding) {
  const std::string format = std::string(16, '\0') + std::string(coding) + std::string(20, '\0');
  return avi_list(
      "strl", avi_chunk("strh", std::string(type) + std::string(coding) + std::string(48, '\0')) +
                  avi_chunk("strf", format));
}

/// A whole file: header, chunks of `movi`, and an index that says nothing.
inline std::string avi_file(std::string_view streams, std::string_view movi) {
  const std::string header =
      avi_list("hdrl", avi_chunk("avih", std::string(56, '\0')) + std::string(streams));
  return avi_list("AVI ", header + avi_list("movi", movi) + avi_chunk("idx1", "0123456789abcdef"),
                  "RIFF");
}

inline std::string text_of(const ByteList& bytes) {
  return {bytes.begin(), bytes.end()};
}

inline ByteList bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

/// A file that is all in memory.
inline vision::ReadAt file_of(std::string text) {
  return [text = std::move(text)](std::uint64_t offset, std::size_t size) {
    if (offset >= text.size()) return ByteList();
    return bytes_of(std::string_view(text).substr(static_cast<std::size_t>(offset), size));
  };
}

/// A picture of one colour, by which frames are told apart.
inline vision::Picture plain_picture(int width, int height, std::uint8_t red, std::uint8_t green,
                                     std::uint8_t blue) {
  vision::Picture picture = vision::black_picture(width, height);
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
    picture.rgb[i] = red;
    picture.rgb[i + 1] = green;
    picture.rgb[i + 2] = blue;
  }
  return picture;
}

/// A JPEG as cameras put it into MJPEG: without its Huffman tables.
inline ByteList without_huffman_tables(const ByteList& jpeg) {
  ByteList result(jpeg.begin(), jpeg.begin() + 2);
  std::size_t at = 2;
  while (at + 4 <= jpeg.size() && jpeg[at] == 0xFF && jpeg[at + 1] != 0xDA) {
    const std::size_t end = at + 2 + 256 * std::size_t{jpeg[at + 2]} + jpeg[at + 3];
    if (jpeg[at + 1] != 0xC4) {
      result.insert(result.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at),
                    jpeg.begin() + static_cast<std::ptrdiff_t>(end));
    }
    at = end;
  }
  result.insert(result.end(), jpeg.begin() + static_cast<std::ptrdiff_t>(at), jpeg.end());
  return result;
}

}  // namespace sinew::test
