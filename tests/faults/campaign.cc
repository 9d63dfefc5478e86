#include "faults/campaign.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "sinew/core/error_code.h"
#include "sinew/core/units.h"
#include "sinew/program/plans/program_plan.h"

namespace sinew::test {
namespace {

using namespace std::chrono_literals;
using sim::LinkDirection;

constexpr Duration kLook = 20ms;   // between two looks at the truth
constexpr Duration kFeed = 2ms;    // between two segments' chances
constexpr Duration kWarmUp = 20s;  // before a port opens: slow boards boot and home
constexpr Duration kSlowMove = 3s;
constexpr Duration kHomingMax = 1200s;     // six joints, one after the other
constexpr std::uint64_t kFlipWithin = 40;  // bytes
constexpr double kNoise = 0.0045;          // rad: what a bus servo's unit is
constexpr double kStill = 1e-3;            // rad/s or m/s
constexpr Duration kPowerOff = 500ms;
constexpr Duration kPowerUp = 20s;
const std::string kUntrue = "the claim is not true after a clean motion: ";

MachineVariant options_of(const WireRules& rules, std::uint64_t seed) {
  MachineVariant options;
  options.profile = rules.profile;
  options.seed = seed;
  return options;
}

double nominal_volts(sim::Machine& machine) {
  return machine.truth().supply_volts;
}

bool at_rest(const Driver& driver) {
  return driver.state() == DriverState::kReady || driver.state() == DriverState::kFault;
}

}  // namespace

FaultCase::FaultCase(const RobotModel& robot, const WireRules& rules, std::uint64_t seed,
                     CampaignSums& sums)
    : robot_(robot),
      rules_(rules),
      sums_(sums),
      random_(seed),
      cell_(robot, options_of(rules, random_.bits()), kWarmUp) {
  cell_.look = [this](const std::optional<DriverEvent>& event) { watch(event); };
  anywhere_ = true;
  way_.resize(robot.joints.size());
}

bool FaultCase::complain(const std::string& what) {
  if (!complaint_.empty()) return false;
  std::ostringstream text;
  text << "episode " << episode_ << ", " << to_seconds(cell_.now() - Instant{}) << " s: " << what
       << "; the last thing refused or failed: " << (last_error_ ? describe(*last_error_) : "-")
       << '\n'
       << described();
  complaint_ = text.str();
  return false;
}

// Looking

void FaultCase::watch(const std::optional<DriverEvent>& event) {
  if (event) {
    if (const auto wrong = ledger_.take(*event)) complain(*wrong);
    if (event->kind == DriverEvent::Kind::kFailed) last_error_ = event->error;
    return;
  }
  if (cell_.driver().state() == DriverState::kOpening) ledger_.may_fail();
  feed();
  flip_now_and_then();
  if (cell_.now() < next_look_) return;
  next_look_ = cell_.now() + kLook;
  watch_way();
  watch_health();
}

void FaultCase::watch_health() {
  const DriverHealth now = cell_.driver().health();
  if (now.requests < health_.requests || now.retries < health_.retries ||
      now.timeouts < health_.timeouts || now.unexpected < health_.unexpected) {
    complain("a health counter ran back");
  }
  health_ = now;
}

void FaultCase::watch_way() {
  if (anywhere_) {
    stray_since_.reset();
    return;
  }
  const sim::Truth truth = cell_.machine().truth();
  std::size_t worst_joint = 0;
  double worst = 0;
  for (std::size_t i = 0; i < way_.size(); ++i) {
    const double q = place(truth.joints[i]);
    const double excess = std::max(way_[i].lower - q, q - way_[i].upper) - rules_.overshoot;
    if (excess <= worst) continue;
    worst = excess;
    worst_joint = i;
  }
  if (worst > 0) return note_stray(worst_joint, worst + rules_.overshoot);
  stray_since_.reset();
}

void FaultCase::note_stray(std::size_t joint, double excess) {
  if (!stray_since_) stray_since_ = cell_.now();
  const Duration stray = cell_.now() - *stray_since_;
  sums_.worst_stray = std::max(sums_.worst_stray, stray);
  sums_.worst_excess = std::max(sums_.worst_excess, excess);
  if (!strayed_) ++sums_.wrong_motions;
  strayed_ = true;
  if (!rules_.trusted && excess <= rules_.excess_max && stray <= rules_.stray_max) return;
  std::ostringstream text;
  text << "J" << joint + 1 << " is " << excess << " beyond the way that was asked for, since "
       << to_seconds(stray) << " s";
  complain(text.str());
}

void FaultCase::flip_now_and_then() {
  if (!flipping_) return;
  // Counted from the last one's byte: on a silent wire it waits for that, and two of them would
  // strike two readings in a row.
  if (cell_.line().flip_pending()) next_flip_ = cell_.now() + *rules_.single_flips;
  if (cell_.line().flip_pending() || cell_.now() < next_flip_) return;
  const auto direction = static_cast<LinkDirection>(random_.integer(0, 1));
  cell_.line().flip_once(direction, random_.bits() % kFlipWithin,
                         static_cast<unsigned>(random_.integer(0, 7)));
}

bool FaultCase::known() const {
  const auto positions = cell_.driver().positions();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const JointPosition& claim = positions[i];
    const auto least =
        rules_.moves_uncertain ? PositionQuality::kUncertain : PositionQuality::kCommanded;
    if (claim.quality < least) return false;
    // A limp arm has sunk out of its limits: it only moves slowly.
    const bool outside =
        claim.q < robot_.joints[i].lower - kNoise || claim.q > robot_.joints[i].upper + kNoise;
    if (outside && rules_.regain == Regain::kSlowMove) return false;
  }
  return true;
}

bool FaultCase::judge_rest() {
  if (rules_.stores_only) return true;
  const sim::Truth truth = cell_.machine().truth();
  const auto positions = cell_.driver().positions();
  bool honest = true;
  bool slipped = false;
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const JointPosition& claim = positions[i];
    if (claim.quality == PositionQuality::kLost) continue;
    const double q = place(truth.joints[i]);
    const double error = std::max(claim.lower - q, q - claim.upper);
    if (error <= rules_.tolerance) continue;
    honest = false;
    sums_.worst_error = std::max(sums_.worst_error, error);
    const sim::JointTruth& joint = truth.joints[i];
    slipped = slipped || joint.stalled || joint.lost_steps || joint.at_end_stop;
    std::ostringstream text;
    text << "J" << i + 1 << " rests at " << q << ", claimed is " << claim.lower << " to "
         << claim.upper << ", quality " << static_cast<int>(claim.quality);
    if (rules_.trusted || rules_.true_at_rest) return complain(text.str());
    wrong_claim_ = text.str();
  }
  if (!honest) ++(slipped ? sums_.slips : sums_.wrong_rests);
  return honest;
}

// Using

void FaultCase::ask_move(double speed) {
  Driver& driver = cell_.driver();
  std::array<double, kMaxJoints> from{};
  std::array<double, kMaxJoints> to{};
  const std::size_t n = robot_.joints.size();
  const auto positions = driver.positions();
  for (std::size_t i = 0; i < n; ++i) {
    const Joint& joint = robot_.joints[i];
    const double way = rules_.way * (joint.upper - joint.lower);
    const bool lost = positions[i].quality == PositionQuality::kLost;
    from[i] = lost ? joint.home : std::clamp(positions[i].q, joint.lower, joint.upper);
    const double margin = 0.02 * (joint.upper - joint.lower);
    to[i] = std::clamp(from[i] + random_.uniform(-way, way),
                       std::max(joint.lower + margin, rules_.lower[i]),
                       std::min(joint.upper - margin, rules_.upper[i]));
  }
  JointVector q_from;
  JointVector q_to;
  for (std::size_t i = 0; i < n; ++i) {
    q_from.push_back(from[i]);
    q_to.push_back(to[i]);
  }
  const bool sure = known();
  const auto profile = program::profile_between(q_from, q_to, robot_, speed);
  const bool streamed = sure && robot_.device.capability.motion == MotionKind::kStream;
  profile_.reset();
  if (streamed) {
    const double longest = to_seconds(robot_.device.capability.segment);
    profile_ = profile;
    segments_ = std::max(1, static_cast<int>(std::ceil(profile.duration() / longest)));
    segments_sent_ = 0;
    motion_end_ = std::max(motion_end_, cell_.now() + from_seconds(profile.duration()) + 100ms);
    widen_way(q_to);
    return feed();
  }
  const Duration slow = rules_.regain == Regain::kSlowMove ? kSlowMove : 0ms;
  const Duration duration = sure ? from_seconds(profile.duration()) + 20ms : slow;
  JointMove move{q_to, {}, std::max(duration, from_seconds(profile.duration()) + 20ms)};
  move.qd.resize(n);
  if (const auto taken = driver.move(move, cell_.now()); !taken) {
    ++sums_.refused;
    last_error_ = taken.error();
    return;
  }
  ledger_.accepted();
  motion_end_ = std::max(motion_end_, cell_.now() + move.duration);
  widen_way(q_to);
}

/// To the target of a motion, and to where it really begins.
void FaultCase::widen_way(const JointVector& target) {
  const sim::Truth truth = cell_.machine().truth();
  for (std::size_t i = 0; i < target.size(); ++i) {
    const double q = place(truth.joints[i]);
    const double end = rules_.stores_only ? q : target[i];
    way_[i].lower = std::min({way_[i].lower, end, q});
    way_[i].upper = std::max({way_[i].upper, end, q});
  }
}

/// As many segments as the driver takes.
void FaultCase::feed() {
  Driver& driver = cell_.driver();
  while (profile_ && segments_sent_ < segments_ && driver.wants_move(cell_.now())) {
    const bool last = segments_sent_ + 1 == segments_;
    const double longest = to_seconds(robot_.device.capability.segment);
    const double segment = segments_ == 1 ? longest : profile_->duration() / segments_;
    motion::AxisStates states;
    profile_->sample(last ? profile_->duration() : segment * (segments_sent_ + 1), states);
    JointMove move;
    move.duration = from_seconds(segment);
    for (std::size_t i = 0; i < profile_->size(); ++i) {
      move.q.push_back(states.q[i]);
      move.qd.push_back(last ? 0 : states.qd[i]);
    }
    if (const auto taken = driver.move(move, cell_.now()); !taken) {
      ++sums_.refused;
      last_error_ = taken.error();
      profile_.reset();
      // What was begun and cannot go on must not be the last word.
      if (ledger_.under_way() > 0) {
        ledger_.stop_asked();
        driver.stop(cell_.now());
      }
      return;
    }
    ledger_.accepted();
    ++segments_sent_;
  }
}

void FaultCase::ask_tool() {
  const std::vector<ToolAction> actions{
      JawsTo{random_.uniform(0, 0.05)},
      GripperTo{random_.chance(0.8), random_.uniform(0, kPi)},
      Suction{static_cast<Suction::State>(random_.integer(0, 2))},
      NozzleTo{random_.uniform(-1, 1), from_seconds(random_.uniform(0.1, 1))},
  };
  for (const ToolAction& action : actions) {
    if (!cell_.driver().tool(action, cell_.now())) continue;
    ledger_.accepted();
    motion_end_ = std::max(motion_end_, cell_.now() + 2s);
    return;
  }
}

void FaultCase::reopen() {
  profile_.reset();
  cell_.driver().close(cell_.now());
  cell_.line().clear(cell_.now());
  if (!run_for(from_seconds(random_.uniform(0, 0.3)), false)) return;
  ledger_.may_fail();
  cell_.driver().open(cell_.now());
}

/// What somebody does who cannot wait.
void FaultCase::act() {
  Driver& driver = cell_.driver();
  const double dice = random_.uniform(0, 1);
  if (dice < 0.06) {
    profile_.reset();
    ledger_.stop_asked();
    driver.stop(cell_.now());
  } else if (dice < 0.09 && rules_.closes) {
    reopen();
  } else if (driver.state() == DriverState::kFault) {
    if (driver.clear_fault(cell_.now())) ledger_.clearing();
  } else if (driver.state() == DriverState::kReady && rules_.regain == Regain::kDeclare &&
             !known()) {
    declare();
  } else if (driver.state() != DriverState::kReady || profile_) {
    if (profile_ && segments_sent_ == segments_ && ledger_.under_way() == 0) profile_.reset();
  } else if (dice < 0.2) {
    ask_tool();
  } else if (known()) {
    ask_move(random_.uniform(0.2, 1));
  }
}

sim::LinkFaultSpec FaultCase::draw_faults(Duration phase) {
  sim::LinkFaultSpec spec;
  spec.seed = random_.bits();
  const double worst = random_.chance(0.5) ? rules_.chance_max : rules_.chance_max / 10;
  const auto draw = [&] {
    if (random_.chance(0.4)) return 0.0;
    return worst * std::pow(10, random_.uniform(-1.5, 0));
  };
  for (sim::ByteFaults& faults : spec.bytes) {
    if (random_.chance(0.1)) continue;  // that way is clean
    faults = {draw(), draw(), std::min(1.0, draw()), draw() / 4,
              from_seconds(random_.uniform(0.001, 0.3))};
  }
  if (!random_.chance(0.3)) return spec;
  sim::LinkCut cut;
  cut.at = from_seconds(random_.uniform(0, to_seconds(phase)));
  cut.lasts = from_seconds(random_.uniform(0.005, 0.8));
  if (random_.chance(0.5)) cut.only = static_cast<LinkDirection>(random_.integer(0, 1));
  spec.cuts.push_back(cut);
  return spec;
}

bool FaultCase::run_for(Duration duration, bool user) {
  const Instant end = cell_.now() + duration;
  while (cell_.now() < end && complaint_.empty()) {
    if (user && cell_.now() >= next_action_) {
      next_action_ = cell_.now() + from_seconds(random_.uniform(0.02, 0.8));
      act();
    }
    const Instant until = user ? std::min(end, next_action_) : end;
    const bool fine =
        cell_.run_to(until, profile_ ? kFeed : kLook, [&] { return !complaint_.empty(); });
    if (!fine) return complain("driver and machine keep each other awake");
  }
  return complaint_.empty();
}

// Finding back

bool FaultCase::settle() {
  flipping_ = false;
  cell_.line().cancel_flips();
  cell_.line().set_faults({}, cell_.now());
  const Instant start = std::max(cell_.now(), motion_end_);
  const auto settled = [&] { return at_rest(cell_.driver()) && ledger_.under_way() == 0; };
  profile_.reset();
  if (ledger_.under_way() > 0 && robot_.device.capability.motion == MotionKind::kStream) {
    // Nobody feeds it any more.
    ledger_.stop_asked();
    cell_.driver().stop(cell_.now());
  }
  // A damaged order may keep a device deaf until just before the limit, or for hours.
  Instant deaf = start;
  const auto run_to = [&](Instant limit) {
    return cell_.run_to(limit, kLook, [&] {
      if (rules_.runs_away && cell_.machine().truth().deaf) deaf = std::max(deaf, cell_.now());
      return settled() || !complaint_.empty();
    });
  };
  bool fine = run_to(start + rules_.recovery);
  if (!settled() && rules_.runs_away && cell_.machine().truth().deaf) {
    ++sums_.runaways;
    return power_cycle();
  }
  if (!settled()) fine = fine && run_to(deaf + rules_.recovery);
  if (!fine) return complain("driver and machine keep each other awake");
  if (!settled()) {
    return complain("not back in time, under way " + std::to_string(ledger_.under_way()));
  }
  sums_.worst_recovery = std::max(sums_.worst_recovery, cell_.now() - deaf);
  return complaint_.empty();
}

/// Out of a fault: acknowledged where that helps, else the power is cut.
bool FaultCase::resolve_fault() {
  const auto faulty = [&] { return cell_.driver().state() == DriverState::kFault; };
  if (!faulty()) return true;
  const auto fault = cell_.driver().fault();
  if (!fault) return complain("in kFault, and fault() says nothing");
  ++sums_.device_faults[std::string(info(fault->code).name)];
  for (int i = 0; i < 2 && faulty(); ++i) {
    if (cell_.driver().clear_fault(cell_.now())) ledger_.clearing();
    if (!run_for(3s, false)) return false;
  }
  if (!faulty() && at_rest(cell_.driver())) return true;
  return power_cycle();
}

bool FaultCase::power_cycle() {
  ++sums_.power_cuts;
  anywhere_ = true;
  const double volts = nominal_volts(cell_.machine());
  cell_.driver().close(cell_.now());
  cell_.machine().disturb({.kind = sim::Disturbance::Kind::kSupply, .value = 0});
  if (!run_for(kPowerOff, false)) return false;
  cell_.machine().disturb({.kind = sim::Disturbance::Kind::kSupply, .value = volts});
  if (!run_for(kPowerUp, false)) return false;
  cell_.line().clear(cell_.now());
  ledger_.may_fail();
  cell_.driver().open(cell_.now());
  motion_end_ = cell_.now();
  if (!settle()) return false;
  // What the device lost with its power may have to be acknowledged.
  for (int i = 0; i < 2 && cell_.driver().state() == DriverState::kFault; ++i) {
    if (cell_.driver().clear_fault(cell_.now())) ledger_.clearing();
    if (!run_for(3s, false)) return false;
  }
  return cell_.driver().state() == DriverState::kReady || complain("a power cut does not help");
}

/// Somebody looks where the machine stands.
void FaultCase::declare() {
  const sim::Truth truth = cell_.machine().truth();
  for (const sim::JointTruth& joint : truth.joints) {
    if (std::abs(joint.qd) > kStill) return;
  }
  std::vector<JointPosition> places;
  for (std::size_t i = 0; i < truth.joints.size(); ++i) {
    const double q = place(truth.joints[i]);
    places.push_back({PositionQuality::kCommanded, q, q, q});
    way_[i] = {std::min(way_[i].lower, q), std::max(way_[i].upper, q)};
  }
  cell_.driver().declare_positions(places);
}

bool FaultCase::regain() {
  if (known()) return true;
  anywhere_ = rules_.regain == Regain::kHome || anywhere_;
  if (rules_.regain == Regain::kDeclare) {
    declare();
  } else if (rules_.regain == Regain::kSlowMove) {
    ask_move(1);
    if (!run_for(kSlowMove + 3s, false)) return false;
  } else if (rules_.regain == Regain::kMeasured) {
    // A damaged time makes a motion last for up to 65 s, and what moves is not measured.
    const Instant limit = cell_.now() + rules_.longest_motion;
    const auto rests = [&] { return known() && !cell_.machine().truth().moving; };
    cell_.run_to(limit, kLook, [&] { return rests() || !complaint_.empty(); });
  } else if (rules_.regain == Regain::kHome) {
    // An axis that was out is left out, until somebody asks for it.
    if (cell_.driver().clear_fault(cell_.now())) ledger_.clearing();
    if (!run_for(3s, false)) return false;
    if (known()) return true;
    ++sums_.homings;
    if (const auto homed = cell_.driver().home(cell_.now()); !homed) {
      return complain("home refused: " + describe(homed.error()));
    }
    ledger_.accepted();
    const Instant limit = cell_.now() + kHomingMax;
    cell_.run_to(limit, kLook, [&] { return ledger_.under_way() == 0 || !complaint_.empty(); });
  }
  if (!run_for(rules_.rest, false)) return false;
  if (known()) return true;
  return complain("the position does not come back");
}

std::string FaultCase::described() const {
  std::ostringstream text;
  text << "state " << static_cast<int>(cell_.driver().state());
  const sim::Truth truth = cell_.machine().truth();
  const auto positions = cell_.driver().positions();
  for (std::size_t i = 0; i < positions.size(); ++i) {
    text << ", J" << i + 1 << " quality " << static_cast<int>(positions[i].quality) << " at "
         << truth.joints[i].q << " with " << truth.joints[i].qd << "/s"
         << (truth.joints[i].at_end_stop ? " in its end" : "")
         << (truth.joints[i].lost_steps ? " with lost steps" : "") << ", counted "
         << truth.joints[i].believed << ", told " << positions[i].q;
  }
  return text.str();
}

/// A damaged order made the device count far away, where no target can be said any more.
bool FaultCase::counts_far_away() {
  const bool far = rules_.runs_away && last_error_ && last_error_->code == ErrorCode::kStepRange;
  if (far) ++sums_.runaways;
  return far;
}

bool FaultCase::clean_motion() {
  for (int tries = 0; tries < 2 && complaint_.empty(); ++tries) {
    if (tries > 0) {
      // An axis that is out, or half a request that the device still had.
      ++sums_.second_tries;
      if (cell_.driver().clear_fault(cell_.now())) ledger_.clearing();
      if (counts_far_away() && !power_cycle()) return false;
      if (!run_for(3s, false) || !regain()) return false;
    }
    const std::uint64_t done = ledger_.done();
    if (!motion_to_its_end() || !run_for(rules_.rest, false)) return false;
    if (ledger_.done() > done && cell_.driver().state() == DriverState::kReady) return true;
  }
  return complain("a clean motion is not done");
}

bool FaultCase::motion_to_its_end() {
  // A target may be one that this wire cannot say.
  for (int i = 0; i < 8 && ledger_.under_way() == 0 && !profile_; ++i) ask_move(1);
  const Duration way = std::max(Duration{}, motion_end_ - cell_.now());
  const Instant limit = cell_.now() + way + rules_.recovery;
  const auto over = [&] {
    const DriverState state = cell_.driver().state();
    const bool sent = !profile_ || segments_sent_ == segments_;
    return state == DriverState::kFault ||
           (state == DriverState::kReady && sent && ledger_.under_way() == 0);
  };
  while (cell_.now() < limit && complaint_.empty() && !over()) {
    cell_.run_to(std::min(limit, cell_.now() + kLook), profile_ ? kFeed : kLook,
                 [&] { return false; });
  }
  profile_.reset();
  return complaint_.empty();
}

void FaultCase::add_counts() {
  sums_.done += ledger_.done();
  sums_.failed += ledger_.failed();
  sums_.stopped += ledger_.stopped();
}

bool FaultCase::begin() {
  ledger_.may_fail();
  cell_.driver().open(cell_.now());
  motion_end_ = cell_.now();
  if (!settle() || !resolve_fault() || !regain() || !clean_motion()) return false;
  return judge_rest() || complain("a clean start, and the claim is not true: " + wrong_claim_);
}

bool FaultCase::clean_motions(int count) {
  for (int i = 0; i < count; ++i) {
    if (!clean_motion()) return false;
    if (!judge_rest()) return complain(kUntrue + wrong_claim_);
  }
  return true;
}

bool FaultCase::episode() {
  ++episode_;
  ++sums_.episodes;
  const Instant start = cell_.now();
  const std::uint64_t faults = cell_.line().counts().faults;
  const sim::Truth truth = cell_.machine().truth();
  for (std::size_t i = 0; i < way_.size(); ++i) {
    const double q = place(truth.joints[i]);
    way_[i] = {q, q};
  }
  anywhere_ = false;
  strayed_ = false;
  const Duration phase = from_seconds(random_.uniform(0.2, to_seconds(rules_.phase)));
  flipping_ = rules_.single_flips.has_value();
  if (!flipping_) cell_.line().set_faults(draw_faults(phase), cell_.now());
  next_action_ = cell_.now();
  bool fine = run_for(phase, true) && settle() && run_for(rules_.rest, false);
  if (fine && cell_.driver().state() != DriverState::kFault) judge_rest();
  fine = fine && complaint_.empty() && settle() && resolve_fault() && regain();
  // Whatever was believed wrongly, one clean motion makes it right.
  fine = fine && clean_motion();
  if (fine && !judge_rest()) fine = complain(kUntrue + wrong_claim_);
  sums_.faults += cell_.line().counts().faults - faults;
  sums_.virtual_time += cell_.now() - start;
  return fine;
}

}  // namespace sinew::test
