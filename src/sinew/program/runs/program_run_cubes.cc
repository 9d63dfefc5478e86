#include <algorithm>
#include <array>
#include <utility>

#include "sinew/core/error_code.h"
#include "sinew/program/runs/program_run.h"

/// Rows of a run that look, pick and place.
namespace sinew::program {

std::string_view name(Decision::Kind kind) {
  constexpr std::array<std::string_view, 5> kNames{"pick", "held", "not held", "place", "refused"};
  return kNames[static_cast<std::size_t>(kind)];
}

void Run::decided(Decision::Kind kind, const std::optional<grasping::Cube>& cube,
                  const std::optional<Error>& why) const {
  if (listener_) listener_({kind, current_->order->line, cube, grasps_, why});
}

/// Whether there is a picture of the table as it is; else one is asked for, and the order under way
/// is given again once it is there.
std::expected<bool, Refusal> Run::sees() {
  if (eyes_ == nullptr) return std::unexpected(refused({ErrorCode::kNoCamera}));
  if (sighting_) return true;
  eyes_->look(camera_);
  looks_ = true;
  return false;
}

void Run::take_sight(Instant now) {
  auto seen = eyes_->seen();
  if (!seen) return;
  looks_ = false;
  if (!*seen) return fail(seen->error(), now);
  sighting_ = std::move(**seen);
  std::erase_if(given_up_,
                [&](const grasping::Cube& one) { return !still_there(*sighting_, one); });
  leave_out_given_up();
  looked_ = true;
  lying_ = lying_in(baskets_on(program_.table.get()), released_, sighting_->in_baskets);
  if (const auto gone_on = issue(*current_->order, now); !gone_on) fail(gone_on.error(), now);
}

/// A cube that can be picked: those that cannot are told once they are all that is left.
Expected<bool> Run::is_seen(const Condition& condition, Instant now) {
  const auto from = standing();
  if (!from) return std::unexpected(from.error().error);
  const Step row{current_->order->line, PickCubeStep{condition.color}, current_->order->file};
  const auto rows =
      rows_to_pick(planner(), *from, row, *sighting_, baskets_on(program_.table.get()));
  if (rows) return true;
  decided(Decision::Kind::kRefused, std::nullopt, rows.error().error);
  if (rows.error().error.code != ErrorCode::kNothingSeen) take_notice(rows.error().error, now);
  return false;
}

/// The order under way is made of several steps that only now are known.
bool Run::handles() const {
  return current_ && (std::holds_alternative<PickOrder>(current_->order->what) ||
                      std::holds_alternative<PlaceOrder>(current_->order->what));
}

std::expected<Standing, Refusal> Run::standing() const {
  if (!q_) return std::unexpected(refused({ErrorCode::kPositionUnknown, 0}));
  Standing here(*q_, machine_.tool());
  if (taken_ && carries_) here.at_cup = taken_->edge;
  return here;
}

std::expected<void, Refusal> Run::issue_pick(const PickOrder& pick, Instant now) {
  const auto looked = sees();
  if (!looked) return std::unexpected(looked.error());
  if (!*looked) return {};
  if (std::exchange(verifies_, false)) {
    return is_held(!still_there(*sighting_, *taken_), now);
  }
  const auto from = standing();
  if (!from) return std::unexpected(from.error());
  const Step row{current_->order->line, pick.row, current_->order->file};
  auto rows = rows_to_pick(planner(), *from, row, *sighting_, baskets_on(program_.table.get()),
                           taken_ ? std::optional(Tried{*taken_, grasps_}) : std::nullopt);
  if (rows) {
    // Another one may be the nearest now, as one was pushed.
    if (taken_ && grasps_ > 0 && !lies_at(rows->cube, *taken_)) grasps_ = 0;
    ++grasps_;
    taken_ = rows->cube;
    lift_from_beside();
    decided(Decision::Kind::kPick, taken_);
  } else if (gave_up_ > 0 && rows.error().error.code == ErrorCode::kNothingSeen) {
    return std::unexpected(refused({ErrorCode::kNotHeld, -1, 1.0 * kGraspsMax}));
  }
  return begin_tasks(std::move(rows));
}

std::expected<void, Refusal> Run::issue_place(const PlaceOrder& place) {
  if (!carries_ && !machine_.tool().held) {
    return std::unexpected(refused({ErrorCode::kNothingHeld}));
  }
  const auto from = standing();
  if (!from) return std::unexpected(from.error());
  const Step row{current_->order->line, place.row, current_->order->file};
  auto rows = rows_to_place(planner(), *from, row, program_.table.get(), lying_,
                            beside_ ? &*beside_ : nullptr);
  if (rows && std::holds_alternative<BasketGoal>(place.row.there)) released_at_ = rows->p_BO;
  if (rows) decided(Decision::Kind::kPlace, taken_);
  return begin_tasks(std::move(rows));
}

std::expected<void, Refusal> Run::begin_tasks(std::expected<CubeRows, Refusal> rows) {
  if (!rows) {
    decided(Decision::Kind::kRefused, std::nullopt, rows.error().error);
    return std::unexpected(rows.error());
  }
  tasks_ = std::move(rows->steps);
  task_ = 0;
  task_waits_ = true;
  return {};
}

std::expected<void, Refusal> Run::next_task(Instant now) {
  if (task_ == tasks_.size()) return tasks_done(now);
  const Step& task = tasks_[task_++];
  task_moves_ = motion_of(task) != nullptr;
  if (!task_moves_) {
    command_ = machine_.give(control::UseTool{std::get<ToolStep>(task.what).action});
    return {};
  }
  rows_left_ = std::span(&task, 1);
  return issue_move(now);
}

/// Jaws that can be asked tell whether they hold something; else the next picture does.
std::expected<void, Refusal> Run::tasks_done(Instant now) {
  sighting_.reset();
  if (std::holds_alternative<PlaceOrder>(current_->order->what)) {
    carries_ = false;
    if (const auto at = std::exchange(released_at_, std::nullopt)) {
      released_.push_back(*at);
      lying_.push_back(*at);
    }
    finish_order(now);
    return {};
  }
  const auto width = health_ ? health_().jaws_width : std::nullopt;
  if (width) return is_held(may_hold(*taken_, *width), now);
  verifies_ = true;
  return issue_pick(std::get<PickOrder>(current_->order->what), now);
}

std::expected<void, Refusal> Run::is_held(bool held, Instant now) {
  decided(held ? Decision::Kind::kHeld : Decision::Kind::kNotHeld, taken_);
  if (held) {
    if (sighting_) lift_from_beside();
    carries_ = true;
    current_->cube = taken_;
    finish_order(now);
    return {};
  }
  if (grasps_ == kGraspsMax) {
    const Error why{ErrorCode::kNotHeld, -1, 1.0 * grasps_};
    const bool named = std::get<PickOrder>(current_->order->what).row.p_BT.has_value();
    if (named || ++gave_up_ == kGraspsMax) return std::unexpected(refused(why));
    take_notice(why, now);
    given_up_.push_back(*taken_);
    if (sighting_) leave_out_given_up();
    grasps_ = 0;
  }
  return issue_pick(std::get<PickOrder>(current_->order->what), now);
}

/// What stands beside the cube that is taken, as it was seen last.
void Run::lift_from_beside() {
  beside_ = *sighting_;
  std::erase_if(beside_->cubes, [&](const grasping::Cube& one) { return lies_at(one, *taken_); });
}

/// What was grasped in vain is not taken where it lies, but where a row names its place; elsewhere
/// it may be.
void Run::leave_out_given_up() {
  const auto* pick = std::get_if<PickOrder>(&current_->order->what);
  if (pick != nullptr && pick->row.p_BT) return;
  const auto [given_up, end] =
      std::ranges::stable_partition(sighting_->cubes, [&](const grasping::Cube& cube) {
        return std::ranges::none_of(given_up_,
                                    [&](const grasping::Cube& one) { return lies_at(cube, one); });
      });
  for (const grasping::Cube& one : std::ranges::subrange(given_up, end)) {
    sighting_->others.push_back({grasping::body_of(one)});
  }
  sighting_->cubes.erase(given_up, end);
}

}  // namespace sinew::program
