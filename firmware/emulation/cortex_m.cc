#include "firmware/emulation/cortex_m.h"

#include <unicorn/unicorn.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace sinew::emulation {
namespace {

constexpr std::uint32_t kCore = 0xE000'E000;
constexpr std::uint32_t kBlock = 0x400;  // bytes of registers that a peripheral has

// Of the system control space, from kCore on.
constexpr std::uint32_t kSetEnable = 0x100;
constexpr std::uint32_t kClearEnable = 0x180;
constexpr std::uint32_t kSetPending = 0x200;
constexpr std::uint32_t kClearPending = 0x280;
constexpr std::uint32_t kPriority = 0x400;
constexpr std::uint32_t kVectorTable = 0xD08;
constexpr std::uint32_t kResetControl = 0xD0C;
constexpr std::uint32_t kResetKey = 0x05FA'0004;

constexpr std::uint32_t kReturnToThread = 0xFFFF'FFF9;
constexpr std::uint32_t kReturnToHandler = 0xFFFF'FFF1;
constexpr int kFirstLine = 16;  // vectors of the core stand before the lines
constexpr Cycles kEntry = 12;   // Cortex-M3 TRM, interrupt latency
constexpr std::uint32_t kThumb = 1U << 24;
constexpr std::uint8_t kSpoilt = 0xA5;
/// Flags, and how far an IT instruction has come: the same bits in xPSR and in libunicorn's CPSR.
constexpr std::uint32_t kFlags = 0xF800'0000;
constexpr std::uint32_t kConditional = 0x0600'FC00;

void check(uc_err error, const char* what) {
  if (error == UC_ERR_OK) return;
  std::fprintf(stderr, "libunicorn: %s: %s\n", what, uc_strerror(error));
  std::abort();
}

}  // namespace

/// What libunicorn calls back with.
struct CortexM::Bus {
  CortexM* core;
  std::unordered_map<std::uint32_t, Peripheral*> peripherals;

  Peripheral* at(std::uint32_t address) {
    const auto found = peripherals.find(address / kBlock);
    return found == peripherals.end() ? nullptr : found->second;
  }
  std::uint32_t read(std::uint32_t address) {
    Peripheral* const peripheral = at(address);
    if (peripheral == nullptr) {
      core->fail("read where nothing is: " + std::to_string(address));
      return 0;
    }
    peripheral->advance(core->now_);
    return peripheral->read(address % kBlock);
  }
  void write(std::uint32_t address, std::uint32_t value) {
    Peripheral* const peripheral = at(address);
    if (peripheral == nullptr) {
      core->fail("written where nothing is: " + std::to_string(address));
      return;
    }
    peripheral->advance(core->now_);
    peripheral->write(address % kBlock, value);
    core->look_again_ = true;
  }

  static std::uint64_t on_read(uc_engine*, std::uint64_t offset, unsigned, void* data) {
    return static_cast<Bus*>(data)->read(0x4000'0000 + static_cast<std::uint32_t>(offset));
  }
  static void on_write(uc_engine*, std::uint64_t offset, unsigned, std::uint64_t value,
                       void* data) {
    static_cast<Bus*>(data)->write(0x4000'0000 + static_cast<std::uint32_t>(offset),
                                   static_cast<std::uint32_t>(value));
  }
  static std::uint64_t on_core_read(uc_engine*, std::uint64_t offset, unsigned, void* data) {
    return static_cast<Bus*>(data)->core->core_read(static_cast<std::uint32_t>(offset));
  }
  static void on_core_write(uc_engine*, std::uint64_t offset, unsigned, std::uint64_t value,
                            void* data) {
    static_cast<Bus*>(data)->core->core_write(static_cast<std::uint32_t>(offset),
                                              static_cast<std::uint32_t>(value));
  }
  static void on_flash(uc_engine*, uc_mem_type, std::uint64_t address, int size, std::int64_t value,
                       void* data) {
    static_cast<Bus*>(data)->core->on_flash_write(static_cast<std::uint32_t>(address),
                                                  static_cast<std::uint32_t>(value),
                                                  static_cast<unsigned>(size));
  }
  static void on_block(uc_engine*, std::uint64_t address, std::uint32_t size, void* data) {
    static_cast<Bus*>(data)->core->block(static_cast<std::uint32_t>(address), size);
  }
};

CortexM::CortexM(const Settings& settings) : bus_(new Bus{this, {}}), settings_(settings) {
  check(uc_open(UC_ARCH_ARM, static_cast<uc_mode>(UC_MODE_THUMB | UC_MODE_MCLASS), &uc_), "open");
  check(uc_ctl_set_cpu_model(uc_, UC_CPU_ARM_CORTEX_M3), "model");
  check(uc_mem_map(uc_, settings.flash_at, settings.flash_size, UC_PROT_ALL), "flash");
  check(uc_mem_map(uc_, settings.ram_at, settings.ram_size, UC_PROT_READ | UC_PROT_WRITE), "ram");
  check(uc_mmio_map(uc_, 0x4000'0000, 0x0003'0000, Bus::on_read, bus_.get(), Bus::on_write,
                    bus_.get()),
        "registers");
  check(uc_mmio_map(uc_, kCore, 0x1000, Bus::on_core_read, bus_.get(), Bus::on_core_write,
                    bus_.get()),
        "core registers");
  uc_hook hook = 0;
  check(uc_hook_add(uc_, &hook, UC_HOOK_BLOCK, reinterpret_cast<void*>(Bus::on_block), bus_.get(),
                    1, 0),
        "hook");
  check(uc_hook_add(uc_, &hook, UC_HOOK_MEM_WRITE, reinterpret_cast<void*>(Bus::on_flash),
                    bus_.get(), settings.flash_at, settings.flash_at + settings.flash_size - 1),
        "hook");
  flash({});
  spoil_memory();
}

void CortexM::stop() {
  stop_wanted_ = true;
  uc_emu_stop(uc_);
}

void CortexM::fail(std::string why) {
  broken_ = std::move(why);
  uc_emu_stop(uc_);
}

CortexM::~CortexM() {
  uc_close(uc_);
}

void CortexM::flash(std::span<const std::uint8_t> image) {
  std::vector<std::uint8_t> all(settings_.flash_size, 0xFF);
  std::copy_n(image.begin(), std::min(image.size(), all.size()), all.begin());
  check(uc_mem_write(uc_, settings_.flash_at, all.data(), all.size()), "flash");
  counted_.clear();
}

void CortexM::spoil_memory() {
  for (std::uint32_t i = 0; i < settings_.ram_size; ++i) store_byte(settings_.ram_at + i, kSpoilt);
}

/// Between data and stack lies the longest stretch that was never written.
std::uint32_t CortexM::stack_depth() const {
  std::uint32_t longest = 0;
  std::uint32_t end_of_longest = settings_.ram_size;
  std::uint32_t run = 0;
  for (std::uint32_t i = 0; i < settings_.ram_size; ++i) {
    run = load_byte(settings_.ram_at + i) == kSpoilt ? run + 1 : 0;
    if (run <= longest) continue;
    longest = run;
    end_of_longest = i + 1;
  }
  return settings_.ram_size - end_of_longest;
}

void CortexM::map(std::uint32_t address, Peripheral& peripheral) {
  bus_->peripherals[address / kBlock] = &peripheral;
}

void CortexM::reset() {
  for (Line& line : lines_) line = Line{};
  frames_.clear();
  waiting_ = false;
  choose_line();
  vectors_ = settings_.flash_at;
  const std::uint32_t stack = load_word(vectors_);
  set_reg(UC_ARM_REG_SP, stack);
  set_reg(UC_ARM_REG_LR, 0xFFFF'FFFF);
  set_reg(UC_ARM_REG_PC, load_word(vectors_ + 4) | 1);
  set_reg(UC_ARM_REG_PRIMASK, 0);
  broken_.reset();
  reset_wanted_ = false;
  look_again_ = true;
}

std::uint32_t CortexM::reg(int id) const {
  std::uint32_t value = 0;
  check(uc_reg_read(uc_, id, &value), "register");
  return value;
}

void CortexM::set_reg(int id, std::uint32_t value) {
  check(uc_reg_write(uc_, id, &value), "register");
}

std::uint32_t CortexM::load_word(std::uint32_t address) const {
  std::uint32_t value = 0;
  check(uc_mem_read(uc_, address, &value, sizeof value), "memory");
  return value;
}

std::uint8_t CortexM::load_byte(std::uint32_t address) const {
  std::uint8_t value = 0;
  check(uc_mem_read(uc_, address, &value, 1), "memory");
  return value;
}

void CortexM::store_byte(std::uint32_t address, std::uint8_t value) {
  check(uc_mem_write(uc_, address, &value, 1), "memory");
}

/// Instructions of a block: 16 bits each, or 32 where the first half says so (ARMv7-M A5.1).
std::uint32_t CortexM::count(std::uint32_t address, std::uint32_t size) {
  const auto [entry, is_new] = counted_.try_emplace(std::uint64_t{address} << 32 | size, 0);
  if (!is_new) return entry->second;
  for (std::uint32_t at = 0; at < size; ++entry->second) {
    const auto half = static_cast<std::uint32_t>(load_byte(address + at + 1));
    at += half >> 3 >= 0b11101 ? 4 : 2;
  }
  return entry->second;
}

void CortexM::advance_peripherals() {
  look_again_ = false;
  next_event_ = ~Cycles{0};
  for (const auto& [address, peripheral] : bus_->peripherals) {
    peripheral->advance(now_);
    if (const auto event = peripheral->next_event()) next_event_ = std::min(next_event_, *event);
  }
}

void CortexM::block(std::uint32_t address, std::uint32_t size) {
  if (now_ >= next_event_ || look_again_) advance_peripherals();
  const bool interrupted = next_line_ >= 0 && !masked();
  if (now_ >= until_ || broken_ || reset_wanted_ || stop_wanted_ || interrupted) {
    stopped_ = true;
    uc_emu_stop(uc_);
    return;
  }
  const std::uint32_t executed = count(address, size);
  instructions_ += executed;
  cycle_part_ += executed * settings_.cycles_per_instruction;
  const auto whole = static_cast<Cycles>(cycle_part_);
  cycle_part_ -= static_cast<double>(whole);
  now_ += whole;
}

bool CortexM::masked() const {
  return (reg(UC_ARM_REG_PRIMASK) & 1) != 0;
}

/// The line that would interrupt now; -1 for none.
int CortexM::pending_line() const {
  int best = -1;
  int most = priority();
  for (int i = 0; i < kLines; ++i) {
    const Line& line = lines_[i];
    if (!line.pending || !line.enabled || line.priority >= most) continue;
    best = i;
    most = line.priority;
  }
  return best;
}

void CortexM::raise(int line) {
  if (!lines_[line].pending) lines_[line].raised = now_;
  lines_[line].pending = true;
  choose_line();
}

void CortexM::disable(int line) {
  lines_[line].enabled = false;
  choose_line();
}

/// ARMv7-M ARM, B1.5.6: eight words on the stack, aligned to eight bytes.
void CortexM::enter(int line) {
  const std::uint32_t stack = reg(UC_ARM_REG_SP);
  const bool padded = (stack & 4) != 0;
  const std::uint32_t frame = stack - 32 - (padded ? 4 : 0);
  const std::uint32_t flags = reg(UC_ARM_REG_CPSR);
  const std::uint32_t status = (flags & (kFlags | kConditional)) | kThumb | (padded ? 1U << 9 : 0);
  const std::uint32_t words[] = {
      reg(UC_ARM_REG_R0),  reg(UC_ARM_REG_R1), reg(UC_ARM_REG_R2),     reg(UC_ARM_REG_R3),
      reg(UC_ARM_REG_R12), reg(UC_ARM_REG_LR), reg(UC_ARM_REG_PC) | 1, status};
  check(uc_mem_write(uc_, frame, words, sizeof words), "stack");
  set_reg(UC_ARM_REG_SP, frame);
  set_reg(UC_ARM_REG_CPSR, flags & ~kConditional);
  set_reg(UC_ARM_REG_LR, frames_.empty() ? kReturnToThread : kReturnToHandler);
  set_reg(UC_ARM_REG_PC,
          load_word(vectors_ + 4 * static_cast<std::uint32_t>(kFirstLine + line)) | 1);
  Line& taken = lines_[line];
  taken.pending = false;
  taken.figures.latest = std::max(taken.figures.latest, now_ - taken.raised);
  ++taken.figures.taken;
  frames_.push_back({line, taken.priority, now_});
  choose_line();
  now_ += kEntry;
}

void CortexM::leave() {
  const std::uint32_t frame = reg(UC_ARM_REG_SP);
  std::array<std::uint32_t, 8> words{};
  check(uc_mem_read(uc_, frame, words.data(), sizeof words), "stack");
  set_reg(UC_ARM_REG_R0, words[0]);
  set_reg(UC_ARM_REG_R1, words[1]);
  set_reg(UC_ARM_REG_R2, words[2]);
  set_reg(UC_ARM_REG_R3, words[3]);
  set_reg(UC_ARM_REG_R12, words[4]);
  set_reg(UC_ARM_REG_LR, words[5]);
  set_reg(UC_ARM_REG_PC, words[6] | 1);
  set_reg(UC_ARM_REG_SP, frame + 32 + ((words[7] & 1U << 9) != 0 ? 4 : 0));
  constexpr std::uint32_t kKept = kFlags | kConditional;
  set_reg(UC_ARM_REG_CPSR, (reg(UC_ARM_REG_CPSR) & ~kKept) | (words[7] & kKept));
  const Frame& ended = frames_.back();
  InterruptFigures& figures = lines_[ended.line].figures;
  figures.longest = std::max(figures.longest, now_ - ended.begun);
  frames_.pop_back();
  choose_line();
  now_ += kEntry;
}

std::optional<std::string> CortexM::run_until(Cycles cycles) {
  until_ = cycles;
  stop_wanted_ = false;
  while (now_ < until_ && !broken_ && !stop_wanted_ && !reset_wanted_) {
    if (look_again_ || now_ >= next_event_) advance_peripherals();
    if (waiting_ && next_line_ < 0) {
      const Cycles to = std::max(now_, std::min(until_, next_event_));
      idle_ += to - now_;
      now_ = to;
      look_again_ = true;
      continue;
    }
    if (std::exchange(waiting_, false)) woke_ = now_;
    if (next_line_ >= 0 && !masked()) enter(next_line_);
    stopped_ = false;
    const uc_err error = uc_emu_start(uc_, reg(UC_ARM_REG_PC) | 1, 0, 0, 0);
    const std::uint32_t pc = reg(UC_ARM_REG_PC);
    if (stopped_ || broken_ || stop_wanted_ || reset_wanted_) continue;
    if ((pc & 0xFFFF'FFF0) == 0xFFFF'FFF0 && !frames_.empty()) {
      leave();
      continue;
    }
    if (error != UC_ERR_OK) {
      char place[80];
      std::snprintf(place, sizeof place, "%s at %08x", uc_strerror(error), pc);
      broken_ = place;
      break;
    }
    // It waits for an interrupt; a masked one ends the waiting, too.
    waiting_ = true;
    longest_work_ = std::max(longest_work_, now_ - woke_);
  }
  // What fell due in the last block has happened.
  if (now_ >= next_event_) advance_peripherals();
  if (after_stop_) std::exchange(after_stop_, nullptr)();
  return broken_;
}

std::uint32_t CortexM::core_read(std::uint32_t offset) const {
  if (offset == kVectorTable) return vectors_;
  return 0;
}

void CortexM::core_write(std::uint32_t offset, std::uint32_t value) {
  const auto each = [&](std::uint32_t from, auto&& change) {
    if (offset < from || offset >= from + 0x20) return;
    for (std::uint32_t bit = 0; bit < 32; ++bit) {
      const std::uint32_t line = (offset - from) * 8 + bit;
      if ((value >> bit & 1) != 0 && line < kLines) change(lines_[line]);
    }
  };
  each(kSetEnable, [](Line& line) { line.enabled = true; });
  each(kClearEnable, [](Line& line) { line.enabled = false; });
  each(kSetPending, [this](Line& line) { line.pending = true, line.raised = now_; });
  each(kClearPending, [](Line& line) { line.pending = false; });
  if (offset >= kPriority && offset < kPriority + kLines) {
    // One byte, whatever the width of the store; the four upper bits count.
    lines_[offset - kPriority].priority = value & 0xF0;
  }
  choose_line();
  if (offset == kVectorTable) vectors_ = value;
  if (offset == kResetControl && value == kResetKey) {
    reset_wanted_ = true;
    uc_emu_stop(uc_);
  }
  look_again_ = true;
}

}  // namespace sinew::emulation
