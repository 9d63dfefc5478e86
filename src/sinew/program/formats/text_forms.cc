#include "sinew/program/formats/text_forms.h"

#include <algorithm>
#include <array>

#include "sinew/core/assert.h"
#include "sinew/core/number_text.h"
#include "sinew/core/rotation.h"
#include "sinew/core/units.h"
#include "sinew/devices/kinds.h"
#include "sinew/model/joint_lookup.h"
#include "sinew/program/formats/gcode_file.h"
#include "sinew/program/formats/program_format.h"

namespace sinew::program {
namespace {

using Made = std::expected<std::string, NoForm>;
using MadeRows = std::expected<Rows, NoForm>;

const HexapodGeometry* legs_of(const RobotModel& robot) {
  return std::get_if<HexapodGeometry>(&robot.geometry);
}

std::string numbers(const Vec3& v) {
  return number_text(v.x, 6) + " " + number_text(v.y, 6) + " " + number_text(v.z, 6);
}

/// One row, and what the file says beside it.
std::string rows_of_pose(const PoseFile& pose, const PlatformFit& fit) {
  constexpr const char* kWords[] = {" x=", "mm y=", "mm z=", "mm rx=", "deg ry=", "deg rz="};
  const Vec3 rpy = fixed_xyz(fit.X_BP.R);
  const double values[] = {to_mm(fit.X_BP.p.x), to_mm(fit.X_BP.p.y), to_mm(fit.X_BP.p.z),
                           to_deg(rpy.x),       to_deg(rpy.y),       to_deg(rpy.z)};
  std::string text = "# heads fit the platform to " + number_text(to_mm(fit.residual), 6) +
                     " mm; totals of moves " + numbers(to_mm(1) * pose.translation_total) +
                     " mm, of turns " + numbers(to_deg(1) * pose.rotation_total) + " deg\nmove";
  for (std::size_t i = 0; i < std::size(values); ++i) {
    text += kWords[i] + number_text(values[i], 6);
  }
  return text + "deg\n";
}

MadeRows of_pose(std::string_view text, const std::string& file_name, const RobotModel& robot) {
  const auto pose = read_pose_file(text, file_name);
  if (!pose) return no_form(pose.error());
  const auto fit = platform_of(*pose, robot, file_name, 1);
  if (!fit) return std::unexpected(fit.error());
  return Rows{rows_of_pose(*pose, *fit), {1, 1}};
}

MadeRows of_gcode(std::string_view text, const std::string& file_name, const RobotModel& robot) {
  auto rows = rows_of_gcode(text, file_name, robot);
  if (!rows) return no_form(rows.error());
  return std::move(*rows);
}

Made pose_of(const Program& program, const RobotModel& robot, DecimalMark mark) {
  const auto plan = make_plan(program, robot, home_joints(robot));
  if (!plan) return std::unexpected(NoForm{{}, {}, plan.error()});
  const auto* geometry = legs_of(robot);
  if (geometry == nullptr) return no_form(".pos files are a platform's; " + robot.id + " is none");
  const auto* move =
      plan->orders.size() == 1 ? std::get_if<MoveOrder>(&plan->orders[0].what) : nullptr;
  if (move == nullptr) {
    return no_form("a .pos file is one pose: it takes a program of one row that moves");
  }
  const auto pose = kinematics::Hexapod(*geometry).forward(move->q, geometry->X_BP_home);
  if (!pose) {
    return std::unexpected(
        NoForm{{}, {}, Refusal{plan->orders[0].line, pose.error(), std::nullopt}});
  }
  return pose_text(pose_file(pose->X_BP, *geometry), mark);
}

constexpr std::array<std::string_view, 1> kPoseEndings{".pos"};
constexpr std::array<std::string_view, 5> kGcodeEndings{".gcode", ".ngc", ".nc", ".tap", ".g"};
constexpr TextForm kPoseForm{
    .name = "pos", .endings = kPoseEndings, .rows = of_pose, .text = pose_of};
constexpr TextForm kGcodeForm{.name = "gcode", .endings = kGcodeEndings, .rows = of_gcode};

}  // namespace

// One line for each form of a kind of device, here and in the list.
extern const TextForm kSequenceForm;

namespace {

constexpr std::array kForms{&kSequenceForm, &kPoseForm, &kGcodeForm};

}  // namespace

const TextForm* text_form(std::string_view name) {
  const auto found = std::ranges::find(kForms, name, &TextForm::name);
  return found != kForms.end() ? *found : nullptr;
}

std::string form_names(bool written) {
  std::vector<std::string_view> names;
  for (const TextForm* form : kForms) {
    if (!written || form->text != nullptr) names.push_back(form->name);
  }
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) list += i + 1 < names.size() ? ", " : " or ";
    list += names[i];
  }
  return list;
}

std::expected<PlatformFit, NoForm> platform_of(const PoseFile& pose, const RobotModel& robot,
                                               const std::string& file_name, int line) {
  const auto* geometry = legs_of(robot);
  if (geometry == nullptr) return no_form("it is a platform's file; " + robot.id + " is none");
  const auto fit = fit_platform(pose.heads, *geometry);
  if (fit.residual <= kPlatformResidualMax) return fit;
  return no_form(std::vector<Complaint>{
      {file_name, line, 1, "",
       "these heads are no place of " + robot.id + "'s platform: they are up to " +
           number_text(to_mm(fit.residual), 3) + " mm off, " +
           number_text(to_mm(kPlatformResidualMax), 1) + " mm is allowed"}});
}

const TextForm* form_of_file(std::string_view name) {
  for (const TextForm* form : kForms) {
    const auto fits = [&](std::string_view ending) { return name.ends_with(ending); };
    if (std::ranges::any_of(form->endings, fits)) return form;
  }
  return nullptr;
}

const TextForm* form_of_text(std::string_view name, std::string_view text,
                             const RobotModel& robot) {
  if (const TextForm* form = form_of_file(name)) return form;
  if (name.ends_with(".sinew")) return nullptr;
  std::string_view first;
  for_each_line(text, [&](int, std::string_view line) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == std::string_view::npos || line[begin] == '#') return true;
    first = line.substr(begin, line.find_first_of(" \t", begin) - begin);
    return false;
  });
  const bool code = first.size() > 1 && std::string_view("GMS").contains(first[0]) &&
                    first[1] >= '0' && first[1] <= '9';
  if (!code && first != "BEGIN") return nullptr;
  const auto own = std::ranges::find_if(
      kForms, [&](const TextForm* form) { return form->is_own != nullptr && form->is_own(robot); });
  return own != kForms.end() ? *own : &kGcodeForm;
}

MadeRows rows_of(const TextForm& form, std::string_view text, const std::string& file_name,
                 const RobotModel& robot) {
  auto rows = form.rows(text, file_name, robot);
  if (!rows) return rows;
  // What was made is a program, laid out.
  if (const auto program = parse(rows->text, file_name, robot); !program) {
    return no_form(program.error());
  }
  auto out = program::format(rows->text, file_name);
  if (!out) return no_form(out.error());
  rows->text = std::move(*out);
  return rows;
}

std::expected<Program, NoForm> read_form(const TextForm& form, std::string_view text,
                                         const std::string& file_name, const RobotModel& robot) {
  const auto rows = form.rows(text, file_name, robot);
  if (!rows) return std::unexpected(rows.error());
  auto program = parse(rows->text, file_name, robot);
  if (!program) return no_form(program.error());
  for (Step& step : program->steps)
    step.line = rows->lines[static_cast<std::size_t>(step.line - 1)];
  program->notes = rows->notes;
  return std::move(*program);
}

std::expected<Program, NoForm> read_text(const TextForm* form, std::string_view text,
                                         const std::string& file_name, const RobotModel& robot,
                                         const Surroundings& around) {
  if (form != nullptr) return read_form(*form, text, file_name, robot);
  auto program = parse(text, file_name, robot, around);
  if (!program) return no_form(program.error());
  return std::move(*program);
}

Made text_of(const TextForm& form, const Program& program, const RobotModel& robot,
             DecimalMark mark) {
  SINEW_ASSERT(form.text != nullptr);
  return form.text(program, robot, mark);
}

}  // namespace sinew::program
