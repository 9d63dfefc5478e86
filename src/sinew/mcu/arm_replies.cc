#include "sinew/mcu/arm_replies.h"

namespace sinew {
namespace mcu {
namespace {

const uint8_t kReady = 0xC8;

}  // namespace

void ReplyBuffer::put_word(int32_t word) {
  for (uint8_t shift = 0; shift < 32; shift = static_cast<uint8_t>(shift + 8)) {
    put(static_cast<uint8_t>(static_cast<uint32_t>(word) >> shift));
  }
}

void ReplyBuffer::put_words(const int32_t* words) {
  for (uint8_t i = 0; i < kArmAxes; ++i) put_word(words[i]);
}

void ReplyBuffer::put_head(uint8_t head) {
  put(head);
  put_text("\r\n");
}

void ReplyBuffer::put_ready(bool data) {
  if (data) put_text("\r\n");
  put_head(kReady);
}

void ReplyBuffer::put_text(const char* text) {
  for (; *text != 0; ++text) put(static_cast<uint8_t>(*text));
}

void ReplyBuffer::put_number(int32_t number) {
  char digits[10];
  uint8_t count = 0;
  uint32_t left = static_cast<uint32_t>(number);
  if (number < 0) {
    put('-');
    left = 0 - left;
  }
  do {
    digits[count++] = static_cast<char>('0' + left % 10);
    left /= 10;
  } while (left > 0);
  while (count > 0) put(static_cast<uint8_t>(digits[--count]));
}

void ReplyBuffer::put_line(const char* name) {
  put_text("BigRobotArm::");
  put_text(name);
  put_text("\r\n");
}

void ReplyBuffer::put_words_line(const char* name, const int32_t* words) {
  static const char* const kLetters[kArmAxes] = {" B", " S", " E", " WR", " W"};
  put_text("BigRobotArm::");
  put_text(name);
  for (uint8_t i = 0; i < kArmAxes; ++i) {
    put_text(kLetters[i]);
    put_number(words[i]);
  }
  put_text("\r\n");
}

}  // namespace mcu
}  // namespace sinew
