#pragma once

#include <vector>

#include "sinew/planning/paths/move_path_test_robot.h"

namespace sinew::planning {

/// Some number that nobody means: none, infinite, zero, negative, huge or next to nothing.
double hostile_number(test::Random& random);

/// Moves as somebody may ask for them.
struct DealtMoves {
  std::vector<Move> moves;
  /// The first that is no move at all, whatever the robot: it must not be planned. As many as there
  /// are moves where all may be.
  std::size_t nonsense = 0;
};

/// Deals moves of one robot, from millimetres to the whole of its range.
class MoveDealer {
 public:
  /// @param robot  outlives this.
  explicit MoveDealer(const PathRobot& robot) : robot_(robot) {}

  /// Most of them can be made.
  std::vector<Move> deal(test::Random& random, const RobotPlace& from) const;
  /// Some out of reach, some through the base or the table, some of numbers that nobody means.
  DealtMoves deal_any(test::Random& random, const RobotPlace& from) const;

 private:
  RobotPlace neighbour(test::Random& random, const RobotPlace& from, double scale) const;
  Move deal_move(test::Random& random, const RobotPlace& from, double scale, RobotPlace& to) const;
  void take_away(test::Random& random, Move& move) const;
  bool spoil(test::Random& random, Move& move) const;

  const PathRobot& robot_;
};

}  // namespace sinew::planning
