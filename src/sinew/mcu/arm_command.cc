#include "sinew/mcu/arm_command.h"

#include "sinew/mcu/bytes.h"

namespace sinew {
namespace mcu {
namespace {

constexpr uint8_t kEnd = 0x0D;
const uint8_t kByteIds = 12;
/// Bytes of a request by its id; 0: there is none.
const uint8_t kByteSizes[kByteIds] = {0, 21, 1, 1, 21, 21, 3, 2, 1, 0, 0, 1};
const CommandKind kByteKinds[kByteIds] = {
    CommandKind::kInvalid, CommandKind::kGoto,          CommandKind::kHome,    CommandKind::kReset,
    CommandKind::kSpeeds,  CommandKind::kAccelerations, CommandKind::kGripper, CommandKind::kSync,
    CommandKind::kStatus,  CommandKind::kInvalid,       CommandKind::kInvalid, CommandKind::kStop};

/// A run of characters in a line.
struct Word {
  const char* text;
  uint8_t size;
};

Word next_word(Word& rest) {
  while (rest.size > 0 && *rest.text == ' ') ++rest.text, --rest.size;
  Word word = {rest.text, 0};
  while (rest.size > 0 && *rest.text != ' ') ++rest.text, --rest.size, ++word.size;
  return word;
}

bool is(const Word& word, const char* text) {
  uint8_t i = 0;
  for (; text[i] != 0; ++i) {
    if (i >= word.size || word.text[i] != text[i]) return false;
  }
  return i == word.size;
}

/// A letter and a number: G00 is G0.
bool is_code(Word word, char letter, const char* number) {
  if (word.size < 2 || word.text[0] != letter) return false;
  ++word.text, --word.size;
  while (word.size > 1 && *word.text == '0') ++word.text, --word.size;
  return is(word, number);
}

/// The number behind `letters` characters; saturates, and ends at the first other character.
int32_t number_of(Word word, uint8_t letters) {
  const uint32_t most = 0x7FFFFFFF;
  uint8_t i = letters;
  const bool negative = i < word.size && word.text[i] == '-';
  if (i < word.size && (negative || word.text[i] == '+')) ++i;
  uint32_t value = 0;
  for (; i < word.size && word.text[i] >= '0' && word.text[i] <= '9'; ++i) {
    const uint8_t digit = static_cast<uint8_t>(word.text[i] - '0');
    value = value > (most - digit) / 10 ? most : value * 10 + digit;
  }
  return negative ? -static_cast<int32_t>(value) : static_cast<int32_t>(value);
}

/// Words are known by their place: " B1 S2 E3 WR4 W5".
void take_words(Word rest, ArmCommand& out) {
  const uint8_t wrist_rotate = 3;
  for (out.given = 0; out.given < kArmAxes; ++out.given) {
    const Word word = next_word(rest);
    if (word.size == 0) return;
    out.words[out.given] = number_of(word, out.given == wrist_rotate ? 2 : 1);
  }
}

struct Code {
  char letter;
  const char* number;
  CommandKind kind;
};
const Code kCodes[] = {{'G', "0", CommandKind::kGoto},
                       {'G', "28", CommandKind::kHome},
                       {'G', "92", CommandKind::kReset},
                       {'M', "203", CommandKind::kSpeeds},
                       {'M', "201", CommandKind::kAccelerations},
                       {'G', "1", CommandKind::kGripper},
                       {'M', "503", CommandKind::kStatus},
                       {'M', "410", CommandKind::kStop},
                       {'Q', "0", CommandKind::kQueueGoto}};

CommandKind kind_of(const Word& name) {
  for (const Code& code : kCodes) {
    if (is_code(name, code.letter, code.number)) return code.kind;
  }
  if (is(name, "BEGIN")) return CommandKind::kBegin;
  if (is(name, "END")) return CommandKind::kEnd;
  if (is(name, "QFLUSH")) return CommandKind::kQueueFlush;
  if (is(name, "QCLEAR")) return CommandKind::kQueueClear;
  // As the firmware has it: whatever begins so.
  const bool sync = name.size > 0 && name.text[0] == 'S';
  return sync ? CommandKind::kSync : CommandKind::kInvalid;
}

/// One line of text, without its end.
ArmCommand read_line(const char* line, uint8_t size) {
  Word rest = {line, size};
  const Word name = next_word(rest);
  ArmCommand out = {};
  out.kind = kind_of(name);
  switch (out.kind) {
    case CommandKind::kGoto:
    case CommandKind::kQueueGoto:
    case CommandKind::kSpeeds:
    case CommandKind::kAccelerations:
      take_words(rest, out);
      break;
    case CommandKind::kGripper: {
      out.on = number_of(next_word(rest), 1) == 1;
      const int32_t position = number_of(next_word(rest), 1);
      out.position = static_cast<uint8_t>(position < 0 ? 0 : position > 255 ? 255 : position);
      break;
    }
    case CommandKind::kSync:
      out.on = number_of(name, 1) != 0;
      break;
    case CommandKind::kBegin:
      out.repeats = static_cast<int8_t>(number_of(next_word(rest), 1) & 0xFF);
      break;
    default:
      break;
  }
  return out;
}

}  // namespace

CommandKind ByteReader::push(uint8_t byte) {
  if (unknown_) return read_unknown(byte);
  if (size_ == 0) {
    if (byte >= kByteIds || kByteSizes[byte] == 0) return read_unknown(byte);
  } else if (size_ == kByteSizes[bytes_[0]]) {
    size_ = 0;
    return byte == kEnd ? read() : read_unknown(byte);
  }
  bytes_[size_++] = byte;
  return CommandKind::kNone;
}

/// What is no request ends like one.
CommandKind ByteReader::read_unknown(uint8_t byte) {
  unknown_ = byte != kEnd;
  if (unknown_) return CommandKind::kNone;
  command_ = {};
  return command_.kind = CommandKind::kInvalid;
}

CommandKind ByteReader::read() {
  command_ = {};
  command_.kind = kByteKinds[bytes_[0]];
  if (kByteSizes[bytes_[0]] == kLongest) {
    command_.given = kArmAxes;
    for (uint8_t i = 0; i < kArmAxes; ++i) {
      command_.words[i] = static_cast<int32_t>(get_u32(bytes_ + 1 + 4 * i));
    }
  }
  if (command_.kind == CommandKind::kGripper) {
    command_.on = bytes_[1] == 1;
    command_.position = bytes_[2];
  }
  if (command_.kind == CommandKind::kSync) command_.on = bytes_[1] != 0;
  return command_.kind;
}

CommandKind LineReader::push(char character) {
  if (over_) reset();
  if (character != '\r') {
    if (size_ < kLongest) line_[size_++] = character;
    return CommandKind::kNone;
  }
  over_ = true;
  command_ = read_line(line_, size_);
  return command_.kind;
}

}  // namespace mcu
}  // namespace sinew
