#include "maxarm_replies.h"

#include <string.h>

#include "maxarm_frames.h"

namespace sinew_maxarm {
namespace {

constexpr uint8_t kReplyData = 6;
constexpr uint8_t kToSettle = 2;
constexpr uint8_t kToChange = 3;

}  // namespace

bool ReplyParser::push(uint8_t byte, Reply& reply) {
  bytes_[count_++] = byte;
  drop_to_head();
  if (count_ < kReplyFrame) return false;
  const uint8_t spec = checksum_of(bytes_ + 2, kReplyFrame - 3);
  const uint8_t with_header = static_cast<uint8_t>(spec - kHead - kSecond);
  const uint8_t sum = bytes_[kReplyFrame - 1];
  if (sum != spec && sum != with_header) {
    drop_first();
    drop_to_head();
    return false;
  }
  reply.function = bytes_[2];
  for (uint8_t i = 0; i < 3; ++i) {
    const uint8_t* word = bytes_ + 4 + 2 * i;
    reply.values[i] = static_cast<int16_t>(static_cast<uint16_t>(word[0] | (word[1] << 8)));
  }
  reply.checksum = sum == spec ? ReplyChecksum::kSpec : ReplyChecksum::kWithHeader;
  count_ = 0;
  return true;
}

bool ReplyParser::may_be_frame() const {
  if (bytes_[0] != kHead) return false;
  if (count_ > 1 && bytes_[1] != kSecond) return false;
  if (count_ > 2 && bytes_[2] != kReadAngle && bytes_[2] != kReadXyz) return false;
  return count_ <= 3 || bytes_[3] == kReplyData;
}

void ReplyParser::drop_first() {
  --count_;
  memmove(bytes_, bytes_ + 1, count_);
}

void ReplyParser::drop_to_head() {
  while (count_ > 0 && !may_be_frame()) drop_first();
}

bool ChecksumWatch::accept(ReplyChecksum checksum) {
  if (checksum == checksum_) {
    others_ = 0;
    if (agreed_ < kToSettle) ++agreed_;
    return true;
  }
  if (agreed_ < kToSettle) {
    checksum_ = checksum;
    agreed_ = 1;
    return true;
  }
  if (++others_ < kToChange) return false;
  checksum_ = checksum;
  others_ = 0;
  if (changes_ < 255) ++changes_;
  return true;
}

}  // namespace sinew_maxarm
