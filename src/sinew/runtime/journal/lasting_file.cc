#include "sinew/runtime/journal/lasting_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>
#include <utility>

#include "sinew/core/spelling.h"
#include "sinew/wire/crc32c.h"

namespace sinew::runtime {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kSlot = 64 * 1024;  // bytes; an LSC board full of groups takes 46 KiB
constexpr std::size_t kChecksum = 9;      // characters: eight hexadecimal digits and a space
constexpr int kVersion = 1;

std::uint32_t checksum(std::string_view text) {
  return crc32c({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

std::optional<std::vector<std::uint8_t>> bytes_of(const std::string& text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
    const auto high = kDigits.find(text[i]);
    const auto low = kDigits.find(text[i + 1]);
    if (high == kDigits.npos || low == kDigits.npos) return std::nullopt;
    bytes.push_back(static_cast<std::uint8_t>(high << 4U | low));
  }
  return text.size() % 2 == 0 ? std::optional(bytes) : std::nullopt;
}

/// One line as it stands in a slot.
struct Line {
  std::string robot;
  std::uint64_t seed = 0;
  std::uint64_t number = 0;
  sim::LastingState state;
};

std::string text_of(const Line& line) {
  Json json{{"sinew_sim_state", kVersion},
            {"robot", line.robot},
            {"seed", line.seed},
            {"number", line.number}};
  json["bodies_rad_rad_s"] = Json::array();
  for (const auto& body : line.state.bodies) {
    json["bodies_rad_rad_s"].push_back({body.angle, body.speed});
  }
  json["memory"] = hex(line.state.memory);
  const std::string text = json.dump();
  return fmt::format("{:08x} {}\n", checksum(text), text);
}

std::optional<Line> line_of(std::string_view slot) {
  const auto end = slot.find('\n');
  if (end == slot.npos || end <= kChecksum) return std::nullopt;
  const std::string_view text = slot.substr(kChecksum, end - kChecksum);
  if (slot.substr(0, kChecksum) != fmt::format("{:08x} ", checksum(text))) return std::nullopt;
  const Json json = Json::parse(text, nullptr, false);
  // The checksum says that this program wrote it; another version may have had other keys.
  if (!json.is_object() || json.value("sinew_sim_state", 0) != kVersion) return std::nullopt;
  Line line{json["robot"], json["seed"], json["number"], {}};
  for (const Json& body : json["bodies_rad_rad_s"]) {
    if (line.state.bodies.full()) return std::nullopt;
    line.state.bodies.push_back({body[0], body[1]});
  }
  auto memory = bytes_of(json["memory"].get<std::string>());
  if (!memory) return std::nullopt;
  line.state.memory = std::move(*memory);
  return line;
}

bool is_blank(const std::string& slot) {
  return std::ranges::all_of(slot, [](char one) { return one == '\0'; });
}

}  // namespace

std::expected<LastingFile, std::string> LastingFile::open(const std::string& path,
                                                          const std::string& robot,
                                                          std::optional<std::uint64_t> seed) {
  auto file = io::LockedFile::open(path, 2 * kSlot);
  if (!file) return std::unexpected(file.error().sentence);
  LastingFile result(std::move(*file), robot);
  std::optional<Line> newest;
  bool blank = true;
  for (const std::size_t offset : {std::size_t{0}, kSlot}) {
    std::string slot(kSlot, '\0');
    if (const auto read = result.file_.read(offset, slot); !read) {
      return std::unexpected(read.error().sentence);
    }
    blank = blank && is_blank(slot);
    auto line = line_of(slot);
    if (line && (!newest || line->number > newest->number)) newest = std::move(line);
  }
  result.seed_ = seed.value_or(1);
  if (!newest) {
    if (blank) return result;
    return std::unexpected(path + ": damaged, or not a state of `sinew sim`; remove it to begin " +
                           "with a new machine");
  }
  if (newest->robot != robot) {
    return std::unexpected(fmt::format("{}: the state of {}, not of {}; choose another file", path,
                                       printable(newest->robot), robot));
  }
  if (seed && *seed != newest->seed) {
    return std::unexpected(fmt::format("{}: the state of a machine with --seed {}, not {}", path,
                                       newest->seed, *seed));
  }
  result.seed_ = newest->seed;
  result.number_ = newest->number;
  result.before_ = std::move(newest->state);
  return result;
}

io::IoResult<void> LastingFile::keep(const sim::Machine& machine) {
  sim::LastingState state = machine.lasting_state();
  if (kept_ == state) return {};
  const std::string text = text_of({robot_, seed_, number_ + 1, state});
  if (const auto written = file_.write((number_ + 1) % 2 * kSlot, text); !written) return written;
  ++number_;
  kept_ = std::move(state);
  return {};
}

io::IoResult<void> LastingFile::finish(const sim::Machine& machine) {
  if (const auto kept = keep(machine); !kept) return kept;
  return file_.sync();
}

}  // namespace sinew::runtime
