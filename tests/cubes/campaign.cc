#include "cubes/campaign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "cubes/reach.h"
#include "cubes/truth_watch.h"
#include "sinew/core/error_code.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/program/plans/cube_rows.h"
#include "sinew/runtime/cameras/cube_eyes.h"

namespace sinew::cubes {
namespace {

using grasping::Cube;
using sim::CubePlace;
using Kind = sim::CubeEvent::Kind;

constexpr double kSame = 0.012;         // m, from a cube that is seen to the true one
constexpr double kPictureError = 1e-3;  // m, of a place, beside the calibration's

/// Papers, strips of tape, discs and bricks, not where the arm and the basket stand.
std::vector<Thing> clutter_by(SplitMix64& random) {
  constexpr std::array kColors{0xF4F4F0U, 0x303236U, 0xD8D8D8U, 0x8090A0U, 0x704828U, 0xC02020U};
  std::vector<Thing> things;
  for (auto n = random.bits() % 7; n > 0; --n) {
    Thing thing;
    const auto kind = random.bits() % 4;
    const double size = random.uniform(0.01, 0.025);
    if (kind == 0) thing.half = {3 * size, 4 * size, 5e-5};
    if (kind == 1) thing.half = {3 * size, 0.01, 5e-5};
    if (kind == 2) thing.half = {size, size, random.uniform(1e-3, 8e-3)};
    if (kind == 3) thing.half = {1.5 * size, 0.7 * size, random.uniform(5e-3, 8e-3)};
    if (kind == 2) thing.form = Thing::Form::kDisc;
    thing.srgb = kColors[random.bits() % kColors.size()];
    const Vec3 at{random.uniform(-0.06, 0.16), random.uniform(-0.2, 0.05), thing.half.z + 2e-5};
    thing.X_WS = {rotation_z(random.uniform(0, kPi)), at};
    things.push_back(thing);
  }
  return things;
}

/// What is not in the basket, in front of the robot.
struct Left {
  std::vector<Cube> cubes;
  std::vector<std::size_t> index;  ///< among the world's
};
Left left_of(CubeCell& cell, const std::vector<sim::CubeState>& cubes) {
  const Cell& file = cell.cell().cell();
  const auto X_BT = file.robots[0].X_WB.inverse() * file.cameras[0].X_WT;
  Left left;
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    const sim::CubeState& cube = cubes[i];
    if (cube.where == CubePlace::kBasket || cube.where == CubePlace::kGone) continue;
    const Vec3 x = X_BT.R * cube.X_WO.R.x;
    left.cubes.push_back({X_BT * cube.X_WO.p, std::atan2(x.y, x.x), cube.edge, cube.color});
    left.index.push_back(i);
  }
  return left;
}

std::optional<std::size_t> nearest_to(const std::vector<Cube>& cubes, const Vec3& p) {
  std::optional<std::size_t> best;
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    const double far = norm(cubes[i].p_BO - p);
    if (far < kSame && (!best || far < norm(cubes[*best].p_BO - p))) best = i;
  }
  return best;
}

program::Sighting last_sighting(CubeCell& cell) {
  const Cell& file = cell.cell().cell();
  const auto shot = cell.cell().camera(0)->newest();
  const runtime::CubeEyes::Place place{shot->X_WT, file.robots[0].X_WB, file.baskets};
  return runtime::sighting_of(shot->seen, file.cameras[0].cube, place);
}

std::optional<program::Refusal> refusal_of(CubeCell& cell, const program::Sighting& seen,
                                           const Cube& cube) {
  program::RowPlanner planner(cell.robot());
  const auto table = cell.cell().table_top(0);
  const runtime::StationView view = cell.cell().station(0).view();
  program::PickCubeStep pick;
  pick.p_BT = cube.p_BO + Vec3{0, 0, cube.edge / 2};
  const program::Step row{1, pick, 0};
  const auto rows = program::rows_to_pick(planner, program::Standing(*view.reference, view.tool),
                                          row, seen, program::baskets_on(table.get()));
  return rows ? std::nullopt : std::optional(rows.error());
}

/// What the last picture shows and refuses, held against where the cubes really are.
void check_refusals(std::uint64_t seed, CubeCell& cell, const Left& left,
                    std::span<const planning::PlacedBox> fixed, Tally& tally) {
  const program::Sighting seen = last_sighting(cell);
  double slack = kPictureError;
  for (const Cube& cube : seen.cubes) {
    const auto same = nearest_to(left.cubes, cube.p_BO);
    if (same) slack = std::max(slack, norm(left.cubes[*same].p_BO - cube.p_BO));
  }
  for (const Cube& cube : seen.cubes) {
    const auto refusal = refusal_of(cell, seen, cube);
    const auto same = nearest_to(left.cubes, cube.p_BO);
    if (!same) ++tally.ghosts;
    if (!refusal) {
      tally.findings.push_back(fmt::format("seed {}: a cube was left that can be planned", seed));
      continue;
    }
    ++tally.refused;
    if (!same || !can_take(cell.robot(), left.cubes, fixed, *same, slack)) continue;
    ++tally.refused_wrongly;
    const Vec3& p = left.cubes[*same].p_BO;
    tally.findings.push_back(fmt::format("seed {}: refused wrongly at {:.0f}, {:.0f}: {}", seed,
                                         1e3 * p.x, 1e3 * p.y, describe(refusal->error)));
  }
}

/// Nothing moves, and the fault is the right one.
void run_knocked(std::uint64_t seed, CubeCell& cell, Tally& tally) {
  ++tally.knocked;
  const JointVector before = cell.joints();
  const Ended ended = cell.run("pick\n");
  double moved = 0;
  const JointVector after = cell.joints();
  for (std::size_t j = 0; j < before.size(); ++j) {
    moved = std::max(moved, std::abs(after[j] - before[j]));
  }
  const bool named = ended.job.failure && ended.job.failure->error.code == ErrorCode::kCameraMoved;
  if (named && moved < from_deg(0.1)) {
    ++tally.knocked_refused;
    return;
  }
  tally.findings.push_back(
      fmt::format("seed {}: a knocked camera: {}, {:.1f} deg moved", seed,
                  ended.job.failure ? describe(ended.job.failure->error) : std::string("no fault"),
                  to_deg(moved)));
}

std::string end_of(const Ended& ended) {
  if (ended.job.failure) return std::string(info(ended.job.failure->error.code).name);
  return ended.job.over ? "done" : "not over";
}

void count(std::uint64_t seed, CubeCell& cell, const std::vector<bool>& reachable,
           std::span<const planning::PlacedBox> fixed, const Ended& ended, Tally& tally) {
  const Left left = left_of(cell, ended.cubes);
  const bool looked = ended.job.over && !ended.job.failure;
  const auto seen = looked ? last_sighting(cell).cubes : std::vector<Cube>{};
  for (std::size_t i = 0; i < reachable.size(); ++i) {
    const bool in_basket = ended.cubes[i].where == CubePlace::kBasket;
    ++tally.cubes;
    if (!reachable[i]) {
      if (in_basket) ++tally.beyond;
      continue;
    }
    ++tally.reachable;
    if (in_basket) {
      ++tally.placed;
      continue;
    }
    const auto k = std::ranges::find(left.index, i) - left.index.begin();
    std::string why = end_of(ended);
    Vec3 p;
    if (k < std::ssize(left.index)) {
      p = left.cubes[static_cast<std::size_t>(k)].p_BO;
      if (looked && !nearest_to(seen, p)) {
        ++tally.unseen;
        why = "not seen";
      }
    }
    tally.findings.push_back(fmt::format("seed {}: cube {} (color {}) left at {:.0f}, {:.0f}: {}",
                                         seed, i, ended.cubes[i].color, 1e3 * p.x, 1e3 * p.y, why));
  }
  if (looked) check_refusals(seed, cell, left, fixed, tally);
}

/// A cheap camera's, in a room: shutters of 3 to 30 ms, read-out rows, compression, tint.
render::Sensor sensor_by(SplitMix64& random, double exposure) {
  render::Sensor sensor;
  sensor.exposure = exposure;
  sensor.blur = random.uniform(0.5, 1.1);
  sensor.noise = random.uniform(0.002, 0.01);
  sensor.grain = random.uniform(0.005, 0.02);
  sensor.saturation = random.uniform(0.85, 1.2);
  sensor.contrast = random.uniform(0, 0.5);
  const auto gain = [&] { return static_cast<float>(std::exp(random.uniform(-0.15, 0.15))); };
  sensor.balance = {gain(), 1, gain()};
  sensor.jpeg = 60 + static_cast<int>(random.bits() % 36);
  sensor.shutter = random.uniform(3e-3, 30e-3);
  sensor.read_out = random.uniform(8e-3, 30e-3);
  return sensor;
}

/// The white balance follows the scene, `t` s later: slowly, as glances do not come faster in cells
/// whose time does.
render::Sensor drifted(render::Sensor sensor, double drift, double t) {
  const auto by = static_cast<float>(std::exp(drift * std::sin(2 * kPi * t / 1200)));
  sensor.balance.r *= by;
  sensor.balance.b /= by;
  return sensor;
}

}  // namespace

CampaignCell cell_by(std::uint64_t seed) {
  SplitMix64 random(seed * 0x9E3779B97F4A7C15ULL + 17);
  CampaignCell cell;
  cell.is_knocked = random.uniform(0, 1) < 0.1;
  CubeCellSettings& settings = cell.settings;
  settings.seed = settings.surroundings = seed;
  if (random.uniform(0, 1) < 0.25) settings.robot = "maxarm";
  settings.cubes = 1 + random.bits() % (cell.is_knocked ? 4 : 12);
  settings.anywhere = true;
  settings.clutter = clutter_by(random);
  settings.lamps = 1 + static_cast<int>(random.bits() % 3);
  const double exposure = std::exp(random.uniform(std::log(0.5), std::log(1.7)));
  const double off = random.uniform(0, 3e-3), toward = random.uniform(0, 2 * kPi);
  settings.calibration = {off * std::cos(toward), off * std::sin(toward),
                          random.uniform(-from_deg(0.3), from_deg(0.3))};
  cell.has_hand = random.uniform(0, 1) < 0.2;
  cell.hand_W = {random.uniform(-0.05, 0.1), random.uniform(-0.15, 0.05), 0.02};
  cell.hand_begins = random.uniform(0, 60);
  cell.hand_ends = cell.hand_begins + random.uniform(5, 60);
  if (cell.is_knocked) {
    settings.sheet = true;
    settings.clutter.clear();  // it would hide the tags
    cell.has_hand = false;
    const double far = random.uniform(8e-3, 25e-3);
    cell.trouble.knocked = {far * std::cos(toward), far * std::sin(toward), 0};
  }
  cell.trouble.sensor = sensor_by(random, exposure);
  cell.drift = random.uniform(0, 0.08);
  settings.lens = {random.uniform(-0.2, 0), random.uniform(-0.02, 0.02), 0, 0, 0};
  // A hand that is gone again within a second or two is seen by no camera of ten pictures a second.
  if (cell.has_hand) settings.pace = 4;
  return cell;
}

void run_cell(std::uint64_t seed, Tally& tally) {
  const CampaignCell what = cell_by(seed);
  CubeCell cell(what.settings);
  ++tally.cells;
  cell.stand_aside();
  cell.table().set_trouble(what.trouble);
  if (what.is_knocked) return run_knocked(seed, cell, tally);
  std::vector<sim::CubeState> first;
  cell.table().cubes().with([&](const sim::CubeWorld& world) {
    first.assign(world.cubes().begin(), world.cubes().end());
  });
  TruthWatch watch(cell, what.settings.clutter);
  const PlanarError& off = what.settings.calibration;
  const auto reachable = can_be_taken(cell.robot(), left_of(cell, first).cubes, watch.fixed(),
                                      kPictureError + std::hypot(off.x, off.y));
  const runtime::Station& arm = cell.cell().station(0);
  const Instant begin = arm.view().at;
  bool hand_was_there = false, was_paused = false, hand_paused = false;
  const auto look = [&] {
    watch.look();
    const double t = to_seconds(arm.view().at - begin);
    const bool is_there = what.has_hand && t >= what.hand_begins && t < what.hand_ends;
    const runtime::JobView job = cell.cell().jobs(0).view();
    if (job.paused && !was_paused && !is_there && !hand_was_there) {
      ++tally.paused_wrongly;
      tally.findings.push_back(fmt::format("seed {}: paused at {:.1f} s", seed, t));
    }
    was_paused = job.paused;
    hand_paused = hand_paused || (job.paused && is_there);
    if (is_there && !hand_was_there) ++tally.hands;
    hand_was_there = is_there;
    auto trouble = what.trouble;
    trouble.sensor = drifted(trouble.sensor, what.drift, t);
    if (is_there) trouble.hand = render::ViewedHand{what.hand_W, -kPi / 2};
    cell.table().set_trouble(trouble);
    // A person takes the hand away, or looks and finds nothing, and has it go on.
    if (!is_there && job.paused) cell.cell().jobs(0).resume(job.id);
  };
  const Ended ended = cell.run_own_program(look);
  tally.hands_noticed += hand_paused ? 1 : 0;
  ++tally.ends[end_of(ended)];
  if (ended.job.failure) {
    tally.findings.push_back(
        fmt::format("seed {}: the program ended: {}", seed, describe(ended.job.failure->error)));
  }
  for (const auto& contact : watch.contacts(ended)) {
    ++tally.contacts;
    tally.findings.push_back(fmt::format("seed {}: contact: {}", seed, contact));
  }
  if (watch.joints_outside() > 0) {
    tally.findings.push_back(fmt::format("seed {}: a joint outside of its limits", seed));
  }
  tally.outside += watch.joints_outside();
  tally.thrown += ended.count(Kind::kThrown);
  count(seed, cell, reachable, watch.fixed(), ended, tally);
}

std::string Tally::table() const {
  std::string text;
  const auto row = [&](const char* what, std::size_t number) {
    text += fmt::format("  {:<52}{:>6}\n", what, number);
  };
  row("cells", cells);
  row("cubes", cubes);
  row("reachable (brute force)", reachable);
  row("of these in the basket", placed);
  row("of these left unseen", unseen);
  row("in the basket though brute force found no grasp", beyond);
  row("thrown", thrown);
  row("contacts with anything but the cube", contacts);
  row("looks at a joint outside of its limits", outside);
  row("cubes refused in the last picture", refused);
  row("of these wrongly", refused_wrongly);
  row("cubes seen where none lies, in the last picture", ghosts);
  row("cells with a hand in view", hands);
  row("of these paused meanwhile", hands_noticed);
  row("pauses though nothing came into view", paused_wrongly);
  row("cells with a knocked camera", knocked);
  row("of these refused, nothing moved", knocked_refused);
  for (const auto& [end, number] : ends) row(("programs that ended: " + end).c_str(), number);
  return text;
}

}  // namespace sinew::cubes
