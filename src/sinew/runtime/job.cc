#include "sinew/runtime/job.h"

#include <utility>

#include "sinew/core/error_code.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/plans/row_offers.h"
#include "sinew/runtime/homing_time.h"

namespace sinew::runtime {

using program::Run;

namespace {

constexpr Duration kPatience = std::chrono::milliseconds(20);
/// At most so long a job waits for its machine to stand.
constexpr Duration kBrakesMax = std::chrono::seconds(5);

std::expected<program::Program, program::Refusal> ride_of(const program::RideOrder& order,
                                                          const StationClient& client) {
  const RobotModel& robot = client.robot();
  const auto reference = client.reference();
  const auto ride = program::make_ride(robot, reference.value_or(home_joints(robot)), order);
  if (!ride) return std::unexpected(ride.error());
  std::string text = ride->text;
  // The ride's last row leads back to where it began, and names all joints: it finds a machine
  // that does not know where it is, too.
  if (!reference) text.insert(0, text.substr(text.rfind('\n', text.size() - 2) + 1));
  auto parsed = program::parse(text, "ride", robot);
  if (parsed) return std::move(*parsed);
  return std::unexpected(program::Refusal{0, {ErrorCode::kMoveInput}, std::nullopt});
}

int line_of(const Run& run) {
  if (run.failure()) return run.failure()->line;
  const program::Order* order = run.under_way() ? run.under_way()->order : run.next_order();
  return order != nullptr ? order->line : 0;
}

}  // namespace

JobRunner::~JobRunner() {
  {
    const std::scoped_lock lock(mutex_);
    abandoned_ = true;
  }
  if (thread_.joinable()) thread_.join();
}

Expected<std::uint32_t> JobRunner::start(JobOrder order, control::ClientId client) {
  auto made = StationClient::make(station_, client);
  std::uint32_t id = 0;
  {
    const std::scoped_lock lock(mutex_);
    if (!view_.over) return std::unexpected(Error{ErrorCode::kBusy});
    if (!made) return std::unexpected(made.error());
    id = view_.id + 1;
    view_ = {.id = id,
             .client = client,
             .title = order.title,
             .handles_cubes = program::handles_cubes(order.program),
             .over = false};
    wish_ = Wish::kNone;
  }
  if (thread_.joinable()) thread_.join();
  thread_ = std::thread([this, job = std::move(order), machine = std::move(*made)] {
    station_.works(true);
    work(job, *machine);
    station_.works(false);
    // The last that is said: whoever hears it may begin the next one.
    const std::scoped_lock lock(mutex_);
    view_.over = true;
  });
  return id;
}

void JobRunner::work(const JobOrder& order, StationClient& client) {
  if (!order.ride) return run(order, order.program, client);
  const auto ride = ride_of(*order.ride, client);
  if (ride) return run(order, *ride, client);
  const std::scoped_lock lock(mutex_);
  view_.failure = ride.error();
  view_.phase = Run::Phase::kFailed;
}

void JobRunner::run(const JobOrder& order, const program::Program& program, StationClient& client) {
  wishes_ = 0;
  wish_refused_.reset();
  {
    const std::scoped_lock lock(mutex_);
    view_.notes = program.notes;
  }
  Run run(program, client);
  run.expect_homing(homing_of(station_.robot()));
  if (order.changeable) run.make_changeable();
  run.measure_by([this] { return station_.view().health; });
  if (program::Eyes* eyes = eyes_) run.see_by(*eyes);
  run.hear_decisions([this](const program::Decision& decision) {
    station_.record(RunDecision{clock_.now(), decision});
  });
  if (order.take_over) run.take_over();
  run.single_step(order.single_step);
  run.feed(order.feed);
  run.show_to([&](const planning::CellWay& way) -> std::optional<Error> {
    const auto free = station_.look(way);
    return free ? std::nullopt : std::optional(free.error());
  });
  if (order.standing_at) {
    run.declare(*order.standing_at);
  } else if (const auto assumed = station_.assumed_place()) {
    run.declare({.q = *assumed, .has_looked = false});
  }
  station_.set_recorded(order.recorded);
  if (order.recorded) station_.begin_record(order.title, order.record);
  run.start(clock_.now());
  bool freed = false;
  std::optional<Instant> finished_at;
  // The controller looks at the motion until its command has ended, and a machine that
  // brakes is not yet where it will be.
  const auto brakes = [&] {
    return client.view().brakes && finished_at && clock_.now() - *finished_at < kBrakesMax;
  };
  while (!run.finished() || client.motion_in_use() || brakes()) {
    client.refresh();
    const Instant now = clock_.now();
    if (order.on_client_loss == ClientLoss::kContinue) client.keep_lease(now);
    obey(run, client, now);
    run.poll(now);
    // Nobody is left who could go on with what is held.
    if (run.finished() && client.state() == control::MachineState::kHeld && !freed) {
      client.give(control::Stop{});
      freed = true;
    }
    publish(run, now);
    if (order.look) order.look(run, now);
    // Who samples the run needs each cycle, however fast its time passes.
    const bool each = order.look || run.watches();
    station_.wait_for_cycle(kPatience, each ? clock_.now() : run.next_deadline());
    if (!run.finished()) continue;
    if (!finished_at) finished_at = clock_.now();
    client.refresh();
  }
  // The program's own pace ends with it; an operator's override is another thing.
  if (order.feed != 1) client.give(control::SetFeed{1});
  station_.end_record();
  station_.set_recorded(true);
  const Instant now = clock_.now();
  publish(run, now);
  if (order.ended) order.ended(run, now);
}

/// Under the lease of whoever wants it to, where its own client is gone.
bool JobRunner::goes_on(Run& run, StationClient& client, control::ClientId under) {
  if (run.left() && under != 0) {
    client.act_for(under);
    const std::scoped_lock lock(mutex_);
    view_.client = under;
  }
  if (client.lease().epoch != 0) return true;
  wish_refused_ = program::Refusal{0, Error{ErrorCode::kLeaseLost}, std::nullopt};
  return false;
}

void JobRunner::obey(Run& run, StationClient& client, Instant now) {
  Wish what = Wish::kNone;
  control::ClientId wisher = 0;
  {
    const std::scoped_lock lock(mutex_);
    what = abandoned_ ? Wish::kStop : std::exchange(wish_, Wish::kNone);
    wisher = wisher_;
  }
  if (what == Wish::kNone) return;
  ++wishes_;
  wish_refused_.reset();
  switch (what) {
    case Wish::kNone:
      break;
    case Wish::kPause:
      run.pause();
      break;
    case Wish::kResume:
      if (!goes_on(run, client, wisher)) break;
      run.single_step(false);
      run.resume();
      break;
    case Wish::kStep:
      if (!goes_on(run, client, wisher)) break;
      run.single_step(true);
      run.resume();
      break;
    case Wish::kStepBack:
      if (!goes_on(run, client, wisher)) break;
      run.single_step(true);
      if (const auto back = run.step_back(now); !back) wish_refused_ = back.error();
      break;
    case Wish::kStop:
      run.stop(now);
      break;
  }
}

void JobRunner::publish(const Run& run, Instant now) {
  const program::Plan& plan = run.plan();
  const auto notices = run.notices();
  auto in_the_way = run.failure() ? station_.refusal_of(run.failure()->error) : std::nullopt;
  if (run.waits_for_room()) in_the_way = station_.refusal();
  std::vector<std::string> remedies;
  // This thread alone writes it.
  const bool fails = run.failure() && !view_.failure;
  if (fails && run.failure()->way) {
    remedies = program::offers(*run.failure()->way, station_.robot());
  }
  const std::scoped_lock lock(mutex_);
  if (fails) view_.remedies = std::move(remedies);
  view_.phase = run.phase();
  view_.client_lost = run.left() && !run.finished();
  view_.paused = run.paused() && (!run.steps_back() || run.stands_held());
  view_.paused_by = run.paused_by();
  view_.wishes = wishes_;
  view_.wish_refused = wish_refused_;
  view_.line = line_of(run);
  view_.orders_done = run.records().size();
  view_.orders = plan.orders.size();
  view_.duration = plan.duration;
  view_.homing_max = plan.homing_max;
  view_.planned = !plan.orders.empty();
  view_.begun = run.begun_at().has_value();
  view_.limits = plan.limits;
  view_.progress = run.finished() && run.phase() == Run::Phase::kDone ? 1 : run.progress(now);
  view_.elapsed = run.elapsed(now);
  view_.failure = run.failure();
  view_.in_the_way = in_the_way;
  view_.waits_for_room = run.waits_for_room() && !run.finished();
  view_.stopped_by = run.stopped_by();
  view_.notices = run.notices_told();
  if (!notices.empty()) view_.last_notice = notices.back();
}

void JobRunner::wish(std::uint32_t id, Wish what, control::ClientId client) {
  const std::scoped_lock lock(mutex_);
  // A stop is not taken back by what is wished behind it.
  if (view_.id != id || view_.over || wish_ == Wish::kStop) return;
  wish_ = what;
  wisher_ = client;
  if (what != Wish::kPause) {
    view_.guard = 0;
  } else if (view_.guard == 0) {
    view_.guard = client;
  }
}

void JobRunner::stop(std::uint32_t id) {
  wish(id, Wish::kStop);
}
void JobRunner::pause(std::uint32_t id, control::ClientId guard) {
  wish(id, Wish::kPause, guard);
}
void JobRunner::resume(std::uint32_t id, control::ClientId client) {
  wish(id, Wish::kResume, client);
}
void JobRunner::step(std::uint32_t id, control::ClientId client) {
  wish(id, Wish::kStep, client);
}
void JobRunner::step_back(std::uint32_t id, control::ClientId client) {
  wish(id, Wish::kStepBack, client);
}

JobView JobRunner::view() const {
  const std::scoped_lock lock(mutex_);
  return view_;
}

}  // namespace sinew::runtime
