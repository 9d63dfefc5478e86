#include "support/robots.h"

#include <cstdlib>
#include <iostream>
#include <map>
#include <string>

#include "sinew/config/builtin_robots.h"
#include "sinew/config/robot_file.h"

namespace sinew::test {
namespace {

std::map<std::string, RobotModel, std::less<>> load_all() {
  std::map<std::string, RobotModel, std::less<>> robots;
  for (const BuiltinRobot& builtin : builtin_robots()) {
    auto model = read_robot(builtin.text, builtin.file_name);
    if (!model) {
      for (const Complaint& complaint : model.error()) std::cerr << to_text(complaint) << "\n";
      std::exit(EXIT_FAILURE);
    }
    robots.emplace(builtin.id, std::move(*model));
  }
  return robots;
}

}  // namespace

const RobotModel& robot(std::string_view id) {
  static const auto robots = load_all();
  const auto found = robots.find(id);
  if (found == robots.end()) {
    std::cerr << "there is no built-in robot `" << id << "`\n";
    std::exit(EXIT_FAILURE);
  }
  return found->second;
}

}  // namespace sinew::test
