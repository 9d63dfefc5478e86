#include "sinew/devices/axis/axis_machine_node.h"

#include "sinew/devices/axis/axis_device_joint_node.h"

namespace sinew::sim {

void JointNode::read(AxisInputs& inputs, Instant now) {
  if (request_) board_.receive(*request_, asked_at_ + kRequestTime);
  board_.advance(now);
  std::array<std::uint8_t, 4 * encoder_link::kReplySize> reply{};
  const std::size_t size = board_.take_output(reply);
  reader_.receive(std::span(reply).first(size), now);
  read_joint_node(reader_, inputs, now);
  request_ = reader_.poll(now);
  asked_at_ = now;
}

}  // namespace sinew::sim
