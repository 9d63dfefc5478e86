#include <charconv>

#include "sinew/core/number_text.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/model/joint_value.h"
#include "sinew/server/api/api.h"

namespace sinew::server {
namespace {

/// Nine digits lose less than a joint's limit forgives.
constexpr int kDigits = 9;

std::string joint_row(const JointVector& q, const RobotModel& model) {
  std::string row = "joint";
  for (std::size_t j = 0; j < q.size(); ++j) {
    const Joint& joint = model.joints[j];
    row += " " + joint.name + "=" + number_text(shown_value(q[j], joint), kDigits);
    row += shown_unit(joint);
  }
  return row;
}

/// @param numbers  x, y, z, and a quaternion w, x, y, z behind them or not
std::string tool_row(const std::vector<double>& numbers, bool line) {
  std::string row = line ? "line" : "move";
  constexpr const char* kPlaces[] = {" x=", " y=", " z="};
  for (std::size_t i = 0; i < 3; ++i)
    row += kPlaces[i] + number_text(to_mm(numbers[i]), kDigits) + "mm";
  if (numbers.size() == 3) return row;
  const Vec3 turns =
      fixed_xyz(rotation_from_quaternion({numbers[3], numbers[4], numbers[5], numbers[6]}));
  constexpr const char* kTurns[] = {" rx=", " ry=", " rz="};
  const double by[] = {turns.x, turns.y, turns.z};
  for (std::size_t i = 0; i < 3; ++i)
    row += kTurns[i] + number_text(to_deg(by[i]), kDigits) + "deg";
  return row;
}

std::expected<std::string, RpcError> tool_row(const Json& tool, bool line) {
  constexpr double kFarthest = 1000;  // m
  if (tool.size() != 3 && tool.size() != 7) {
    return std::unexpected(invalid("tool has three numbers, or seven with its quaternion"));
  }
  const auto numbers = tool.get<std::vector<double>>();
  for (std::size_t i = 0; i < 3; ++i) {
    if (std::abs(numbers[i]) > kFarthest) return std::unexpected(invalid("tool is too far away"));
  }
  double square = 0;
  for (std::size_t i = 3; i < numbers.size(); ++i) square += numbers[i] * numbers[i];
  if (numbers.size() == 7 && std::abs(square - 1) > 1e-3) {
    return std::unexpected(invalid("the quaternion behind tool's place has to be of length 1"));
  }
  return tool_row(numbers, line);
}

}  // namespace

Api::Answer Api::preview(const Call& call) const {
  const Json& params = call.request.params;
  const RobotModel& model = cell_.station(*call.robot).robot();
  const auto joints_given = params.find("joints");
  const auto tool = params.find("tool");
  const auto text = params.find("text");
  const int given = static_cast<int>(joints_given != params.end()) +
                    static_cast<int>(tool != params.end()) + static_cast<int>(text != params.end());
  if (given != 1) return invalid("robot.preview needs one of joints, tool and text");
  const bool line = call.request.flag("line");
  if (line && tool == params.end()) return invalid("line goes with tool only");
  PreviewWish wish;
  wish.robot = *call.robot;
  if (text != params.end()) wish.text = text->get<std::string>();
  if (joints_given != params.end()) {
    const auto q = joints(*joints_given, *call.robot);
    if (!q) return q.error();
    wish.text = joint_row(*q, model);
  }
  if (tool != params.end()) {
    auto row = tool_row(*tool, line);
    if (!row) return row.error();
    wish.text = std::move(*row);
  }
  if (params.contains("speed")) {
    const double speed = params["speed"].get<double>();
    if (!(speed >= 0.01 && speed <= 1)) return invalid("speed has to be 0.01 to 1");
    if (text != params.end()) return invalid("speed: the rows of text say that");
    if (speed < 1 && model.device.capability.takes_speed) {
      wish.text += " speed=" + number_text(100 * speed, kDigits) + "%";
    }
  }
  if (params.contains("samples")) {
    const auto samples = params["samples"].get<std::uint64_t>();
    if (samples < 2 || samples > 1000) return invalid("samples has to be 2 to 1000");
    wish.samples = samples;
  }
  const auto form = asked_form(call.request, model);
  if (!form) return form.error();
  program::Surroundings around;
  around.table = cell_.table_top(*call.robot);
  auto program = program::read_text(*form, wish.text, "preview", model, around);
  if (!program && program.error().complaints.empty()) return no_form(program.error(), model);
  if (!program) return invalid(to_text(program.error().complaints.front()));
  if (program->steps.empty()) return invalid("the program has no row");
  wish.program = std::move(*program);
  wish.from = standing(cell_.station(*call.robot));
  return Elsewhere{std::move(wish)};
}

}  // namespace sinew::server
