#include "cli/boot_loader.h"

#include <poll.h>
#include <pty.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <numeric>

namespace sinew::test {
namespace {

constexpr std::uint32_t kFlashBegin = 0x08000000;
constexpr std::uint8_t kSync = 0x7F, kAck = 0x79, kNack = 0x1F;
enum Command : std::uint8_t {
  kGet = 0x00,
  kVersion = 0x01,
  kId = 0x02,
  kRead = 0x11,
  kGo = 0x21,
  kWrite = 0x31,
  kErase = 0x43,
  kExtendedErase = 0x44,
};

std::uint8_t sum_of(const std::vector<std::uint8_t>& bytes) {
  return std::accumulate(bytes.begin(), bytes.end(), std::uint8_t{0},
                         [](std::uint8_t a, std::uint8_t b) { return std::uint8_t(a ^ b); });
}

}  // namespace

BootLoader::BootLoader(Chip chip) : chip_(std::move(chip)) {
  flash_.assign(std::accumulate(chip_.sizes.begin(), chip_.sizes.end(), std::size_t{0}), 0xFF);
  std::array<char, 128> name{};
  termios raw{};
  cfmakeraw(&raw);
  if (openpty(&master_, &held_, name.data(), &raw, nullptr) == 0) port_ = name.data();
  thread_ = std::thread([this] { serve(); });
}

BootLoader::~BootLoader() {
  ends_ = true;
  thread_.join();
  close(master_);
  close(held_);
}

std::vector<std::uint8_t> BootLoader::flash() const {
  const std::scoped_lock lock(mutex_);
  return flash_;
}

void BootLoader::put(std::size_t place, const std::vector<std::uint8_t>& bytes) {
  const std::scoped_lock lock(mutex_);
  std::ranges::copy(bytes, flash_.begin() + static_cast<std::ptrdiff_t>(place));
}

std::optional<std::uint32_t> BootLoader::started() const {
  const std::scoped_lock lock(mutex_);
  return started_;
}

bool BootLoader::spoiled() const {
  const std::scoped_lock lock(mutex_);
  return spoiled_;
}

std::optional<std::uint8_t> BootLoader::next() {
  while (!ends_) {
    pollfd ready{master_, POLLIN, 0};
    if (poll(&ready, 1, 20) <= 0 || (ready.revents & POLLIN) == 0) continue;
    std::uint8_t byte = 0;
    if (read(master_, &byte, 1) == 1) return byte;
  }
  return std::nullopt;
}

std::optional<std::vector<std::uint8_t>> BootLoader::next(std::size_t count) {
  std::vector<std::uint8_t> bytes;
  while (bytes.size() < count) {
    const auto byte = next();
    if (!byte) return std::nullopt;
    bytes.push_back(*byte);
  }
  return bytes;
}

void BootLoader::say(const std::vector<std::uint8_t>& bytes) const {
  static_cast<void>(!write(master_, bytes.data(), bytes.size()));
}

void BootLoader::answer(bool good) const {
  say({good ? kAck : kNack});
}

void BootLoader::serve() {
  bool heard = false;
  while (const auto byte = next()) {
    if (chip_.dies_at && written_ >= *chip_.dies_at) continue;
    if (!heard) {
      heard = *byte == kSync;
      if (heard) answer(true);
      continue;
    }
    // Heard once, it is no command that is known.
    if (*byte == kSync) {
      answer(false);
      continue;
    }
    const auto complement = next();
    if (!complement) return;
    const bool good = (*byte ^ *complement) == 0xFF;
    good ? carry_out(*byte) : answer(false);
  }
}

void BootLoader::carry_out(std::uint8_t command) {
  const std::uint8_t own_erase = chip_.extended_erase ? kExtendedErase : kErase;
  const bool closed = chip_.read_protected && (command == kRead || command == kWrite ||
                                               command == own_erase || command == kGo);
  if (closed) return answer(false);
  switch (command) {
    case kGet:
      return say({kAck, 11, 0x22, kGet, kVersion, kId, kRead, kGo, kWrite, own_erase, 0x63, 0x73,
                  0x82, 0x92, kAck});
    case kVersion:
      return say({kAck, 0x22, 0, 0, kAck});
    case kId:
      return say({kAck, 1, static_cast<std::uint8_t>(chip_.id >> 8),
                  static_cast<std::uint8_t>(chip_.id & 0xFF), kAck});
    case kRead:
      return read_memory();
    case kWrite:
      return write_memory();
    case kGo:
      answer(true);
      if (const auto at = address()) {
        const std::scoped_lock lock(mutex_);
        started_ = *at;
      }
      return;
    default:
      return command == own_erase ? erase() : answer(false);
  }
}

std::optional<std::uint32_t> BootLoader::address() {
  const auto bytes = next(5);
  if (!bytes || sum_of(*bytes) != 0) {
    answer(false);
    return std::nullopt;
  }
  answer(true);
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | (*bytes)[i];
  return value;
}

void BootLoader::read_memory() {
  answer(true);
  const auto at = address();
  const auto count = at ? next(2) : std::nullopt;
  if (!count) return;
  const std::size_t size = (*count)[0] + std::size_t{1};
  const std::scoped_lock lock(mutex_);
  const bool inside = *at >= kFlashBegin && *at - kFlashBegin + size <= flash_.size();
  if (((*count)[0] ^ (*count)[1]) != 0xFF || !inside) return answer(false);
  std::vector<std::uint8_t> bytes{kAck};
  const auto first = flash_.begin() + (*at - kFlashBegin);
  bytes.insert(bytes.end(), first, first + static_cast<std::ptrdiff_t>(size));
  say(bytes);
}

void BootLoader::write_memory() {
  answer(true);
  const auto at = address();
  const auto count = at ? next() : std::nullopt;
  auto data = count ? next(*count + std::size_t{2}) : std::nullopt;
  if (!data) return;
  std::uint8_t sum = *count;
  for (const std::uint8_t byte : *data) sum ^= byte;
  data->pop_back();
  const std::scoped_lock lock(mutex_);
  const bool inside = *at >= kFlashBegin && *at - kFlashBegin + data->size() <= flash_.size();
  if (sum != 0 || !inside || *at % 4 != 0) return answer(false);
  for (std::size_t i = 0; i < data->size(); ++i) {
    std::uint8_t& cell = flash_[*at - kFlashBegin + i];
    spoiled_ = spoiled_ || cell != 0xFF;
    cell &= (*data)[i];
  }
  written_ += data->size();
  if (!chip_.dies_at || written_ < *chip_.dies_at) answer(true);
}

void BootLoader::erase() {
  answer(true);
  const std::size_t width = chip_.extended_erase ? 2 : 1;
  const auto head = next(width);
  if (!head) return;
  std::size_t count = 0;
  for (const std::uint8_t byte : *head) count = count << 8 | byte;
  if (count == (chip_.extended_erase ? 0xFFFFU : 0xFFU)) {
    if (!next()) return;
    for (std::size_t page = 0; page < chip_.sizes.size(); ++page) erase_page(page);
    return answer(true);
  }
  const auto pages = next((count + 1) * width + 1);
  if (!pages) return;
  if ((sum_of(*pages) ^ sum_of(*head)) != 0) return answer(false);
  for (std::size_t i = 0; i <= count; ++i) {
    std::size_t page = 0;
    for (std::size_t k = 0; k < width; ++k) page = page << 8 | (*pages)[i * width + k];
    erase_page(page);
  }
  answer(true);
}

void BootLoader::erase_page(std::size_t page) {
  if (page >= chip_.sizes.size()) return;
  const auto begin =
      std::accumulate(chip_.sizes.begin(), chip_.sizes.begin() + static_cast<std::ptrdiff_t>(page),
                      std::ptrdiff_t{0});
  const std::scoped_lock lock(mutex_);
  std::fill_n(flash_.begin() + begin, chip_.sizes[page], std::uint8_t{0xFF});
}

}  // namespace sinew::test
