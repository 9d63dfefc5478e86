#pragma once

#include <cstdint>
#include <expected>
#include <optional>
#include <string>
#include <vector>

#include "sinew/vision/read_at.h"

namespace sinew::vision {

/// The frames of an AVI file with Motion JPEG, one after the other.
/// Source: Microsoft, AVI RIFF File Reference; OpenDML AVI File Format Extensions 1.02. The index
/// is not read and the lengths of lists are not believed, so that files of a recorder that was
/// switched off are read to their last whole frame.
class AviFrames {
 public:
  static constexpr std::size_t kFrameMax = std::size_t{16} << 20U;  ///< bytes

  /// @error  a sentence: no AVI file, no video in it, coded otherwise than as Motion JPEG
  static std::expected<AviFrames, std::string> open(ReadAt read);

  /// The next frame as a JPEG file, which may lack its Huffman tables; frames that were dropped
  /// while recording (of no bytes) and frames over kFrameMax are passed over. Nothing at the end.
  std::optional<std::vector<std::uint8_t>> next();

 private:
  struct Header {
    std::string id;
    std::uint32_t size = 0;
    std::string kind;  ///< of a list; empty otherwise
  };

  explicit AviFrames(ReadAt read) : read_(std::move(read)) {}
  std::optional<Header> header() const;
  void pass(const Header& header);
  std::optional<std::string> read_stream(const Header& header);

  ReadAt read_;
  std::uint64_t at_ = 0;      ///< where the next header begins
  int streams_ = 0;           ///< so many were described
  int video_ = -1;            ///< which of them is read
  bool is_in_video_ = false;  ///< while its headers are read
};

}  // namespace sinew::vision
