#include "sinew/cli/cameras/camera_hand_eye.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "sinew/calibration/hand_eye.h"
#include "sinew/cli/cameras/camera_marks.h"
#include "sinew/cli/cameras/camera_next_pose.h"
#include "sinew/cli/cameras/camera_robot.h"
#include "sinew/cli/output/kinematics_text.h"
#include "sinew/cli/output/quantity.h"
#include "sinew/cli/output/table.h"
#include "sinew/config/camera_file.h"
#include "sinew/config/hand_eye_file.h"
#include "sinew/core/spelling.h"
#include "sinew/core/units.h"
#include "sinew/io/file.h"
#include "sinew/model/cell.h"
#include "sinew/runtime/cameras/read_picture.h"
#include "sinew/vision/tags.h"

namespace sinew::cli {
namespace {

using calibration::CameraMounting;
using calibration::HandEye;
using calibration::HandEyeView;

constexpr const char* kExample =
    "sinew camera hand-eye view*.jpg --robot learm --points points.toml --camera camera.toml "
    "--mount arm --out hand_eye.toml";

/// What one call works with.
struct Mounted {
  const CameraRequest& request;
  CalibrationRobot robot;
  vision::TableCamera camera;
  vision::TagBoard target;
  calibration::HandEyeSettings settings;
  std::vector<HandEyeView> views;
  std::vector<JointVector> joints;  ///< by view

  bool on_arm() const { return settings.mounting == CameraMounting::kOnFlange; }
  std::string camera_mount() const { return on_arm() ? "the flange" : base(); }
  std::string target_mount() const { return on_arm() ? base() : "the flange"; }
  std::string base() const { return "the base of " + robot.name; }
  std::string table_name() const { return on_arm() ? target_name() : "camera's table"; }
  bool single_tag() const { return request.target != "board" && request.target != "sheet"; }
  std::string target_name() const {
    if (!single_tag()) return request.target;
    return fmt::format("tag {}", target.first);
  }
};

/// "36h11:7:30mm".
std::expected<vision::TagBoard, Outcome> tag_target(const std::string& text) {
  const auto complain = [&](const std::string& what) {
    return std::unexpected(bad_input("--target: " + what));
  };
  const std::size_t first = text.find(':');
  const std::size_t second = first == std::string::npos ? first : text.find(':', first + 1);
  if (second == std::string::npos) {
    return complain("'" + printable(text) +
                    "' is neither board nor sheet, nor a tag as FAMILY:ID:SIDE (36h11:7:30mm)");
  }
  const auto family = vision::tag_family_named(text.substr(0, first));
  if (!family) {
    return complain("'" + printable(text.substr(0, first)) +
                    "' is neither 36h11 nor Standard41h12");
  }
  const std::string digits = text.substr(first + 1, second - first - 1);
  const bool number = !digits.empty() && digits.size() <= 5 &&
                      digits.find_first_not_of("0123456789") == std::string::npos;
  if (!number || !vision::tag_cells(*family, std::stoi(digits))) {
    return complain("the family has no tag '" + printable(digits) + "'");
  }
  const auto side = parse_quantity(text.substr(second + 1), Measure::kLength, UnitRule::kOptional);
  if (!side) return complain(side.error());
  if (!(*side >= 0.002 && *side <= 2)) return complain("the side must be 2 mm to 2 m");
  return vision::single_tag(*family, std::stoi(digits), *side);
}

std::expected<vision::TagBoard, Outcome> target_of(const CameraRequest& request) {
  if (request.target != "board" && request.target != "sheet") return tag_target(request.target);
  auto board = request.target == "board" ? vision::calibration_board(request.paper)
                                         : vision::table_sheet(request.paper);
  if (!board) return std::unexpected(wrong_paper(request));
  return std::move(*board);
}

std::optional<Outcome> incomplete(const CameraRequest& request) {
  const auto needs = [&](bool there, const char* what) -> std::optional<Outcome> {
    if (there) return std::nullopt;
    return bad_input(fmt::format("camera hand-eye: {}; {}", what, kExample));
  };
  if (auto missing = needs(!request.images.empty(), "images are missing")) return missing;
  if (auto missing = needs(request.robot.has_value(), "--robot is missing")) return missing;
  if (auto missing = needs(request.camera.has_value(),
                           "--camera is missing, the file of sinew camera calibrate")) {
    return missing;
  }
  if (auto missing = needs(request.out.has_value(), "--out is missing, the file to write")) {
    return missing;
  }
  return needs(request.mount && (*request.mount == "arm" || *request.mount == "table"),
               "--mount must be arm (camera on the arm) or table (target on the arm)");
}

std::expected<Mounted, Outcome> read_settings(const CameraRequest& request) {
  if (auto missing = incomplete(request)) return std::unexpected(std::move(*missing));
  auto target = target_of(request);
  if (!target) return std::unexpected(target.error());
  const auto zeros = parse_quantity(request.zeros_deg, Measure::kAngle, UnitRule::kOptional);
  if (!zeros || !(*zeros >= 0 && *zeros <= from_deg(30))) {
    return std::unexpected(bad_input("--zeros-deg: " + (zeros ? "is 0 to 30 deg" : zeros.error())));
  }
  auto robot = calibration_robot(*request.robot, request.cell);
  if (!robot) return std::unexpected(robot.error());
  if (*zeros > 0 && !std::holds_alternative<SerialGeometry>(robot->model.geometry)) {
    return std::unexpected(
        bad_input("--zeros-deg: only serial arms have it; " + robot->model.id + " is none"));
  }
  auto camera = camera_of(request);
  if (!camera) return std::unexpected(camera.error());
  Mounted mounted{request, std::move(*robot), std::move(*camera), std::move(*target), {}, {}, {}};
  mounted.settings.mounting =
      *request.mount == "arm" ? CameraMounting::kOnFlange : CameraMounting::kFixed;
  mounted.settings.joint_offset_sigma = *zeros;
  // What a ruler and white that spreads over black edges leave open. Tags of a board that are all
  // smaller stay where they are.
  constexpr double kTagSize = 0.02;
  mounted.settings.size_sigma = mounted.single_tag() ? kTagSize : 0;
  return mounted;
}

std::expected<vision::BoardCorners, Outcome> corners_of(const Mounted& mounted,
                                                        const std::string& path,
                                                        vision::TagFinder& finder) {
  const auto picture = runtime::read_picture(path);
  if (!picture) return std::unexpected(could_not(picture.error()));
  const vision::CameraModel& model = mounted.camera.model;
  if (picture->width != model.width || picture->height != model.height) {
    return std::unexpected(could_not(
        fmt::format("{}: is {} x {} px; {} is of a camera of {} x {} px. Take images of that size, "
                    "or calibrate again: sinew camera calibrate",
                    path, picture->width, picture->height, *mounted.request.camera, model.width,
                    model.height)));
  }
  auto seen = corners_in(mounted.target, finder.find(*picture));
  if (seen.pixels.empty()) {
    return std::unexpected(could_not(fmt::format(
        "{}: does not show the {}. Leave the image out, or name what it shows with --target "
        "(sinew camera tags {})",
        path, mounted.target_name(), path)));
  }
  return seen;
}

/// Images and the joints of the points that are named as they are.
std::expected<void, Outcome> read_views(Mounted& mounted, const TaughtPoints& points) {
  const CameraRequest& request = mounted.request;
  vision::TagFinder finder({mounted.target.family});
  for (const std::string& path : request.images) {
    const std::string name = std::filesystem::path(path).stem().string();
    const auto point = std::ranges::find(points, name, &TaughtPoint::name);
    if (point == points.end()) {
      return std::unexpected(could_not(fmt::format(
          "{}: {} has no point '{}' with its joints. Teach it where the image is taken: sinew "
          "teach {} {} --points {}",
          path, request.points, printable(name), mounted.robot.name, printable(name),
          request.points)));
    }
    const auto q = joints_of(*point, request, mounted.robot);
    if (!q) return std::unexpected(q.error());
    const auto flange = flange_at(mounted.robot.model, *q);
    if (!flange) return std::unexpected(flange.error());
    auto seen = corners_of(mounted, path, finder);
    if (!seen) return std::unexpected(seen.error());
    mounted.views.push_back({flange->X_BF, std::move(*seen), flange->jacobian});
    mounted.joints.push_back(*q);
  }
  return {};
}

/// Touched marks of a target that does not move.
std::expected<void, Outcome> read_marks(Mounted& mounted, const TaughtPoints& points) {
  constexpr double kTouch = 0.5e-3;  // m, of a steady hand
  const CameraRequest& request = mounted.request;
  const bool platform = std::holds_alternative<HexapodGeometry>(mounted.robot.model.geometry);
  if (!mounted.on_arm() || platform) {
    if (request.touches.empty() && request.marks.empty()) return {};
    return std::unexpected(bad_input(
        "--touch and --mark: marks are touched on a target that is fixed (--mount arm), by a robot "
        "with a tip"));
  }
  const auto marks = touched_marks(request, mounted.robot, mounted.target, points);
  if (!marks) return std::unexpected(marks.error());
  const auto tool = touch_tool(request, mounted.robot);
  if (!tool) return std::unexpected(tool.error());
  const double sigma =
      std::max(kTouch, calibration::least_touch_sigma(mounted.robot.model, *marks, *tool));
  for (const TouchedMark& mark : *marks) {
    mounted.settings.known_points.push_back({mark.p_S, mark.p_BT, sigma});
  }
  return {};
}

std::expected<Mounted, Outcome> read_mounted(const CameraRequest& request) {
  auto mounted = read_settings(request);
  if (!mounted) return mounted;
  const auto points = taught_points(request);
  if (!points) return std::unexpected(points.error());
  if (auto views = read_views(*mounted, *points); !views) return std::unexpected(views.error());
  if (auto marks = read_marks(*mounted, *points); !marks) return std::unexpected(marks.error());
  return mounted;
}

/// m, 95 %: of the table that a fixed camera's file is about, or of a fixed target's corners.
double table_error(const Mounted& mounted, const HandEye& found) {
  if (!mounted.on_arm()) return camera_error_95(found, mounted.camera.X_WC.inverse().p);
  double worst = 0;
  for (const double x : {-0.5, 0.5}) {
    for (const double y : {-0.5, 0.5}) {
      const Vec3 p_B{x * mounted.target.width, y * mounted.target.height, 0};
      worst = std::max(worst, board_error_95(found, p_B));
    }
  }
  return worst;
}

HandEyeFile file_of(const Mounted& mounted, const HandEye& found) {
  HandEyeFile file{.on_arm = mounted.on_arm(),
                   .robot = mounted.robot.model.id,
                   .lens = mounted.camera.name,
                   .target = mounted.request.target,
                   .X_MC = found.X_MC,
                   .X_NB = found.X_NB,
                   .joint_zeros = {},
                   .views = static_cast<int>(mounted.views.size()),
                   .reprojection = found.rms,
                   .held_back = found.error_95,
                   .table = table_error(mounted, found)};
  for (std::size_t j = 0; j < found.joint_offsets.size(); ++j) {
    file.joint_zeros.emplace_back(mounted.robot.model.joints[j].name, found.joint_offsets[j]);
  }
  return file;
}

void add_views(const Mounted& mounted, const HandEye& found, Outcome& outcome) {
  constexpr double kOff = 3;       // times the median
  constexpr double kOffLeast = 3;  // px
  const double median = calibration::quantile(found.view_rms, 0.5);
  Json views = Json::array();
  for (std::size_t v = 0; v < found.view_rms.size(); ++v) {
    const std::string& image = mounted.request.images[v];
    views.push_back({{"image", image}, {"reprojection_px", found.view_rms[v]}});
    if (found.view_rms[v] < std::max(kOffLeast, kOff * median)) continue;
    outcome.text += fmt::format(
        "  warning: {} is off by {:.1f} px rms (median {:.1f} px). Take it and its point again: "
        "the arm at rest, then sinew teach\n",
        image, found.view_rms[v], median);
  }
  outcome.json["views"] = std::move(views);
}

void add_zeros(const Mounted& mounted, const HandEye& found, Outcome& outcome) {
  if (found.joint_offsets.empty()) return;
  Json zeros = Json::object();
  std::string text;
  for (std::size_t j = 0; j < found.joint_offsets.size(); ++j) {
    const std::string& name = mounted.robot.model.joints[j].name;
    zeros[name] = to_deg(found.joint_offsets[j]);
    text += fmt::format("{}{} {:+.2f}", j == 0 ? "" : ", ", name, to_deg(found.joint_offsets[j]));
  }
  outcome.text += "  joint zeros, deg to add: " + text + "\n";
  outcome.json["joint_zeros_deg"] = std::move(zeros);
}

/// Lines for the cell's file, where one of the poses is that of the sheet on the table.
void add_table(const Mounted& mounted, const HandEye& found, Outcome& outcome) {
  if (mounted.on_arm() && mounted.request.target != "sheet") return;
  Pose<frame::Base, frame::Table> X_BS = relabel<frame::Base, frame::Table>(found.X_NB);
  if (!mounted.on_arm()) {
    // The camera's own file says where it is over its sheet.
    const auto X_SC = relabel<frame::Table, frame::Camera>(mounted.camera.X_WC);
    X_BS = relabel<frame::Base, frame::Camera>(found.X_MC) * X_SC.inverse();
  }
  const auto X_WS = mounted.robot.X_WB * X_BS;
  outcome.text +=
      camera_table_title(mounted.robot, mounted.request.cell) + camera_table_text(X_WS.p, X_WS.R);
  outcome.json["sheet_in_cell"] = pose_json(X_WS.p, X_WS.R);
  outcome.json["camera_table"] = camera_table_json(X_WS.p, X_WS.R);
}

/// A pose to add, and what these poses leave open.
void add_advice(const Mounted& mounted, const HandEye& found, Outcome& outcome) {
  const auto& seen = found.observability;
  outcome.json["not_determined"] = Json::array();
  for (const auto& weak : seen.weak) {
    outcome.text += "  not determined: " + weak.what + "\n";
    outcome.json["not_determined"].push_back(weak.what);
  }
  constexpr std::size_t kEnough = 15;  // views
  if (seen.complete() && mounted.views.size() >= kEnough) return;
  const auto next =
      next_view(mounted.robot.model, mounted.camera.model, found, mounted.joints, mounted.target);
  if (!seen.complete() && (!next || !next->suffices)) {
    outcome.text += mounted.on_arm()
                        ? "  To fix: no pose of this robot that shows the target tells it. Touch "
                          "three marks of the target with the tool, not on one line, and teach "
                          "them: cross1 to cross5 of the sheet, or the middles of tags (tag7)\n"
                        : "  To fix: no pose of this robot that shows the target tells it. Mount "
                          "the target at another angle, or measure the sheet with sinew camera "
                          "touch\n";
    return;
  }
  if (!next) return;
  const std::string name = fmt::format("view{}", mounted.views.size() + 1);
  outcome.text += fmt::format(
      "  {}: add a view at {} deg ({}): sinew teach {} {} --points {}, image {}.jpg\n",
      seen.complete() ? "better" : "To fix", joints_argument(mounted.robot.model, next->q),
      joined(joint_names(mounted.robot.model), ", "), mounted.robot.name, name,
      mounted.request.points, name);
  outcome.json["next"]["joints_deg"] = joints_json(next->q, mounted.robot.model);
}

Outcome report(const Mounted& mounted, const HandEye& found) {
  std::size_t points = 0;
  for (const HandEyeView& view : mounted.views) points += view.seen.pixels.size();
  Outcome outcome;
  outcome.text = fmt::format("  {}: {} views, {} points, {} left out, {} marks touched\n",
                             mounted.robot.name, mounted.views.size(), points,
                             found.wrong_points.size(), mounted.settings.known_points.size());
  outcome.text += fmt::format("  reprojection {:.2f} px rms\n", found.rms);
  outcome.text += fmt::format("  error at the target: {:.2f} mm (95 %, of views held back)\n",
                              to_mm(found.error_95));
  outcome.text += fmt::format("  error of the {} in {}: {:.2f} mm (95 %)\n", mounted.table_name(),
                              mounted.base(), to_mm(table_error(mounted, found)));
  if (mounted.single_tag()) {
    outcome.text += fmt::format("  side of the tag as it appears: {:.2f} mm (given {:.2f} mm)\n",
                                to_mm(found.size * mounted.target.tag), to_mm(mounted.target.tag));
  }
  outcome.text +=
      "  camera in " + mounted.camera_mount() + ":\n" + placed_text(found.X_MC.p, found.X_MC.R);
  outcome.text += "  " + mounted.target_name() + " in " + mounted.target_mount() + ":\n" +
                  placed_text(found.X_NB.p, found.X_NB.R);
  outcome.json = {{"robot", mounted.robot.name},
                  {"mount", *mounted.request.mount},
                  {"target", mounted.request.target},
                  {"points", points},
                  {"left_out", found.wrong_points.size()},
                  {"touched", mounted.settings.known_points.size()},
                  {"reprojection_px", found.rms},
                  {"held_back_mm", to_mm(found.error_95)},
                  {"table_mm", to_mm(table_error(mounted, found))},
                  {"target_size", found.size},
                  {"camera", pose_json(found.X_MC.p, found.X_MC.R)},
                  {"target_pose", pose_json(found.X_NB.p, found.X_NB.R)}};
  add_zeros(mounted, found, outcome);
  add_views(mounted, found, outcome);
  if (found.observability.complete()) add_table(mounted, found, outcome);
  add_advice(mounted, found, outcome);
  return outcome;
}

}  // namespace

Outcome camera_hand_eye(const CameraRequest& request) {
  const auto mounted = read_mounted(request);
  if (!mounted) return mounted.error();
  const auto found =
      calibration::hand_eye(mounted->camera.model, mounted->views, mounted->settings);
  if (!found) {
    const int index = found.error().index;
    return could_not((index < 0 ? "" : request.images[static_cast<std::size_t>(index)] + ": ") +
                     sentence(found.error()));
  }
  Outcome outcome = report(*mounted, *found);
  // A pose that is wrong along one direction looks like any other once it is in a file.
  if (!found->observability.complete()) {
    outcome.exit = ExitCode::kCouldNot;
    outcome.complaint = fmt::format(
        "{} is not written: these poses do not determine {}. Add the view that is named, or touch "
        "marks",
        *request.out, found->observability.weak[0].what);
    outcome.json["error"] = {{"sentence", outcome.complaint}};
    return outcome;
  }
  const auto written = io::replace_file(*request.out, hand_eye_text(file_of(*mounted, *found)));
  if (!written) return could_not("--out: " + written.error().sentence);
  outcome.text += "  " + *request.out + "\n";
  outcome.json["file"] = *request.out;
  return outcome;
}

}  // namespace sinew::cli
