#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "sinew/core/instant.h"
#include "sinew/core/split_mix.h"
#include "sinew/sim/hand_truth.h"

namespace sinew::frame {
struct Object;  ///< a cube: its middle, along its edges
struct Basket;  ///< the middle of its floor, on the table; z up
}  // namespace sinew::frame

namespace sinew::sim {

enum class CubePlace : std::uint8_t {
  kTable,
  kOnCube,  ///< rests on at least one other cube, outside of the basket
  kBasket,  ///< on its floor, or on cubes in it
  kHeld,
  kGone,  ///< fell off the table, or was taken away
};

struct CubeState {
  Pose<frame::World, frame::Object> X_WO;
  double edge = 0;  ///< m
  int color = 0;    ///< whatever the caller counts colors by
  CubePlace where = CubePlace::kTable;
  std::optional<std::size_t> on;  ///< a cube that it rests on
};

struct CubeEvent {
  enum class Kind : std::uint8_t {
    kGrasped,   ///< held from now on
    kReleased,  ///< no longer held
    kSlipped,   ///< squeezed out from between the jaws
    kPushed,    ///< moved aside by a hand, a held cube or another cube
    kDropped,   ///< fell; amount: m
    kTipped,    ///< its centre of mass had no support
    kThrown,    ///< released from a moving hand; amount: m/s
    kCrash,     ///< a hand or a held cube was driven into it; without a cube: into table or basket
    kFell,      ///< off the table
  };
  Instant time;
  Kind kind = Kind::kPushed;
  std::optional<std::size_t> cube;
  double amount = 0;  ///< m, of a push, drop or crash
};
std::string_view name(CubeEvent::Kind kind);

/// A box without a lid on the table.
struct Basket {
  Pose<frame::World, frame::Basket> X_WK;  ///< upright: turned about z only
  PlanPoint half{0.06, 0.06};              ///< m, inside
  double height = 0.05;                    ///< m, of its walls, from the table
  double wall = 0.003;                     ///< m, thickness of walls and floor
};

/// Floor, then the four walls.
std::array<Block, 5> blocks_of(const Basket& basket);

struct CubeWorldSettings {
  std::uint64_t seed = 1;
  double density = 600;  ///< kg/m^3; wood
  PlanPoint table_middle = {};
  PlanPoint table_half{1, 1};  ///< m; cubes beyond it fall off
  std::vector<Basket> baskets = {};
};

/// Cubes on a table (z = 0 of W), as hands move them.
///
/// Quasi-static: things move as far as they are pushed, and fall when nothing holds them up. There
/// is friction enough that nothing slides by itself, none between cubes that stand on each other:
/// a cube whose support is drawn away stays where it is until its middle is no longer supported.
/// Free cubes are always flat. A hand is never stopped; blocked_width() says where jaws have to be.
/// The same seed and the same calls give the same world; how finely a motion is cut into calls
/// changes it by less than a micrometre until chance comes in.
///
/// Not modelled: cubes that are squeezed between obstacles may overlap; palms and arms touch
/// nothing. Not for several threads at once.
class CubeWorld {
 public:
  explicit CubeWorld(const CubeWorldSettings& settings);

  struct NewCube {
    double edge = 0.025;  ///< m, > 0
    int color = 0;
    PlanPoint at = {};
    double yaw = 0;     ///< rad
    double bottom = 0;  ///< m, z of W, from where it is set down
  };
  /// Its index. Makes no events, and does not look whether the place is free.
  std::size_t add(const NewCube& cube);
  /// It lies there now, wherever it was; as add().
  void put(std::size_t cube, PlanPoint at, double yaw, double bottom);
  /// A cube at a random free place on the table. Nothing where 200 tries find none.
  /// @param middle  @param half  of the area for its middle, m  @param gap  m to other cubes
  std::optional<std::size_t> add_somewhere(double edge, int color, PlanPoint middle, PlanPoint half,
                                           double gap);
  /// Takes it off the table.
  void take_away(std::size_t cube);
  /// A person puts a basket elsewhere: what lies in it goes along, cubes where it is put down fall
  /// into it. @param X_WK  upright
  void move_basket(std::size_t basket, const Pose<frame::World, frame::Basket>& X_WK);

  /// A hand has moved evenly from where it was to this pose, and time has passed.
  /// @param which  number of the hand, below kHandsMax; each has one kind of grip
  /// @pre time of one hand never runs back
  void advance(Instant now, const HandTruth& hand, std::size_t which = 0);

  /// The hand is somewhere else without having moved there; what it held is released.
  void lift_hand(std::size_t which);

  std::span<const CubeState> cubes() const { return cubes_; }
  std::span<const CubeEvent> events() const { return events_; }
  void clear_events() { events_.clear(); }
  const CubeWorldSettings& settings() const { return settings_; }

  /// m: the width at which what is between a hand's jaws stops them; nothing where nothing does.
  std::optional<double> blocked_width(std::size_t which = 0) const;
  bool is_held(std::size_t cube, std::size_t which = 0) const;
  /// kg
  double mass_of(std::size_t cube) const;
  /// kg, of all that a hand holds
  double held_mass(std::size_t which = 0) const;

  static constexpr std::size_t kHandsMax = 16;

 private:
  struct Hold {
    std::size_t hand = 0;
    Pose<frame::Tip, frame::Object> X_TO;
  };
  struct Body {
    std::optional<Hold> hold;
    Instant last_push;
    double push = 0;             ///< m, since it last stood still
    std::optional<Vec3> wedged;  ///< p_WO where it came to no rest, and is left
  };
  /// How a hand and a cube stand to each other.
  enum class Contact : std::uint8_t {
    kNone,
    kBetween,  ///< between the jaws
    kAbove,    ///< the hand stands on it: told as a crash already
  };
  struct Hand {
    std::optional<HandTruth> truth;
    Instant time;
    PlanPoint velocity;             ///< m/s
    std::vector<Contact> contacts;  ///< of the hand with each cube
    std::vector<Contact> of_held;   ///< of what it holds with each cube
    bool presses = false;           ///< it, or what it holds, is in the table or the basket
  };
  /// A cube between jaws, as the jaws see it.
  struct Fit {
    Vec3 p_TO;              ///< m
    PlanPoint across;       ///< direction of the jaws' y in the plane
    double turn = 0;        ///< rad from the jaws to the nearest faces of the cube, +-pi/4
    double extent = 0;      ///< m, of the cube across the jaws
    double face = 0;        ///< m, of the fingers' width that meets the cube
    double deep = 0;        ///< m, of the fingers' length that meets the cube
    double before = 0;      ///< m, taken by other cubes between it and the finger at -y
    double behind = 0;      ///< m, at +y
    bool is_level = false;  ///< the jaws close along the table
  };
  struct Support {
    enum class Kind : std::uint8_t { kFloor, kRim, kCube } kind = Kind::kCube;
    PlanShape shape;
    double top = 0;  ///< m
    std::optional<std::size_t> cube;
  };

  // cube_world.cc
  void step(Hand& hand, std::size_t which);
  void note(CubeEvent::Kind kind, std::optional<std::size_t> cube, double amount = 0);
  bool is_free(std::size_t cube) const;
  Block block_of(std::size_t cube) const;
  PlanShape square_of(std::size_t cube) const;
  PlanPoint middle(std::size_t cube) const { return seen_from_above(cubes_[cube].X_WO.p); }
  double bottom(std::size_t cube) const;
  double yaw(std::size_t cube) const;
  void place(std::size_t cube, PlanPoint at, double yaw, double bottom);

  // cube_push.cc
  void push(std::size_t cube, PlanPoint step, int depth = 0);
  void displace(std::size_t cube, PlanPoint step, int depth = 0);
  void move(std::size_t cube, PlanPoint step);
  void keep_out_of_walls(std::size_t cube);
  bool part_cubes();
  enum class Touch : std::uint8_t { kNone, kRests, kPushes };
  /// What a block that a hand moves does to a cube.
  Touch drive(const Block& block, std::size_t cube, Contact& contact, double soft);
  double depth_in_fixtures(const Block& block) const;
  void press(Hand& hand, std::size_t which, double soft);

  // cube_grip.cc
  void touch(Hand& hand, std::size_t which, std::size_t cube);
  void carry(Hand& hand, std::size_t cube);
  void squeeze(Hand& hand, std::size_t which, std::size_t cube, const Fit& fit);
  void slip_out(Hand& hand, std::size_t cube, const Fit& fit);
  void suck(Hand& hand, std::size_t which, std::size_t cube);
  void hold(const Hand& hand, std::size_t which, std::size_t cube);
  void release(const Hand& hand, std::size_t cube);
  Fit fit_of(const Hand& hand, std::size_t cube) const;
  void count_neighbours(const Hand& hand, std::size_t cube, Fit& fit) const;

  // cube_fall.cc
  void calm();
  bool settle();
  bool settle(std::size_t cube);
  void fall(std::size_t cube);
  void bounce(std::size_t cube, double height);
  void slide_off(std::size_t cube, std::span<const Support> supports);
  std::vector<Support> supports_of(std::size_t cube) const;
  bool rests(std::size_t cube, std::span<const Support> supports) const;
  void set_place(std::size_t cube, std::span<const Support> supports);
  void build_fixtures();
  /// Which one.
  std::optional<std::size_t> basket_below(PlanPoint p) const;
  bool is_crowded(std::size_t cube) const;

  CubeWorldSettings settings_;
  SplitMix64 random_;
  std::vector<CubeState> cubes_;
  std::vector<Body> bodies_;
  std::vector<Hand> hands_;
  std::vector<CubeEvent> events_;
  std::vector<Block> fixtures_;  ///< of each basket floor and four walls
  std::vector<PlanShape> fixture_shapes_;
  Instant now_;
  bool moved_ = false;  ///< something may have lost its support
};

}  // namespace sinew::sim
