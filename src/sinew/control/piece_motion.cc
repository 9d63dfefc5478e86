#include "sinew/control/piece_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/assert.h"
#include "sinew/core/error_code.h"

namespace sinew::control {
namespace {

bool rests(const JointMove& piece) {
  return std::ranges::all_of(piece.qd, [](double qd) { return qd == 0; });
}

}  // namespace

PieceMotion::PieceMotion(const JointVector& q_start, std::vector<JointMove> pieces,
                         const RobotModel& robot, std::vector<LinkPair> overlaps)
    : q_start_(q_start),
      pieces_(std::move(pieces)),
      overlaps_(std::move(overlaps)),
      streams_(robot.device.capability.motion == MotionKind::kStream),
      takes_speed_(!streams_ && robot.device.capability.takes_speed),
      together_(robot.device.settings->separate_moves(robot) == nullptr) {
  if (q_start_.empty()) return;
  for (const double q : q_start_) whole_.push_back({q, q});
  JointVector from = q_start_;
  JointVector speed;
  speed.resize(from.size());
  for (const JointMove& piece : pieces_) {
    SINEW_ASSERT(piece.q.size() == from.size());
    const double seconds = to_seconds(piece.duration);
    for (std::size_t j = 0; j < from.size(); ++j) {
      const double qd = piece.qd.empty() ? 0 : piece.qd[j];
      // A cubic leaves what lies between its ends by a quarter of this at most.
      const double beyond = std::max(std::abs(speed[j]), std::abs(qd)) * seconds / 4;
      whole_[j].lower = std::min(whole_[j].lower, std::min(from[j], piece.q[j]) - beyond);
      whole_[j].upper = std::max(whole_[j].upper, std::max(from[j], piece.q[j]) + beyond);
      speed[j] = qd;
    }
    from = piece.q;
  }
}

std::unique_ptr<planning::CellWay> PieceMotion::way() const {
  if (q_start_.empty()) return nullptr;
  const std::size_t size = q_start_.size();
  planning::JointArray from{}, speed{};
  std::ranges::copy(q_start_, from.begin());
  auto apart = std::make_unique<planning::CellWay>();
  planning::JointPath path(size, pieces_.size());
  for (const JointMove& piece : pieces_) {
    planning::JointArray to{}, speed_to{};
    std::ranges::copy(piece.q, to.begin());
    if (!piece.qd.empty()) std::ranges::copy(piece.qd, speed_to.begin());
    const double seconds = to_seconds(piece.duration);
    if (!together_) {
      apart->apart_to(from, to);
    } else if (streams_ && seconds > 0) {
      const std::array knots{0.0, seconds};
      const std::array points{from, to};
      path.append_spline(knots, points, speed, speed_to);
    } else {
      path.append_line({from.data(), size}, {to.data(), size}, std::max(seconds, 1e-3));
    }
    from = to;
    speed = speed_to;
  }
  if (!together_) return apart;
  return std::make_unique<planning::CellWay>(std::move(path));
}

bool PieceMotion::between_rests() const {
  return next_ == 0 || next_ == pieces_.size() || rests(pieces_[next_ - 1]);
}

const JointMove* PieceMotion::next(Instant /*now*/) {
  if (finished() || (held_ && between_rests()) || !(feed_ > 0)) return nullptr;
  if (!made_) {
    piece_ = pieces_[next_];
    // Behind another segment it begins where that one ends.
    if (next_ == 0) piece_.q_start = q_start_;
    if (next_ > 0 && !streams_) piece_.q_start = pieces_[next_ - 1].q;
    piece_.duration = from_seconds(to_seconds(piece_.duration) / feed_);
    made_ = true;
  }
  return &piece_;
}

void PieceMotion::taken() {
  SINEW_ASSERT(!finished());
  ++next_;
  made_ = false;
}

Expected<void> PieceMotion::set_feed(double share) {
  if (!std::isfinite(share) || share < 0 || share > 1) {
    return std::unexpected(Error{ErrorCode::kMoveInput, -1, share, 1});
  }
  if (share != 1 && share != 0 && !takes_speed_) {
    return std::unexpected(Error{ErrorCode::kTaskNotSupported});
  }
  feed_ = share;
  made_ = false;
  return {};
}

double PieceMotion::progress() const {
  return pieces_.empty() ? 1 : static_cast<double>(next_) / static_cast<double>(pieces_.size());
}

double PieceMotion::time_left() const {
  double left = 0;
  for (std::size_t k = next_; k < pieces_.size(); ++k) left += to_seconds(pieces_[k].duration);
  return feed_ > 0 ? left / feed_ : left;
}

}  // namespace sinew::control
