#include "sinew/server/json/preview.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sinew/core/error.h"
#include "sinew/core/error_code.h"
#include "sinew/core/rotation.h"
#include "sinew/planning/paths/tool_space.h"
#include "sinew/program/plans/foresight.h"
#include "sinew/program/plans/row_offers.h"
#include "sinew/program/plans/whole_moves.h"
#include "sinew/runtime/homing_time.h"
#include "sinew/runtime/records/unit_name.h"
#include "sinew/server/json/robot_json.h"

namespace sinew::server {
namespace {

using program::MoveOrder;

/// Nobody sees more, and a message stays small.
double rounded(double value, double step) {
  const double whole = std::round(value / step) * step;
  return std::abs(value) < 1e9 ? std::round(whole * 1e9) / 1e9 : value;
}

Json row_of(const double* values, std::size_t size) {
  constexpr double kStep = 1e-6;
  Json row = Json::array();
  for (std::size_t j = 0; j < size; ++j) row.push_back(rounded(values[j], kStep));
  return row;
}

Json tool_row(const planning::PoseBT& X_BT) {
  const auto wxyz = quaternion_wxyz(X_BT.R);
  const double all[] = {X_BT.p.x, X_BT.p.y, X_BT.p.z, wxyz[0], wxyz[1], wxyz[2], wxyz[3]};
  return row_of(all, 7);
}

/// What the joints and the tool do, as a client plots and draws it.
class Samples {
 public:
  Samples(const RobotModel& model, const planning::ToolSpace& space, double step)
      : model_(model), space_(space), X_near_(space.home()), step_(step) {}

  template <class Motion>
  void add(const Motion& motion) {
    const double duration = motion.duration();
    const double count = std::max(1.0, std::ceil(duration / step_));
    planning::JointMotion at;
    for (double k = 0; k <= count; ++k) {
      const double t = duration * k / count;
      motion.sample(t, at);
      put(t_ + t, at);
    }
    t_ += duration;
  }
  /// The robot stands for a while, or does nobody knows exactly what, and ends at `q`.
  void pause(double duration, const JointVector& q) {
    t_ += duration;
    planning::JointMotion at;
    std::ranges::copy(q, at.q.begin());
    put(t_, at);
  }

  Json json() const {
    return {{"t_s", times_},
            {runtime::with_units("position", model_), q_},
            {runtime::with_units("velocity", model_) + "_s", qd_},
            {runtime::with_units("acceleration", model_) + "_s2", qdd_},
            {runtime::with_units("jerk", model_) + "_s3", qddd_},
            {"tool", tool_}};
  }
  Json last_tool() const { return tool_.empty() ? Json() : tool_.back(); }
  Json last_joints() const { return q_.empty() ? Json() : q_.back(); }

 private:
  void put(double t, const planning::JointMotion& at) {
    const std::size_t size = model_.joints.size();
    times_.push_back(rounded(t, 1e-4));
    q_.push_back(row_of(at.q.data(), size));
    qd_.push_back(row_of(at.qd.data(), size));
    qdd_.push_back(row_of(at.qdd.data(), size));
    qddd_.push_back(row_of(at.qddd.data(), size));
    if (const auto X_BT = space_.forward({at.q.data(), size}, X_near_)) X_near_ = *X_BT;
    tool_.push_back(tool_row(X_near_));
  }

  const RobotModel& model_;
  const planning::ToolSpace& space_;
  planning::PoseBT X_near_;
  double step_;
  double t_ = 0;
  Json times_ = Json::array();
  Json q_ = Json::array(), qd_ = Json::array(), qdd_ = Json::array(), qddd_ = Json::array();
  Json tool_ = Json::array();
};

/// Joints to which a joint move would lead instead, tried out by the planner; null where none.
Json would_work(const program::WayRefusal& way, std::size_t size) {
  const planning::MoveProposal& offers = way.proposal;
  const auto offer = [&](const char* what, const planning::JointArray& q) {
    return Json{{"what", what}, {"positions", row_of(q.data(), size)}};
  };
  if (offers.back_inside) return offer("back_inside", *offers.back_inside);
  if (offers.move_j) return offer("joint_move", *offers.move_j);
  if (offers.nearest_q) return offer("nearest_orientation", *offers.nearest_q);
  if (offers.tilted && offers.tilted->q) return offer("tilted", *offers.tilted->q);
  if (offers.near) {
    Json json = offer("short_of_it", offers.near->q);
    json["left_m"] = rounded(offers.near->left, 1e-6);
    return json;
  }
  return nullptr;
}

/// Plans the motions once more, one after the other, and takes their samples.
class Sampler {
 public:
  Sampler(const RobotModel& model, program::RowPlanner& planner, Samples& samples)
      : model_(model), planner_(planner), samples_(samples) {}

  std::expected<void, program::Refusal> take(const program::Foreseen& now) {
    if (now.rows != nullptr) return take_cube(*now.from.q, now.from.tool, *now.rows);
    // What the camera will see is not known; that a cube cannot be had is.
    const bool refused = now.why != nullptr && now.why->error.code != ErrorCode::kNothingSeen;
    if (refused) return std::unexpected(*now.why);
    const program::Order& order = now.order;
    if (const auto* wait = std::get_if<program::WaitOrder>(&order.what)) {
      pause(to_seconds(wait->duration));
    } else if (const auto* tool = std::get_if<program::ToolOrder>(&order.what)) {
      pause(tool->duration);
    }
    const auto* move = std::get_if<MoveOrder>(&order.what);
    if (move == nullptr) return {};
    q_ = move->q;
    if (move->first_move || !move->q_start) {
      samples_.pause(move->duration, q_);
      return {};
    }
    return take_motion(*move->q_start, move->tool, move->rows);
  }

 private:
  void pause(double duration) {
    if (!q_.empty()) samples_.pause(duration, q_);
  }

  std::expected<void, program::Refusal> take_motion(const JointVector& q_start,
                                                    const ToolState& tool,
                                                    std::span<const program::Step> rows) {
    const auto pieces = planner_.plan(q_start, tool, rows);
    if (!pieces) return std::unexpected(pieces.error());
    q_ = pieces->q_end;
    const planning::PlannedMotion& motion = planner_.motion();
    if (motion.empty()) return {};
    const bool whole = model_.device.capability.motion == MotionKind::kPointToPoint;
    if (whole && !pieces->pieces.empty()) {
      const double share = motion.path.sections.front().joint_share;
      samples_.add(program::WholeMoves(q_start, *pieces, share, model_));
    } else {
      samples_.add(motion.trajectory());
    }
    return {};
  }

  std::expected<void, program::Refusal> take_cube(JointVector q, ToolState tool,
                                                  const program::CubeRows& rows) {
    for (const program::Step& step : rows.steps) {
      if (program::motion_of(step) != nullptr) {
        const auto done = take_motion(q, tool, std::span(&step, 1));
        if (!done) return done;
        q = q_;
        continue;
      }
      const ToolAction& action = std::get<program::ToolStep>(step.what).action;
      pause(to_seconds(model_.device.settings->tool_time(model_, action, tool.jaws)));
      const auto* jaws = std::get_if<JawsTo>(&action);
      if (jaws != nullptr) tool = {jaws->width, jaws->held};
    }
    return {};
  }

  const RobotModel& model_;
  program::RowPlanner& planner_;
  Samples& samples_;
  JointVector q_;
};

bool first_move_in(const program::Plan& plan) {
  return std::ranges::any_of(plan.orders, [](const program::Order& order) {
    const auto* move = std::get_if<MoveOrder>(&order.what);
    return move != nullptr && move->first_move;
  });
}

}  // namespace

Json refusal_json(const program::Refusal& refusal, const RobotModel& model) {
  Json data = error_json(refusal.error, model);
  data["line"] = refusal.line;
  if (!refusal.way) return data;
  const planning::PathRefusal& why = refusal.way->refusal;
  data["share"] = why.place.share;
  if (why.place.metres) data["way_m"] = why.place.at;
  if (why.nearest_behind) data["nearest_behind_m"] = *why.nearest_behind;
  if (Json other = would_work(*refusal.way, model.joints.size()); !other.is_null()) {
    data["would_work"] = std::move(other);
  }
  return data;
}

RpcError refused_plan(const program::Refusal& refusal, const RobotModel& model,
                      const std::optional<runtime::CellRefusal>& met) {
  Json data = refusal_json(refusal, model);
  if (refusal.way) {
    if (auto rows = program::offers(*refusal.way, model); !rows.empty()) data["remedies"] = rows;
  }
  if (met) put_in_the_way(data, *met);
  return {RpcCode::kRefused, data["sentence"].get<std::string>(), data};
}

std::expected<const program::TextForm*, RpcError> asked_form(const RpcRequest& request,
                                                             const RobotModel& model) {
  const auto given = request.params.find("form");
  if (given == request.params.end()) {
    const auto text = request.params.find("text");
    if (text == request.params.end()) return nullptr;
    return program::form_of_text("", text->get_ref<const std::string&>(), model);
  }
  const auto* form = program::text_form(given->get_ref<const std::string&>());
  if (form == nullptr) return std::unexpected(invalid("form is " + program::form_names(false)));
  return form;
}

RpcError no_form(const program::NoForm& why, const RobotModel& model) {
  if (!why.complaints.empty()) return complained(why.complaints);
  if (why.refusal) return refused_plan(*why.refusal, model, std::nullopt);
  return {RpcCode::kRefused, why.sentence, nullptr};
}

program::Standing standing(const runtime::Station& station) {
  const runtime::StationView view = station.view();
  if (view.reference) return {view.reference, view.tool};
  JointVector q;
  for (const JointPosition& position : view.positions) {
    if (position.quality < PositionQuality::kCommanded) return station.assumed_place();
    q.push_back(position.q);
  }
  if (q.size() != station.robot().joints.size()) return station.assumed_place();
  return {q, view.tool};
}

std::expected<Json, RpcError> preview(const runtime::RunningCell& cell, const PreviewWish& wish) {
  const runtime::Station& station = cell.station(wish.robot);
  const RobotModel& model = station.robot();
  std::optional<runtime::CellRefusal> met;
  const auto look = [&](const planning::CellWay& way) -> std::optional<Error> {
    const auto meeting = cell.space().meets(wish.robot, way);
    if (!meeting) return std::nullopt;
    met = meeting->refusal;
    return meeting->error;
  };
  const auto plan =
      program::make_plan(wish.program, model, wish.from, runtime::homing_of(model), look);
  if (!plan) return std::unexpected(refused_plan(plan.error(), model, met));
  program::RowPlanner planner(model);
  const double step = std::max(plan->duration / static_cast<double>(wish.samples - 1), 1e-3);
  Samples samples(model, planner.space(), step);
  Sampler sampler(model, planner, samples);
  const auto foreseen =
      program::foresee(*plan, wish.program, planner, wish.from,
                       [&](const program::Foreseen& now) { return sampler.take(now); });
  if (!foreseen) return std::unexpected(refused_plan(foreseen.error(), model, std::nullopt));
  Json json{{"robot", station.name()},
            {"text", wish.text},
            {"duration_s", rounded(plan->duration, 1e-4)},
            {"homing_at_most_s", plan->homing_max},
            {"first_move", first_move_in(*plan)}};
  if (const auto& from = wish.from.q) json["from"] = row_of(from->data(), from->size());
  put_limited(json, plan->limits, model);
  json["to"] = {{"positions", samples.last_joints()}, {"tool", samples.last_tool()}};
  json["samples"] = samples.json();
  return json;
}

PreviewDesk::PreviewDesk(const runtime::RunningCell& cell)
    : cell_(cell), thread_([this] { work(); }) {}

PreviewDesk::~PreviewDesk() {
  {
    const std::scoped_lock lock(mutex_);
    ends_ = true;
  }
  more_.notify_all();
  thread_.join();
}

bool PreviewDesk::ask(Ticket ticket, PreviewWish wish) {
  {
    const std::scoped_lock lock(mutex_);
    const auto older = std::ranges::find_if(waiting_, [&](const Waiting& one) {
      return one.ticket.client == ticket.client && one.wish.robot == wish.robot;
    });
    if (older != waiting_.end()) {
      done_.push_back({std::move(older->ticket),
                       std::unexpected(RpcError{RpcCode::kBusy,
                                                "a newer preview of this robot was asked for "
                                                "before this one began",
                                                {{"code", "overtaken"}}})});
      *older = {std::move(ticket), std::move(wish)};
      return true;
    }
    if (waiting_.size() >= kWaitingMax) return false;
    waiting_.push_back({std::move(ticket), std::move(wish)});
  }
  more_.notify_all();
  return true;
}

std::size_t PreviewDesk::forget(std::uint32_t client) {
  const std::scoped_lock lock(mutex_);
  return std::erase_if(waiting_, [&](const Waiting& one) { return one.ticket.client == client; });
}

std::optional<Answered> PreviewDesk::take() {
  const std::scoped_lock lock(mutex_);
  if (done_.empty()) return std::nullopt;
  Answered first = std::move(done_.front());
  done_.erase(done_.begin());
  return first;
}

void PreviewDesk::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    more_.wait(lock, [this] { return ends_ || !waiting_.empty(); });
    if (ends_) return;
    Waiting next = std::move(waiting_.front());
    waiting_.erase(waiting_.begin());
    lock.unlock();
    auto result = as_task([&] { return preview(cell_, next.wish); })();
    lock.lock();
    done_.push_back({std::move(next.ticket), std::move(result)});
  }
}

}  // namespace sinew::server
