#pragma once

#include <stdint.h>

#include "sinew/mcu/step_pulses.h"

namespace sinew {
namespace mcu {

/// Bytes for the host that have not left yet. What does not fit is dropped whole by who writes:
/// nothing is begun without room for the longest reply.
class ReplyBuffer {
 public:
  static constexpr uint16_t kSize = 1024;
  static constexpr uint16_t kLongest = 560;

  bool has_room() const { return size_ + kLongest <= kSize; }
  bool empty() const { return size_ == 0; }
  void put(uint8_t byte) {
    if (size_ == kSize) return;
    bytes_[(first_ + size_) % kSize] = byte;
    ++size_;
  }
  uint8_t take() {
    const uint8_t byte = bytes_[first_];
    first_ = static_cast<uint16_t>((first_ + 1) % kSize);
    --size_;
    return byte;
  }

  // Of the byte wire.
  void put_word(int32_t word);
  void put_words(const int32_t* words);
  /// A head with its line end.
  void put_head(uint8_t head);
  /// The data's line end, if there was data, and READY.
  void put_ready(bool data = true);

  // Of the text wire.
  void put_text(const char* text);
  void put_number(int32_t number);
  /// "BigRobotArm::" `name` and a line end.
  void put_line(const char* name);
  /// "BigRobotArm::" `name` " B1 S2 E3 WR4 W5" and a line end.
  void put_words_line(const char* name, const int32_t* words);

 private:
  uint8_t bytes_[kSize] = {};
  uint16_t first_ = 0;
  uint16_t size_ = 0;
};

}  // namespace mcu
}  // namespace sinew
