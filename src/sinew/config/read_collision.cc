#include "sinew/config/read_collision.h"

#include <algorithm>

#include "sinew/core/rotation.h"
#include "sinew/core/spelling.h"
#include "sinew/devices/table_file.h"
#include "sinew/model/collision_links.h"

namespace sinew {
namespace {

constexpr Range kPlace = between(-10, 10);      // m
constexpr Range kThickness = above_zero_to(2);  // m
constexpr Range kMargin = between(0, 0.5);      // m
constexpr Range kAnyAngle = between(-2 * kPi, 2 * kPi);
constexpr std::size_t kMaxNameBytes = 32;

enum class Form : std::uint8_t { kCapsule, kBox, kLeg, kFinger, kHeld };

/// A link's name under `key`.
bool read_link(TableReader& reader, std::string_view key, const RobotModel& model, bool table,
               std::uint8_t& link) {
  std::string name;
  if (!reader.text(key, kMaxNameBytes, name)) return false;
  const std::optional<std::uint8_t> found = link_named(model, name);
  if (found && (table || *found != kTableLink)) {
    link = *found;
    return true;
  }
  std::vector<std::string_view> names;
  names.reserve(link_count(model) + 1);
  for (std::size_t i = 0; i < link_count(model); ++i) names.push_back(link_name(model, i));
  if (table) names.push_back(kTableName);
  const std::string_view meant = nearest_spelling(name, names);
  std::string message = "must be " + any_of_text(names) + ", not `" + printable(name) + "`";
  if (!meant.empty()) message += "; did you mean `" + std::string(meant) + "`?";
  reader.complain(key, std::move(message));
  return false;
}

Capsule read_capsule(TableReader& reader) {
  Capsule capsule;
  reader.vector("from_*", kLength, kPlace, capsule.p_LA);
  reader.vector("to_*", kLength, kPlace, capsule.p_LB);
  reader.quantity("radius_*", kLength, kThickness, capsule.radius);
  return capsule;
}

CollisionBox read_box(TableReader& reader) {
  CollisionBox box;
  Vec3 rpy;
  reader.vector("xyz_*", kLength, kPlace, box.X_LX.p);
  if (reader.vector("rpy_*", kAngle, kAnyAngle, rpy)) box.X_LX.R = rotation_from_fixed_xyz(rpy);
  reader.vector("half_*", kLength, kThickness, box.half);
  return box;
}

JawFinger read_finger(TableReader& reader) {
  constexpr Named<double> kSides[] = {{"+y", 1}, {"-y", -1}};
  JawFinger finger;
  reader.choice("side", kSides, finger.side);
  reader.vector("half_*", kLength, kThickness, finger.half);
  return finger;
}

bool has_jaws(const RobotModel& model) {
  const auto* serial = std::get_if<SerialGeometry>(&model.geometry);
  return serial != nullptr && serial->gripper;
}

void read_shape(TableReader& reader, const RobotModel& model, CollisionShape& shape) {
  constexpr Named<Form> kForms[] = {{"capsule", Form::kCapsule},
                                    {"box", Form::kBox},
                                    {"leg", Form::kLeg},
                                    {"finger", Form::kFinger},
                                    {"held", Form::kHeld}};
  const bool linked = read_link(reader, "link", model, false, shape.link);
  Form form{};
  if (!reader.choice("form", kForms, form)) {
    reader.ignore_rest();
    reader.finish();
    return;
  }
  switch (form) {
    case Form::kCapsule:
      shape.form = read_capsule(reader);
      break;
    case Form::kBox:
      shape.form = read_box(reader);
      break;
    case Form::kLeg:
      reader.quantity("radius_*", kLength, kThickness, shape.form.emplace<LegCapsule>().radius);
      break;
    case Form::kFinger:
      shape.form = read_finger(reader);
      break;
    case Form::kHeld:
      shape.form = HeldBall{};
      break;
  }
  const bool of_jaws = form == Form::kFinger || form == Form::kHeld;
  if (linked && of_jaws && !(has_jaws(model) && link_name(model, shape.link) == kToolName)) {
    reader.complain("form",
                    "only the tool of a robot with a [gripper] may have `finger` and `held`");
  }
  if (linked && is_leg(model, shape.link) != (form == Form::kLeg)) {
    reader.complain("form", form == Form::kLeg ? "only the legs of a hexapod may be `leg`"
                                               : "the legs of a hexapod must be `leg`");
  }
  reader.finish();
}

void read_ignored(TableReader& reader, const RobotModel& model, Collision& collision) {
  LinkPair pair;
  const bool first = read_link(reader, "first", model, true, pair.first);
  const bool second = read_link(reader, "second", model, true, pair.second);
  reader.finish();
  if (!first || !second) return;
  if (links_joined(model, pair.first, pair.second)) {
    reader.complain("second", "these two are joined, or one, and never held against each other");
  }
  const bool again = std::ranges::any_of(collision.ignored, [&](const LinkPair& other) {
    return std::minmax(other.first, other.second) == std::minmax(pair.first, pair.second);
  });
  if (again) reader.complain("second", "these two are ignored already");
  collision.ignored.push_back(pair);
}

/// Where a joint is called like a link that every robot has, names would mean two things.
bool names_are_clear(TableReader& reader, const RobotModel& model) {
  for (const Joint& joint : model.joints) {
    for (const std::string_view taken : {kStandName, kToolName, kPlatformName, kTableName}) {
      if (joint.name != taken) continue;
      reader.complain("a joint is called `" + joint.name +
                      "`, which is the name of something else here");
      return false;
    }
  }
  return true;
}

}  // namespace

void read_collision(TableReader& root, RobotModel& model) {
  std::optional<TableReader> reader = root.table("collision", Presence::kOptional);
  if (!reader || !joints_are_sound(model) || !names_are_clear(*reader, model)) return;
  Collision& collision = model.collision;
  reader->quantity("margin_*", kLength, kMargin, collision.margin);
  if (std::optional<TableReader> table = reader->table("table", Presence::kOptional)) {
    double height = 0;
    if (table->quantity("height_*", kLength, kPlace, height)) collision.table_height = height;
    table->finish();
  }
  for (TableReader& shape : reader->tables("shape")) {
    if (collision.shapes.size() == kCollisionShapesMax) {
      shape.complain("one shape too many: a robot has at most " +
                     std::to_string(kCollisionShapesMax));
      break;
    }
    read_shape(shape, model, collision.shapes.emplace_back());
  }
  for (TableReader& ignored : reader->tables("ignore", Presence::kOptional)) {
    read_ignored(ignored, model, collision);
  }
  reader->finish();
}

}  // namespace sinew
