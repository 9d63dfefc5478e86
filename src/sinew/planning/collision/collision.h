#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "sinew/kinematics/hexapod.h"
#include "sinew/kinematics/palletizer.h"
#include "sinew/kinematics/serial_chain.h"
#include "sinew/model/robot_model.h"
#include "sinew/model/tool_state.h"
#include "sinew/planning/collision/collision_reach.h"
#include "sinew/planning/collision/shape_distance.h"
#include "sinew/planning/paths/joint_path.h"

namespace sinew::planning {

/// Stands for the table where a shape is named.
inline constexpr std::uint8_t kTableShape = 255;

/// The two bodies that are nearest to each other.
struct Clearance {
  /// m; 0 they touch, negative they overlap (by how far one has to be shifted). Infinite where
  /// nothing is to be checked; minus infinity where a hexapod's legs have no pose.
  double distance = std::numeric_limits<double>::infinity();
  std::uint8_t first = 0;   ///< place in RobotModel::collision.shapes
  std::uint8_t second = 0;  ///< likewise, or kTableShape
  /// Of one pose of joints that are left out: two bodies overlap wherever in it those joints are,
  /// and by more than the margin. So they are elsewhere.
  bool surely = false;
};

/// A place of a path where two bodies come too near.
struct PathContact {
  double s = 0;
  Clearance nearest;
};

/// The link that a shape of Clearance stands on, as in model/collision_links.h; kObstacleLink of
/// what surrounds the robot.
std::uint8_t link_of(const RobotModel& model, std::uint8_t shape);
/// kCollision with the links that these shapes stand on.
Error contact_error(const RobotModel& model, const Clearance& nearest);

/// A shape where it is at one place of the joints, in base B.
using PlacedShape = std::variant<PlacedCapsule, PlacedBox>;

/// Something beside the robot that does not move, in base B.
struct Surrounding {
  CollisionShape shape;       ///< on the stand
  std::uint32_t excused = 0;  ///< links that are not held against it, a bit each
};

/// Whether a robot hits itself or its table: every two shapes whose links are not joined and that
/// its file does not excuse, and every moving shape against the table. docs/collision.md.
///
/// Joints that are left out (model/left_out.h) may be anywhere: their ranges are looked at in
/// poses(), and every distance is less by what a body can be away from where it is in its pose. A
/// pose in which the robot overlaps for sure where a motion begins does not count for that motion.
///
/// @param q       one per joint: rad, or a leg's length in m.
/// @param margin  m, how near things may come; its file's margin() or another one.
/// @param X_near  a hexapod's last known pose, its home where absent; others do not look at it.
/// @rt            all functions but the constructor: no allocation, no lock.
class CollisionModel {
 public:
  /// @param model  outlives this.
  explicit CollisionModel(const RobotModel& model);

  /// What a gripper is like from now on, and at first with nothing known of it: then its fingers
  /// fill all that they can reach.
  void fit(const ToolState& tool);
  /// What comes too near at q while the jaws go from one width to another one (m); nothing where
  /// all keep the margin, or come no nearer than they were. Fitted to `from` behind it.
  /// @return  kJawsContact where they close, else kCollision (index, other: links)
  std::optional<Error> jaws_contact(std::span<const double> q, const ToolState& from, double to);

  std::size_t pairs() const { return pairs_.size(); }
  double margin() const { return model_->collision.margin; }

  /// @param but  pairs of links that are not held against each other; only where nothing surrounds
  ///             the robot
  Clearance distance(std::span<const double> q, const kinematics::PoseBP* X_near = nullptr,
                     std::span<const LinkPair> but = {}) const;
  /// Poses of the joints that are left out; one where none is.
  std::size_t poses() const { return poses_.size(); }
  static constexpr std::size_t kPosesMax = 81;
  /// The same in one of them. distance() is the nearest of those that are possible.
  Clearance distance_in(std::size_t pose, std::span<const double> q,
                        const kinematics::PoseBP* X_near = nullptr,
                        std::span<const LinkPair> but = {}) const;
  /// The same where a hexapod's pose is known already.
  Clearance distance(const kinematics::PoseBP& X_BP) const;

  std::size_t shapes() const { return own_shapes_; }
  /// Where all shapes are, in the order of RobotModel::collision.shapes.
  /// @param X_near  a hexapod's last pose in, its pose out
  /// @return        false where its legs have no pose
  bool bodies(std::span<const double> q, kinematics::PoseBP& X_near,
              std::span<PlacedShape> out) const;
  /// How far any point of a shape moves in base B at most, a number a joint; of a hexapod one for
  /// the Euclidean norm of its legs.
  JointReach reach_of(std::size_t shape) const { return own_reach(*model_, shapes_[shape]); }
  /// What is beside the robot from now on, at most kSurroundMax: everything that moves is held
  /// against it, as against the robot's own bodies. Those that name a Clearance's shape then count
  /// on behind the robot's own.
  void surround(std::span<const Surrounding> bodies);
  static constexpr std::size_t kSurroundMax = 64;
  bool surrounded() const { return shapes_.size() > own_shapes_; }
  /// What a shape never leaves.
  Capsule ball_of(std::size_t shape) const { return reach_ball(*model_, shapes_[shape]); }
  /// A hexapod's pose to begin with.
  kinematics::PoseBP start_pose() const { return start(nullptr); }
  const RobotModel& model() const { return *model_; }

  /// Whether every distance is at least `margin`.
  bool clear(std::span<const double> q, double margin) const {
    return distance(q).distance >= margin;
  }

  /// The first place between `begin` and `end` (clamped to the path) where two bodies are nearer
  /// than `margin`; nothing where there is none. None is missed, however thin: from the distances
  /// at one place follows how far the joints may turn before any pair can have met. What comes
  /// within kResolution of the margin may count as too near.
  ///
  /// A hexapod's path must keep its condition_max, as planned ones do: where it is found broken, or
  /// the legs have no pose, a contact with a distance of minus infinity is told.
  std::optional<PathContact> check_path(const JointPath& path, double margin, double begin = 0,
                                        double end = std::numeric_limits<double>::infinity(),
                                        const kinematics::PoseBP* X_near = nullptr) const;

  /// The same from a start that overlaps: what is nearer than margin() there may only come apart
  /// until it is that far, but for twice kResolution, and all else keeps margin().
  std::optional<PathContact> check_leaving(const JointPath& path,
                                           const kinematics::PoseBP* X_near = nullptr) const;

  /// For how long the joints can go on at qd (rad/s, m/s; straight in joint space) until two
  /// bodies are as near as `margin`, s; at most `horizon`. Bodies that are nearer already count
  /// only while they come nearer still: moving apart is always allowed.
  double free_time(std::span<const double> q, std::span<const double> qd, double horizon,
                   double margin, const kinematics::PoseBP* X_near = nullptr) const;

  /// The share of qd, 0 to 1, at which a jog can still stop before the margin with the joints' own
  /// acceleration and jerk limits: 1 far away and whenever bodies move apart, falling to 0 without
  /// a jump on the way there.
  ///
  /// Holds for a jog whose speed and acceleration together never promise more than the share
  /// (v + a^2 / 2j <= share * qd), asked for in every cycle.
  double speed_share(std::span<const double> q, std::span<const double> qd, double margin,
                     const kinematics::PoseBP* X_near = nullptr) const;

  /// m; how near to the margin counts as at the margin where a motion is followed.
  static constexpr double kResolution = 1e-4;

 private:
  struct Pair {
    std::uint8_t first = 0;
    std::uint8_t second = 0;
    JointReach reach{};
    double blur = 0;  ///< m, what its pose leaves open
  };
  /// A shape at one q: a capsule's ends, and the ball around it.
  struct Placed {
    Vec3 a;
    Vec3 b;
    Vec3 centre;
    double ball = 0;
  };
  struct Scene {
    std::array<kinematics::PoseBL, kMaxJoints + 2> X_BL;  ///< by link
    std::array<Placed, kCollisionShapesMax + kSurroundMax> shapes;
  };
  static constexpr std::size_t kPairsMax =
      kCollisionShapesMax * (kCollisionShapesMax + 1) / 2 + kCollisionShapesMax * kSurroundMax;
  using PerPair = std::array<double, kPairsMax>;
  /// How far (m) each pair may still come nearer. A pair is measured again only where less than a
  /// share of what it had is left: most are far away, and few decide.
  struct Budgets {
    PerPair left;
    PerPair measured;
    /// Of the first `pairs`: all are to be measured.
    explicit Budgets(std::size_t pairs);
    void renew(std::size_t pairs);
    bool is_due(std::size_t pair) const;
    void set(std::size_t pair, double budget) { left[pair] = measured[pair] = budget; }
  };
  using Excused = std::array<bool, kPairsMax>;

  JointReach pair_reach(const Pair& pair) const;
  void lay_poses();
  void set_reach(Pair& pair) const;
  JointArray posed(std::span<const double> q, std::size_t pose) const;
  /// Whether the robot can be in this pose at q.
  bool possible(std::size_t pose, std::span<const double> q,
                const kinematics::PoseBP* X_near) const;
  void fit_fingers(double least, double most);
  void fit_held(double held, double width);
  bool place(std::span<const double> q, kinematics::PoseBP& X_near, Scene& scene) const;
  void place_shapes(Scene& scene) const;
  void place_platform(const kinematics::PoseBP& X_BP, Scene& scene) const;
  PlacedCapsule capsule(const Scene& scene, std::size_t shape) const;
  PlacedBox box(const Scene& scene, std::size_t shape) const;
  double distance(const Scene& scene, const Pair& pair) const;
  /// A bound of it that costs next to nothing.
  double ball_distance(const Scene& scene, const Pair& pair) const;
  Clearance nearest(const Scene& scene, std::span<const LinkPair> but = {}) const;

  Clearance measure(const Scene& scene, double margin, const Excused* excused,
                    Budgets& budgets) const;
  Clearance measure_leaving(const Scene& scene, PerPair& least, Budgets& budgets) const;
  template <class Measure>
  std::optional<PathContact> walk(const JointPath& path, double begin, double end,
                                  const kinematics::PoseBP* X_near, Budgets& budgets,
                                  std::size_t pose, const Measure& measure) const;
  /// The first contact of all poses that are possible at `begin`.
  template <class Check>
  std::optional<PathContact> first_of_poses(const JointPath& path, double begin,
                                            const kinematics::PoseBP* X_near,
                                            const Check& check) const;
  double free_time_in(std::size_t pose, std::span<const double> q, std::span<const double> qd,
                      double horizon, double margin, const kinematics::PoseBP* X_near) const;
  double spend(const JointArray& speeds, double way, Budgets& budgets) const;
  bool bound_holds(const kinematics::PoseBP& X_BP) const;
  kinematics::PoseBP start(const kinematics::PoseBP* X_near) const;

  const RobotModel* model_;
  std::variant<kinematics::SerialChain, PalletizerGeometry, kinematics::Hexapod> robot_;
  std::vector<CollisionShape> shapes_;  ///< the tool's of a chain moved to its last link
  std::vector<double> radii_;           ///< of capsules; 0 for boxes
  std::vector<Pair> pairs_;
  std::size_t own_shapes_ = 0;
  std::size_t own_pairs_ = 0;
  FixedVector<std::uint8_t, kMaxJoints> left_out_;  ///< joints
  JointArray pose_half_{};                          ///< of a pose, rad
  std::vector<JointArray> poses_;                   ///< middles; only numbers of left_out_ count
};

}  // namespace sinew::planning
