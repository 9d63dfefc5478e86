#include "firmware/emulation/stm32_serial.h"

namespace sinew::emulation {
namespace {

// SPI
constexpr std::uint32_t kCr1 = 0x00;
constexpr std::uint32_t kSpiOn = 1U << 6;

// I2C
constexpr std::uint32_t kCr2 = 0x04;
constexpr std::uint32_t kData = 0x10;
constexpr std::uint32_t kStatus1 = 0x14;
constexpr std::uint32_t kStatus2 = 0x18;
constexpr std::uint32_t kClock = 0x1C;
constexpr std::uint32_t kRise = 0x20;
constexpr std::uint32_t kStart = 1U << 8;
constexpr std::uint32_t kStop = 1U << 9;
constexpr std::uint32_t kAcknowledge = 1U << 10;
constexpr std::uint32_t kReset = 1U << 15;
constexpr std::uint32_t kStarted = 1;
constexpr std::uint32_t kAddressed = 1U << 1;
constexpr std::uint32_t kByteDone = 1U << 2;
constexpr std::uint32_t kReceived = 1U << 6;
constexpr std::uint32_t kEmpty = 1U << 7;
constexpr std::uint32_t kRefused = 1U << 10;
constexpr Cycles kByte = 9;  // bits, the acknowledgement among them
constexpr std::uint32_t kBitHz = 400'000;

}  // namespace

void Stm32SpiSlave::write(std::uint32_t offset, std::uint32_t value) {
  word_[offset / 4] = value;
  fetch();
}

void Stm32SpiSlave::reset() {
  word_ = {};
  waiting_ = false;
}

void Stm32SpiSlave::fetch() {
  const bool on = (word_[kCr1] & kSpiOn) != 0 && (word_[1] & 0b10) != 0;
  if (!on || waiting_ || !out.enabled || out.left == 0) return;
  next_ = core_.load_byte(out.memory++);
  --out.left;
  waiting_ = true;
}

void Stm32SpiSlave::begin(std::span<const std::uint8_t> mosi, Cycles per_byte) {
  mosi_.assign(mosi.begin(), mosi.end());
  miso_.clear();
  begun_ = core_.now();
  per_byte_ = per_byte;
  core_.look_again();
}

std::optional<Cycles> Stm32SpiSlave::next_event() const {
  if (miso_.size() == mosi_.size()) return std::nullopt;
  return begun_ + (miso_.size() + 1) * per_byte_;
}

void Stm32SpiSlave::advance(Cycles now) {
  while (miso_.size() < mosi_.size() && begun_ + (miso_.size() + 1) * per_byte_ <= now) {
    miso_.push_back(clock(mosi_[miso_.size()]));
  }
}

std::uint8_t Stm32SpiSlave::clock(std::uint8_t mosi) {
  if ((word_[kCr1] & kSpiOn) == 0) return 0xFF;
  if (waiting_) last_ = next_;
  waiting_ = false;
  fetch();
  if (in.enabled && in.left > 0) {
    core_.store_byte(in.memory++, mosi);
    --in.left;
  }
  return last_;
}

void Stm32I2c::reset() {
  cr1_ = cr2_ = ccr_ = trise_ = sr1_ = 0;
  doing_ = Doing::kNothing;
  done_at_.reset();
  data_full_ = shift_full_ = last_ = false;
}

void Stm32I2c::start(Doing what, Cycles bits) {
  doing_ = what;
  if (data_held_low) {
    done_at_.reset();
    return;
  }
  done_at_ = core_.now() + bits * (core_.clock_hz() / kBitHz);
}

void Stm32I2c::receive_next() {
  if (last_ || shift_full_ || (doing_ != Doing::kNothing)) return;
  start(Doing::kRead, kByte);
}

void Stm32I2c::finish() {
  const Doing what = doing_;
  doing_ = Doing::kNothing;
  done_at_.reset();
  switch (what) {
    case Doing::kNothing:
      break;
    case Doing::kStart:
      cr1_ &= ~kStart;
      sr1_ |= kStarted;
      break;
    case Doing::kAddress: {
      reads_ = (data_ & 1) != 0;
      const bool there = chip != nullptr && chip->acknowledges(data_ >> 1);
      sr1_ |= there ? kAddressed : kRefused;
      if (there && !reads_) chip->begin_write();
      break;
    }
    case Doing::kWrite:
      chip->put(shift_);
      if (data_full_) {
        shift_ = data_;
        data_full_ = false;
        sr1_ |= kEmpty;
        start(Doing::kWrite, kByte);
      } else {
        sr1_ |= kByteDone;
      }
      break;
    case Doing::kRead: {
      const std::uint8_t byte = chip->get();
      last_ = (cr1_ & kAcknowledge) == 0;
      if (data_full_) {
        shift_ = byte;
        shift_full_ = true;
        sr1_ |= kByteDone;
      } else {
        data_ = byte;
        data_full_ = true;
        sr1_ |= kReceived;
        receive_next();
      }
      break;
    }
    case Doing::kStop:
      cr1_ &= ~kStop;
      break;
  }
  if ((cr1_ & kStop) != 0 && doing_ == Doing::kNothing) start(Doing::kStop, 1);
}

void Stm32I2c::advance(Cycles now) {
  while (done_at_ && *done_at_ <= now) finish();
}

std::uint32_t Stm32I2c::read(std::uint32_t offset) {
  switch (offset) {
    case kCr1:
      return cr1_;
    case kCr2:
      return cr2_;
    case kStatus1:
      status_read_ = true;
      return sr1_;
    case kStatus2:
      if (status_read_ && (sr1_ & kAddressed) != 0) {
        sr1_ &= ~kAddressed;
        data_full_ = shift_full_ = last_ = false;
        if (reads_) {
          receive_next();
        } else {
          sr1_ |= kEmpty;
        }
      }
      status_read_ = false;
      return 0;
    case kData: {
      const std::uint8_t byte = data_;
      sr1_ &= ~(kReceived | kByteDone);
      data_full_ = false;
      if (shift_full_) {
        data_ = shift_;
        data_full_ = true;
        shift_full_ = false;
        sr1_ |= kReceived;
      }
      if (reads_) receive_next();
      return byte;
    }
    case kClock:
      return ccr_;
    case kRise:
      return trise_;
    default:
      return 0;
  }
}

void Stm32I2c::write(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case kCr1:
      if ((value & kReset) != 0) return reset();
      cr1_ = value;
      if ((value & kStop) != 0 && doing_ == Doing::kNothing) {
        sr1_ &= ~(kEmpty | kByteDone);
        start(Doing::kStop, 1);
      } else if ((value & kStart) != 0 && doing_ == Doing::kNothing) {
        sr1_ &= ~(kEmpty | kByteDone | kReceived);
        start(Doing::kStart, 2);
      }
      break;
    case kCr2:
      cr2_ = value;
      break;
    case kData:
      if ((sr1_ & kStarted) != 0) {
        sr1_ &= ~kStarted;
        data_ = static_cast<std::uint8_t>(value);
        start(Doing::kAddress, kByte);
      } else if (doing_ == Doing::kNothing) {
        sr1_ = (sr1_ & ~kByteDone) | kEmpty;
        shift_ = static_cast<std::uint8_t>(value);
        start(Doing::kWrite, kByte);
      } else {
        sr1_ &= ~kEmpty;
        data_ = static_cast<std::uint8_t>(value);
        data_full_ = true;
      }
      break;
    case kStatus1:
      sr1_ &= value | ~0xFF00U;
      break;
    case kClock:
      ccr_ = value;
      break;
    case kRise:
      trise_ = value;
      break;
    default:
      break;
  }
}

}  // namespace sinew::emulation
