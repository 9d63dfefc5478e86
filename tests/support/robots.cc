#include "support/robots.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <iterator>
#include <map>
#include <string>

#include "sinew/config/builtin_robots.h"
#include "sinew/config/robot_file.h"

namespace sinew::test {
namespace {

using Robots = std::map<std::string, RobotModel, std::less<>>;

void load(std::string_view text, std::string_view file_name, Robots& robots) {
  auto model = read_robot(text, file_name);
  if (!model) {
    for (const Complaint& complaint : model.error()) std::cerr << to_text(complaint) << "\n";
    std::exit(EXIT_FAILURE);
  }
  robots.emplace(model->id, std::move(*model));
}

Robots load_all() {
  Robots robots;
  for (const BuiltinRobot& builtin : builtin_robots())
    load(builtin.text, builtin.file_name, robots);
  for (const auto& file : std::filesystem::directory_iterator(SINEW_ROBOTS_DIR "/examples")) {
    std::ifstream in(file.path());
    load(std::string(std::istreambuf_iterator(in), {}), file.path().filename().string(), robots);
  }
  return robots;
}

}  // namespace

const RobotModel& robot(std::string_view id) {
  static const auto robots = load_all();
  const auto found = robots.find(id);
  if (found == robots.end()) {
    std::cerr << "there is no robot `" << id << "`, neither built in nor an example\n";
    std::exit(EXIT_FAILURE);
  }
  return found->second;
}

}  // namespace sinew::test
