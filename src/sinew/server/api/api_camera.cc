#include <algorithm>

#include "sinew/server/api/api.h"
#include "sinew/server/json/camera_json.h"
#include "sinew/vision/tag_board.h"

namespace sinew::server {
namespace {

constexpr std::uint64_t kLongestMin = 16;  // px
constexpr std::uint64_t kLongestMax = 4096;
constexpr std::uint64_t kLongestUsual = 640;
constexpr double kPinMost = 0.3;  // m

std::string paper_of(const RpcRequest& request) {
  return request.params.contains("paper") ? request.text("paper") : "a4";
}

}  // namespace

std::expected<std::size_t, RpcError> Api::camera_of(const Call& call) const {
  const auto& cameras = cell_.cell().cameras;
  const std::string wanted = call.request.text("camera");
  const auto found = std::ranges::find_if(
      cameras, [&](const CellCamera& one) { return wanted.empty() || one.name == wanted; });
  if (found == cameras.end()) {
    std::string names;
    for (const CellCamera& one : cameras) names += (names.empty() ? "" : ", ") + one.name;
    return std::unexpected(
        invalid(names.empty() ? "this cell has no camera; [[camera]] in its file names one"
                              : "no camera of this cell has that name; there are " + names));
  }
  const auto i = static_cast<std::size_t>(found - cameras.begin());
  if (cell_.camera(i) == nullptr) return std::unexpected(invalid(found->name + " was not opened"));
  return i;
}

/// The answer is the newest picture, at once, and the next one is taken meanwhile: who wants to see
/// more asks again. Who only looks on while a program runs has none taken.
Api::Answer Api::look_through(const Call& call) {
  const auto i = camera_of(call);
  if (!i) return i.error();
  const std::uint64_t longest = call.request.whole("longest_px", kLongestUsual);
  if (longest < kLongestMin || longest > kLongestMax) {
    return invalid("longest_px has to be 16 to 4096");
  }
  runtime::Camera* camera = cell_.camera(*i);
  if (!call.request.params.contains("take") || call.request.flag("take")) camera->refresh();
  const std::uint64_t known = call.request.whole("known", 0);
  const bool tags = call.request.flag("tags");
  return Errand{pictures_,
                as_task([this, i = *i, camera, known, longest, tags]() -> Keeper::Result {
                  const auto shot = camera->newest();
                  if (!shot) return Json{{"camera", camera->name()}, {"number", 0}};
                  Json json = shot_json(cell_, i, *shot, known, static_cast<int>(longest));
                  if (tags) json["tags"] = shown_tags_.of(i, *shot);
                  return json;
                })};
}

Api::Answer Api::trouble_camera(const Call& call) {
  const auto i = camera_of(call);
  if (!i) return i.error();
  const CellCamera& camera = cell_.cell().cameras[*i];
  if (camera.device != kSimulatedCamera) {
    return invalid("the camera " + camera.name +
                   " is not simulated; device = \"simulated\" of its [[camera]] in the cell's "
                   "file makes it so");
  }
  const auto trouble = trouble_named(call.request.text("trouble"), *cell_.table(), *i);
  if (!trouble) return invalid("trouble has to be none, hand, covered, unplugged or frozen");
  cell_.table()->set_trouble(*trouble);
  cell_.camera(*i)->refresh();
  return Json{{"camera", camera.name}, {"trouble", name_of(*trouble)}};
}

Api::Answer Api::print_sheet(const Call& call) {
  const std::string what = call.request.text("what");
  const std::string form = call.request.params.contains("form") ? call.request.text("form") : "svg";
  const std::string paper = paper_of(call.request);
  if (what != "board" && what != "sheet") return invalid("what has to be board or sheet");
  if (form != "svg" && form != "pdf") return invalid("form has to be svg or pdf");
  const auto board =
      what == "sheet" ? vision::table_sheet(paper) : vision::calibration_board(paper);
  if (!board) return invalid("paper has to be a4, a3 or letter");
  return Json{{"text", form == "svg" ? svg_of(*board) : pdf_of(*board)}};
}

/// In a thread of its own: it waits for pictures and solves for seconds.
Api::Answer Api::calibrate(const Method& method, const Call& call) {
  const auto camera = camera_of(call);
  if (!camera) return camera.error();
  const std::uint64_t session = call.request.whole("session", 0);
  const auto task = [&](std::function<Keeper::Result()> work) {
    return Errand{calibrating_, as_task(std::move(work))};
  };
  switch (method.id) {
    case MethodId::kCalibrationStatus:
      return task([this, i = *camera] { return calibrations_.status(i); });
    case MethodId::kCalibrationBegin:
      return task(
          [this, i = *camera, paper = paper_of(call.request), anew = call.request.flag("anew")] {
            return calibrations_.begin(i, paper, anew);
          });
    case MethodId::kCalibrationExpect:
      return task([this, i = *camera, session, step = call.request.text("step")] {
        return calibrations_.expect(i, session, step);
      });
    case MethodId::kCalibrationTake:
      return task([this, i = *camera, session] { return calibrations_.take(i, session); });
    case MethodId::kCalibrationTouch: {
      const double pin = call.request.number("pin_m", 0);
      if (!(pin >= 0 && pin <= kPinMost)) return invalid("pin_m has to be 0 to 0.3");
      return task([this, i = *camera, session, robot = *call.robot,
                   mark = call.request.text("mark"),
                   pin] { return calibrations_.touch(i, session, robot, mark, pin); });
    }
    case MethodId::kCalibrationDrop: {
      const bool mark = call.request.params.contains("mark");
      if (mark == call.request.params.contains("view")) {
        return invalid("view or mark says what to remove");
      }
      if (mark) {
        return task([this, i = *camera, session, name = call.request.text("mark")] {
          return calibrations_.lift(i, session, name);
        });
      }
      return task([this, i = *camera, session, view = call.request.whole("view", 0)] {
        return calibrations_.drop(i, session, view);
      });
    }
    case MethodId::kCalibrationSave: {
      if (const auto busy = job_under_way_anywhere()) return *busy;
      const bool stays =
          !call.request.params.contains("sheet_stays") || call.request.flag("sheet_stays");
      return task(
          [this, i = *camera, session, stays] { return calibrations_.save(i, session, stays); });
    }
    default:
      return task([this, i = *camera, session] { return calibrations_.end(i, session); });
  }
}

/// What a program is about to see must not change under it; one that stops looks no more.
std::optional<RpcError> Api::job_under_way_anywhere() const {
  for (std::size_t i = 0; i < cell_.size(); ++i) {
    const runtime::JobView job = cell_.jobs(i).view();
    if (job.over || job.phase == program::Run::Phase::kStopping) continue;
    return RpcError{RpcCode::kBusy,
                    "'" + job.title + "' runs on " + cell_.station(i).name() +
                        ": stop the program, then save the calibration",
                    {{"job", job.id}}};
  }
  return std::nullopt;
}

}  // namespace sinew::server
