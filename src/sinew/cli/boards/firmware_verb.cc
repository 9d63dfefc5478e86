#include "sinew/cli/boards/firmware_verb.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "sinew/cli/boards/flash_tools.h"
#include "sinew/cli/cells/cell_connection.h"
#include "sinew/cli/cells/device_verb.h"
#include "sinew/cli/images/board_images.h"
#include "sinew/cli/output/board_image_text.h"
#include "sinew/cli/output/table.h"
#include "sinew/core/spelling.h"
#include "sinew/io/child_process.h"
#include "sinew/io/clock.h"
#include "sinew/io/file.h"
#include "sinew/io/interrupt.h"
#include "sinew/runtime/journal/position_record.h"

namespace sinew::cli {
namespace {

namespace fs = std::filesystem;

constexpr Duration kAskLimit = std::chrono::seconds(30);
constexpr Duration kCopyLimit = std::chrono::minutes(5);

Outcome list(const FirmwareRequest& request) {
  const auto folder = images_folder(request.images);
  if (!folder) return could_not(folder.error());
  Outcome outcome;
  outcome.json["images"] = Json::array();
  Table table({"board", "for", "version", "build", "bytes", "file"});
  table.left(1).left(2).left(3).left(5);
  for (const FlashBoard& board : flash_boards()) {
    if (!io::exists(image_path(*folder, board))) continue;
    const auto file = board_image(*folder, board);
    if (!file) return could_not(file.error());
    const BoardImage& image = *file->image;
    table.add({std::string(board.image), std::string(board.what), std::string(image.version_text()),
               fmt::format("{:08x}", image.checksum), fmt::format("{}", image.size), file->path});
    Json one = image_json(image);
    one["file"] = file->path;
    outcome.json["images"].push_back(std::move(one));
  }
  if (outcome.json["images"].empty()) {
    return could_not(*folder + ": no image of a board is in it");
  }
  outcome.text = table.text();
  return outcome;
}

Outcome info(const FirmwareRequest& request) {
  if (request.what.empty()) {
    return bad_input("info: which file, or which port? sinew firmware list names files");
  }
  if (!request.robot.name.empty()) {
    DeviceRequest device;
    device.robot = request.robot;
    device.robot.port = request.what;
    device.action = "firmware";
    device.images = request.images;
    return run_device_action(device);
  }
  std::error_code error;
  if (fs::is_character_file(request.what, error) || request.what.starts_with("tcp:") ||
      request.what == "spidev" || request.what.starts_with("simwire:")) {
    return bad_input(request.what +
                     ": whose boards are there? --robot bigrobotarm --wire framed, or --robot "
                     "robot-arm-2 --wire link");
  }
  const auto file = image_file(request.what);
  if (!file) return could_not(file.error());
  if (!file->image) return could_not(file->path + ": " + std::string(kNoLabel));
  Outcome outcome;
  outcome.json = image_json(*file->image);
  outcome.text = fmt::format("  {}, {} bytes\n", image_text(*file->image), file->image->size);
  return outcome;
}

/// A robot of the running cell whose boards are such ones and may hold an arm; as a sentence's end,
/// else empty.
std::string enabled_in_cell(const FlashBoard& board) {
  auto cell = CellConnection::open(std::nullopt);
  if (!cell) return {};
  const auto status = cell->call("cell.status");
  if (!status) return {};
  for (const Json& robot : (*status)["robots"]) {
    const Json name{{"robot", robot["robot"]}};
    const auto device = cell->call("device.status", name);
    if (!device) continue;
    const auto& wire = (*device)["wire"].get_ref<const std::string&>();
    if (std::ranges::find(board.protocols, wire) == board.protocols.end()) continue;
    if (robot["state"] == "off" || robot["state"] == "fault") continue;
    return fmt::format("'{}' of the cell on {} is enabled", robot["robot"].get<std::string>(),
                       cell->path());
  }
  return {};
}

std::string last_line(std::string_view output) {
  while (!output.empty() && (output.back() == '\n' || output.back() == '\r')) {
    output.remove_suffix(1);
  }
  return printable(output.substr(output.find_last_of("\r\n") + 1));
}

/// Runs one step. @error  the tool's last words
std::expected<std::string, std::string> run(const FlashStep& step, Duration limit) {
  std::fprintf(stderr, "  %s\n", step.what.c_str());
  const auto end = io::run_program(step.command, limit);
  if (!end) return std::unexpected(end.error().sentence);
  if (end->exit == 0) return end->output;
  return std::unexpected(step.command[0] + ": " + last_line(end->output));
}

/// The file that was asked for, else the board's image.
std::expected<ImageFile, std::string> file_to_write(const FirmwareRequest& request,
                                                    const FlashBoard& board) {
  if (request.image) return image_file(*request.image);
  const auto folder = images_folder(request.images);
  if (!folder) return std::unexpected(folder.error());
  if (io::exists(image_path(*folder, board))) return board_image(*folder, board);
  return std::unexpected(
      fmt::format("{}: no image of {} is in it: make firmware builds it", *folder, board.image));
}

/// A file that the board has room for, and that is not for another board; in whole words.
std::expected<ImageFile, Outcome> image_to_write(const FirmwareRequest& request,
                                                 const FlashBoard& board) {
  auto file = file_to_write(request, board);
  if (!file) return std::unexpected(could_not(file.error()));
  ImageFile& wanted = *file;
  if (wanted.image && wanted.image->board_name() != board.image) {
    return std::unexpected(could_not(
        fmt::format("{}: this is an image of {}", wanted.path, wanted.image->board_name())));
  }
  if (wanted.bytes.empty() || wanted.bytes.size() > board.size) {
    return std::unexpected(could_not(fmt::format("{}: {} bytes; {} has room for {}", wanted.path,
                                                 wanted.bytes.size(), board.image, board.size)));
  }
  // Flash is written in words.
  wanted.bytes.resize((wanted.bytes.size() + 3) / 4 * 4, '\xFF');
  return std::move(wanted);
}

std::expected<FlashWay, Outcome> way_of(const FirmwareRequest& request, const FlashBoard& board) {
  const int ways = (request.port ? 1 : 0) + (request.usb ? 1 : 0) + (request.probe ? 1 : 0);
  if (ways != 1) {
    return std::unexpected(
        bad_input(ways == 0 ? "how? --port /dev/ttyUSB0 (a serial adapter), --usb or --probe (an "
                              "ST-Link)"
                            : "--port, --usb and --probe: one of them"));
  }
  if (!board.part.empty() && !request.port) {
    return std::unexpected(bad_input(
        fmt::format("a {} is written over its own USB port: --port /dev/ttyUSB0", board.what)));
  }
  if (request.usb && board.usb_flash.empty()) {
    return std::unexpected(bad_input(
        fmt::format("--usb: the boot loader of a {} has no USB; --port or --probe", board.what)));
  }
  if (request.port && !io::exists(*request.port)) {
    return std::unexpected(could_not(
        *request.port + ": no such device; ls /dev/serial/by-id shows what is plugged in"));
  }
  if (!board.part.empty()) return FlashWay::kArduino;
  return request.port ? FlashWay::kSerial : request.usb ? FlashWay::kUsb : FlashWay::kProbe;
}

/// The flash of a board as a file, which goes away with this unless it is kept.
class FlashCopy {
 public:
  explicit FlashCopy(std::string path) : path_(std::move(path)) { remove(); }
  ~FlashCopy() {
    if (!kept_) remove();
  }
  FlashCopy(const FlashCopy&) = delete;
  FlashCopy& operator=(const FlashCopy&) = delete;

  std::expected<std::string, std::string> read(const FlashTool& tool, std::uint32_t bytes) {
    remove();
    if (const auto ran = run(tool.read_to(path_, bytes), kCopyLimit); !ran) {
      return std::unexpected(ran.error());
    }
    auto text = io::read_file(path_);
    if (!text) return std::unexpected(text.error().sentence);
    if (tool.trims()) text->resize(bytes, '\xFF');
    if (text->size() != bytes) return std::unexpected(path_ + ": not all of it was read");
    return std::move(*text);
  }
  void keep() { kept_ = true; }
  const std::string& path() const { return path_; }

 private:
  void remove() const {
    std::error_code none;
    fs::remove(path_, none);
  }
  std::string path_;
  bool kept_ = false;
};

std::string copy_name(const std::string& folder, const FlashBoard& board) {
  const std::time_t now = io::wall_time_ns() / 1'000'000'000;
  return fmt::format("{}/{}-{:%Y%m%d-%H%M%S}.bin", folder, board.image, fmt::gmtime(now));
}

/// From here on the board changes.
Outcome write(const FlashTool& tool, const ImageFile& wanted, FlashCopy& copy) {
  const auto size = static_cast<std::uint32_t>(wanted.bytes.size());
  FlashCopy image(copy.path() + ".new");
  if (const auto put = io::replace_file(image.path(), wanted.bytes); !put) {
    return could_not(put.error().sentence);
  }
  const std::string again = "; the board may be half written and will not start: run this again";
  if (const auto written = run(tool.write(image.path(), size), kCopyLimit); !written) {
    return could_not(written.error() + again);
  }
  if (!tool.verifies()) {
    FlashCopy there(copy.path() + ".now");
    const auto bytes = there.read(tool, size);
    if (!bytes) return could_not(bytes.error() + again);
    if (*bytes != wanted.bytes) return could_not("what is on the board now differs" + again);
  }
  return {};
}

/// The chip is the right one.
std::expected<void, Outcome> ask_chip(const FlashTool& tool) {
  const auto asked = run(tool.ask(), kAskLimit);
  // A tool that finds no chip fails too, in its own words.
  const auto answered = tool.answered(asked ? *asked : asked.error());
  if (answered) return {};
  return std::unexpected(could_not(answered.error() + (asked ? "" : " (" + asked.error() + ")")));
}

/// Of the board that was asked for, from its first byte to its last one.
Outcome put_on_board(const FirmwareRequest& request, const FlashBoard& board, const FlashTool& tool,
                     const ImageFile& wanted, FlashCopy& copy) {
  if (const auto right = ask_chip(tool); !right) return right.error();
  Outcome outcome;
  outcome.json["board"] = board.image;
  const auto before = copy.read(tool, board.size);
  if (!before && !request.no_backup) {
    return could_not("what is on the board cannot be read, and would be lost (" + before.error() +
                     "): --no-backup writes all the same");
  }
  if (before && before->starts_with(wanted.bytes)) {
    outcome.json["written"] = false;
    outcome.text = "  this very image is on the board already; nothing was written\n";
    return outcome;
  }
  if (io::interrupts() > 0) return could_not("stopped; the board is as it was");
  const bool had = before && before->find_first_not_of('\xFF') != std::string::npos;
  if (had) {
    copy.keep();
    outcome.json["before"] = copy.path();
    const auto old = image_in(*before);
    outcome.text = fmt::format("  what was on it before{} is kept in {}\n",
                               old ? ", " + image_text(*old) + "," : "", copy.path());
  }
  std::fprintf(stderr, "  leave it plugged in; Ctrl-C does not end this\n");
  const Outcome done = write(tool, wanted, copy);
  if (done.exit != ExitCode::kDone) {
    outcome = done;
    if (had) outcome.complaint += "; what was on it is kept in " + copy.path();
    return outcome;
  }
  outcome.json["written"] = true;
  if (wanted.image) outcome.json.update(image_json(*wanted.image));
  outcome.text +=
      fmt::format("  {} is on the board\n  {}\n",
                  wanted.image ? image_text(*wanted.image) : wanted.path, tool.how_to_end());
  return outcome;
}

/// A word of a command line.
std::string in_shell(const std::string& word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./-+";
  if (word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// The command that writes it; nothing is written here.
Outcome how_by_hand(const FirmwareRequest& request, const FlashBoard& board) {
  if (request.port || request.usb || request.probe || request.image || request.no_backup) {
    return bad_input(
        fmt::format("--port, --usb, --probe, --image and --no-backup: sinew cannot write {}; "
                    "without them it shows the command",
                    board.image));
  }
  const auto wanted = image_to_write(request, board);
  if (!wanted) return wanted.error();
  const std::string command = fmt::format("{} {}", board.by_hand, in_shell(wanted->path));
  Outcome outcome;
  outcome.json = {{"board", board.image}, {"written", false}, {"command", command}};
  if (wanted->image) outcome.json.update(image_json(*wanted->image));
  outcome.text = fmt::format(
      "  {} is written with stm8flash, which Debian does not have "
      "(github.com/vdudouyt/stm8flash):\n\n  {}\n\n  docs/firmware/encoder_node.md has the wires\n",
      wanted->image ? image_text(*wanted->image) : wanted->path, command);
  return outcome;
}

Outcome flash(const FirmwareRequest& request) {
  const FlashBoard* const board = flash_board(request.what);
  if (board == nullptr) {
    std::string names;
    for (const FlashBoard& one : flash_boards()) {
      names += (names.empty() ? "" : ", ") + std::string(one.image);
    }
    return bad_input("flash: " + (request.what.empty() ? "which board" : request.what) +
                     "? There are " + names);
  }
  if (!board->by_hand.empty()) return how_by_hand(request, *board);
  const auto way = way_of(request, *board);
  if (!way) return way.error();
  const auto wanted = image_to_write(request, *board);
  if (!wanted) return wanted.error();
  const FlashTool tool(*board, *way, request.port.value_or(""));
  const std::string program(tool.program());
  if (!io::has_program(program)) {
    return could_not(program + " is not here: apt-get install " + program);
  }
  if (const std::string robot = enabled_in_cell(*board); !robot.empty()) {
    return could_not(robot + ": disable it in the panel first, or end its cell");
  }
  const auto folder = runtime::firmware_folder();
  if (!folder) return could_not(folder.error().sentence);
  std::error_code error;
  fs::create_directories(*folder, error);
  FlashCopy copy(copy_name(*folder, *board));
  const auto turn = io::FolderTurn::take(copy.path(), Duration::zero());
  if (!turn) return could_not("another sinew firmware is under way, or " + turn.error().sentence);
  io::catch_interrupts();
  return put_on_board(request, *board, tool, *wanted, copy);
}

}  // namespace

Outcome firmware(const FirmwareRequest& request) {
  if (request.action == "list") return list(request);
  if (request.action == "info") return info(request);
  if (request.action == "flash") return flash(request);
  return bad_input("ACTION: list, info or flash");
}

void add_firmware(CLI::App& app, ChosenVerb& call) {
  const auto own = std::make_shared<FirmwareRequest>();
  FirmwareRequest& request = *own;
  CLI::App* verb = add_verb(app, call, "firmware", "images of boards, and writing one into a board",
                            "sinew firmware flash axis-stm32f401 --usb");
  verb->add_option("ACTION", request.action,
                   "list (what there is), info FILE (what an image says of itself), info PORT "
                   "(with --robot: what its boards run) or flash BOARD")
      ->required();
  verb->add_option("WHAT", request.what, "info: a file or a port; flash: a board");
  verb->add_option("--robot", request.robot.name, "info PORT: id or .toml file");
  verb->add_option("--wire", request.robot.wire, "info PORT: which of the robot's wires");
  verb->add_option("--port", request.port,
                   "flash: serial adapter on the boot loader's pins (stm32flash), or an Arduino's "
                   "USB (avrdude)");
  verb->add_flag("--usb", request.usb, "flash: over the board's own USB (dfu-util)");
  verb->add_flag("--probe", request.probe, "flash: with an ST-Link (openocd)");
  verb->add_option(
      "--image", request.image,
      "flash: this file, such as what was kept of before; of the board where left out");
  verb->add_option("--images", request.images,
                   "folder of images; beside this program where left out");
  verb->add_flag("--no-backup", request.no_backup,
                 "flash: writes also where what is on the board cannot be read and kept");
  verb->callback([&call, own] { call.verb = [own] { return firmware(*own); }; });
}

}  // namespace sinew::cli
