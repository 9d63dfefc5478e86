#include "sinew/runtime/links/wire_monitor.h"

#include <algorithm>

#include "sinew/devices/kinds.h"

namespace sinew::runtime {

void WireMonitor::update(const DeviceFacts& facts) {
  if (!reader_ || !reader_->fits(facts)) reader_ = listener_for(device_, facts);
  pieces_.clear();
  messages_.clear();
  if (const std::uint64_t lost = ring_.read(place_, pieces_); lost > 0) {
    reader_->forget();
    last_ += lost;
  }
  for (const WirePiece& piece : pieces_) reader_->read(piece, messages_);
  const std::size_t skipped = messages_.size() > kKept ? messages_.size() - kKept : 0;
  last_ += skipped;
  for (std::size_t i = skipped; i < messages_.size(); ++i) {
    frames_.push_back({++last_, std::move(messages_[i])});
  }
  while (frames_.size() > kKept) frames_.pop_front();
}

WireMonitor::Frames WireMonitor::read(const DeviceFacts& facts, std::uint64_t since,
                                      std::size_t limit) {
  update(facts);
  Frames told;
  told.last = last_;
  // Numbers of an earlier run of this program are nobody's.
  if (since > last_) since = 0;
  auto first = std::ranges::upper_bound(frames_, since, {}, &Frame::sequence);
  const auto behind = static_cast<std::size_t>(frames_.end() - first);
  if (behind > limit) first += static_cast<std::ptrdiff_t>(behind - limit);
  for (; first != frames_.end(); ++first) told.frames.push_back(&*first);
  if (since > 0) told.lost = last_ - since - told.frames.size();
  return told;
}

}  // namespace sinew::runtime
