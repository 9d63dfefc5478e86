#include "firmware/emulation_stm8/node_on_host.h"

#include <array>
#include <deque>
#include <optional>

#include "sinew/mcu/as5600.h"
#include "sinew/mcu/encoder_node.h"

namespace sinew::emulation {
namespace {

using Reading = std::array<std::uint8_t, kAs5600Size>;

/// The image's main loop, without its chip.
class HostNode {
 public:
  HostNode() { encoder_node_start(&node_); }

  void add(const Event& event) {
    switch (event.act) {
      case Act::kTick:
        if (event.value == 0) ++ticks_;
        break;
      case Act::kBusControl:
        if ((event.value & 1) != 0 && !sampling_) begin_sample();
        break;
      case Act::kReading:
        reading_ = Reading{static_cast<std::uint8_t>(event.value >> 12),
                           static_cast<std::uint8_t>(event.value >> 8 & 0xF),
                           static_cast<std::uint8_t>(event.value)};
        break;
      case Act::kWatchdogKey:
        end_sample();
        break;
      case Act::kReceives:
        if (!driving_) waiting_.push_back(static_cast<std::uint8_t>(event.value));
        break;
      case Act::kPortD:
        driving_ = (event.value & 0x10) != 0;
        if (!driving_) sending_ = false;
        break;
      default:
        break;
    }
    take_waiting();
  }

  const Bytes& replies() const { return replies_; }

 private:
  void begin_sample() {
    sampling_ = true;
    elapsed_ = ticks_;
    ticks_ = 0;
    reading_.reset();
  }

  /// The watchdog is fed behind each sample; its first keys are its start.
  void end_sample() {
    if (sampling_) encoder_node_sample(&node_, reading_ ? reading_->data() : nullptr, elapsed_);
    if (!sampling_) ticks_ = 0;
    sampling_ = false;
  }

  void take_waiting() {
    while (!sampling_ && !sending_ && !waiting_.empty()) {
      Bytes reply(kEncoderNodeReplySize);
      sending_ = encoder_node_receive(&node_, waiting_.front(), reply.data());
      waiting_.pop_front();
      if (sending_) replies_.insert(replies_.end(), reply.begin(), reply.end());
    }
  }

  EncoderNode node_{};
  std::optional<Reading> reading_;
  std::deque<std::uint8_t> waiting_;
  std::uint8_t ticks_ = 0;
  std::uint8_t elapsed_ = 0;
  bool sampling_ = false;
  bool sending_ = false;
  bool driving_ = false;
  Bytes replies_;
};

}  // namespace

Bytes replies_on_host(const std::vector<Event>& events) {
  HostNode node;
  for (const Event& event : events) node.add(event);
  return node.replies();
}

}  // namespace sinew::emulation
