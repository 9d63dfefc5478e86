#pragma once

#include <array>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sinew/control/motion_source.h"
#include "sinew/model/cell.h"
#include "sinew/planning/collision/cell_claim.h"

namespace sinew::runtime {

/// A jog is looked at again in this time, s of the robot's own.
inline constexpr double kJogAhead = 0.06;

/// Where a robot is and what it does, as its own thread saw it last.
struct CellStand {
  planning::JointBox joints;  ///< each joint somewhere in its interval
  bool known = false;         ///< no joint is lost
  bool sure = false;          ///< no joint is uncertain
  bool rests = true;
  bool jogs = false;
  planning::JointArray speeds{};  ///< of a jog, rad/s or m/s
  double ahead = kJogAhead;       ///< s, in which this is said of a jog again
};

/// Why a motion was not begun: what it would have come too near to.
struct CellRefusal {
  std::string link;            ///< of the robot that asked
  std::string other;           ///< the other robot or the object
  std::string other_link;      ///< empty: an object
  double share = 0;            ///< of the way, 0..1
  double way = 0;              ///< m that its outermost body would have gone until there
  double distance = 0;         ///< m
  double margin = 0;           ///< m
  bool moving = false;         ///< the other one moves, and will leave
  bool unknown = false;        ///< nobody knows where the other one is
  bool asker_unknown = false;  ///< .. or where the one that asked is, or goes

  std::string sentence() const;
};

/// What a motion would come too near to.
struct CellMeeting {
  Error error;  ///< kCellContact
  CellRefusal refusal;
};

using Surroundings = FixedVector<planning::Surrounding, planning::CollisionModel::kSurroundMax>;

/// Who fills which space of a cell. A motion is begun only where all of it was free of everything
/// that others fill, or may while their own motions last, and from then on belongs to its robot
/// until it is at rest again. One mutex, for those who ask; a robot's control thread only says
/// where it is, behind a mutex of its own that nobody holds for long. docs/collision.md.
class CellSpace {
 public:
  /// @param models  one for each of the cell's robots; copies are kept
  CellSpace(const Cell& cell, std::span<const RobotModel> models);

  /// @name From any thread but control threads
  /// @{
  /// The motion of a robot's command, before it is handed over. True where it was free, and is this
  /// robot's from now on.
  /// @param way        null: nobody knows where it goes
  /// @param recovering  a slow first move, which somebody watches: objects do not count, as the
  ///                    robot's own table does not
  /// @error kCellContact, kCellTaken (what is in the way moves, and will be gone); index: link.
  ///        refusal() has the rest
  Expected<void> ask(std::size_t robot, std::uint32_t command, const planning::CellWay* way,
                     bool recovering = false);
  /// Whether a motion would meet an object or a robot that rests and has nothing to do; nothing is
  /// taken. @error kCellContact
  Expected<void> look(std::size_t robot, const planning::CellWay& way);
  /// The same, and nobody hears of it: refusal() stays what it is. Nothing: free.
  std::optional<CellMeeting> meets(std::size_t robot, const planning::CellWay& way);
  /// Of the last motion that was refused.
  std::optional<CellRefusal> refusal(std::size_t robot) const;
  /// A program of this robot is under way: it will not stay where it rests now.
  void works(std::size_t robot, bool busy);
  /// @}

  /// @name From any thread; never waits for those above
  /// @{
  void stands(std::size_t robot, const CellStand& stand);
  /// A command has ended, or never began.
  void ended(std::size_t robot, std::uint32_t command);
  /// What a jogging robot has to keep out of, and that it stands there and jogs. Everybody who asks
  /// from now on keeps out of what the jog can come to in CellStand::ahead and on its way to rest.
  /// @return  nothing where somebody is asking at this moment: try again
  std::optional<Surroundings> jogs(std::size_t robot, const CellStand& stand);
  /// @}

 private:
  struct Robot {
    Robot(const RobotModel& of, const CellRobot& place)
        : model(of), bodies(model, place.X_WB), name(place.name) {}
    RobotModel model;
    planning::RobotBodies bodies;
    std::string name;
    planning::CellClaim granted;  ///< empty: none
    std::optional<CellRefusal> refusal;
    bool busy = false;
    std::vector<std::uint32_t> on;  ///< links that stand on each object, as bits
    // Under said_mutex_.
    CellStand stand;
    std::uint32_t command = 0;  ///< that `granted` is of; 0: none
    bool ended = false;
    bool rested = false;  ///< since it has ended
  };
  struct Filled {
    planning::CellClaim claim;
    std::size_t robot = 0;
    bool moving = false;
    bool unknown = false;
  };

  Filled filled(std::size_t robot);
  /// Under mutex_.
  std::optional<CellMeeting> meeting(std::size_t robot, const planning::CellWay& way);
  planning::JointBox jog_box(const Robot& robot, const CellStand& stand) const;
  /// Objects only where it is known where the motion goes: who moves a lost robot has to look.
  std::vector<planning::CellObstacle> obstacles(std::size_t robot, std::span<const Filled> others,
                                                bool objects) const;
  CellRefusal refused(std::size_t robot, const planning::CellWay* way,
                      const planning::CellContact& contact, std::span<const Filled> others) const;
  bool gather(const Robot& robot, const planning::CellBlock& near, const planning::CellClaim& claim,
              double wider, std::uint32_t excused, bool coarse, Surroundings& out) const;
  static Error error_of(const planning::CellContact& contact, bool taken);

  std::vector<std::unique_ptr<Robot>> robots_;
  std::vector<std::string> object_names_;
  std::vector<planning::CellClaim> objects_;
  mutable std::mutex mutex_;       ///< who asks; everything but what is under the other one
  mutable std::mutex said_mutex_;  ///< taken last, never for longer than a copy takes
};

}  // namespace sinew::runtime
