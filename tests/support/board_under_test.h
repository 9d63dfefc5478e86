#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "sinew/mcu/arm_board.h"

namespace sinew::mcu {

using Bytes = std::vector<std::uint8_t>;

inline Bytes bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

/// Facts of the BigRobotArm's board.
inline ArmBoardFacts big_robot_arm_facts() {
  ArmBoardFacts facts = {{{3200, 200}, {400, 100}, {3200, 100}, {3200, 100}, {3200, 100}}, {}};
  for (std::size_t i = 0; i < sizeof facts.identity; ++i) {
    facts.identity[i] = static_cast<std::uint8_t>(i);
  }
  return facts;
}

/// A board, wherever its program runs: here, or on an emulated chip.
class BoardUnderTest {
 public:
  struct Step {
    std::size_t axis;
    std::int64_t position;  ///< steps since power-up, behind it
    double at;              ///< s
  };

  virtual ~BoardUnderTest() = default;
  virtual void send(std::span<const std::uint8_t> bytes) = 0;
  virtual void run_ms(int ms) = 0;
  virtual Bytes take_output() = 0;
  /// By the pulses, since power-up.
  virtual std::int64_t steps(std::size_t axis) const = 0;
  virtual double seconds() const = 0;
  virtual double gripper_us() const = 0;
  virtual void set_stop_line(bool low) = 0;
  /// As its reset line does it.
  virtual void restart() = 0;
  virtual void power_cycle() = 0;
  std::function<void(const Step&)> on_step;

  /// What comes back within `ms`.
  Bytes ask(std::span<const std::uint8_t> bytes, int ms = 20) {
    take_output();
    send(bytes);
    run_ms(ms);
    return take_output();
  }
  Bytes ask(std::string_view text, int ms = 30) { return ask(bytes_of(text), ms); }

  /// The reply to a frame; nothing where no good one comes within `ms`.
  std::optional<arm_link::Reply> frame(const arm_link::Request& request, int ms = 40) {
    std::uint8_t plain[arm_link::kRequestMax];
    std::uint8_t stuffed[kStuffedMax];
    const std::uint8_t size = stuff(plain, arm_link::encode(request, plain), stuffed);
    Bytes heard;
    take_output();
    send(std::span(stuffed, size));
    for (; ms > 0; --ms) {
      run_ms(1);
      const Bytes more = take_output();
      heard.insert(heard.end(), more.begin(), more.end());
      if (const auto reply = reply_in(heard)) return reply;
    }
    return std::nullopt;
  }
  static std::optional<arm_link::Reply> reply_in(std::span<const std::uint8_t> bytes) {
    FrameReceiver receiver;
    std::optional<arm_link::Reply> last;
    for (const std::uint8_t byte : bytes) {
      const std::uint8_t size = receiver.push(byte);
      arm_link::Reply reply = {};
      if (size > 0 && arm_link::decode(receiver.frame(), size, reply)) last = reply;
    }
    return last;
  }
};

/// The board's program on this machine, with its interrupts one after the other.
class HostBoard : public BoardUnderTest {
 public:
  HostBoard() { board_.emplace(facts_, kept_); }

  void send(std::span<const std::uint8_t> bytes) override {
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
  }
  void run_ms(int ms) override {
    for (; ms > 0; --ms) run();
  }
  Bytes take_output() override { return std::exchange(output_, {}); }
  std::int64_t steps(std::size_t axis) const override { return steps_[axis]; }
  double seconds() const override { return static_cast<double>(ms_) / 1000; }
  double gripper_us() const override { return board_->gripper_us(); }
  void set_stop_line(bool low) override { stop_line_ = low; }
  void restart() override {
    waiting_.clear();
    output_.clear();
    board_.emplace(facts_, kept_);
  }
  void power_cycle() override {
    for (auto& slot : kept_.slots) slot.check ^= 0x5A5A5A5A;
    restart();
  }
  const ArmBoard& board() const { return *board_; }

 private:
  static constexpr std::size_t kBytesPerMs = 25;

  void run() {
    for (std::size_t n = 0; n < kBytesPerMs && !waiting_.empty() && board_->takes(); ++n) {
      board_->receive(waiting_.front(), ms_);
      waiting_.erase(waiting_.begin());
    }
    board_->poll(ms_);
    ReplyBuffer& replies = board_->replies();
    for (std::size_t n = 0; n < kBytesPerMs && !replies.empty(); ++n) {
      output_.push_back(replies.take());
    }
    for (int tick = 0; tick < StepPulses::kTicks; ++tick) {
      const std::uint8_t axes = board_->pulses().tick();
      for (std::size_t i = 0; i < kArmAxes; ++i) {
        if ((axes >> i & 1) == 0) continue;
        steps_[i] += (board_->pulses().backwards() >> i & 1) != 0 ? -1 : 1;
        if (on_step) on_step({i, steps_[i], seconds() + tick / 32000.0});
      }
      if (board_->pulses().slice_began()) board_->slice(stop_line_);
    }
    ++ms_;
  }

  ArmBoardFacts facts_ = big_robot_arm_facts();
  KeptPositions kept_ = {};
  std::optional<ArmBoard> board_;
  Bytes waiting_;
  Bytes output_;
  std::array<std::int64_t, kArmAxes> steps_{};
  std::uint32_t ms_ = 12345;
  bool stop_line_ = false;
};

}  // namespace sinew::mcu
