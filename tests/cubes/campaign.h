#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cubes/cube_cell.h"

/// Whole cells by chance: arms, 1 to 12 cubes anywhere in front of them, clutter, light, a wrong
/// calibration, lenses and sensors as cameras have them, a hand that comes into view, a camera that
/// was knocked.
namespace sinew::cubes {

struct CampaignCell {
  CubeCellSettings settings;
  runtime::SimulatedTable::Trouble trouble;  ///< all the time
  double drift = 0;  ///< of the white balance, red against blue, to and fro in 20 min
  bool is_knocked = false;
  bool has_hand = false;
  Vec3 hand_W;                            ///< m, in the camera's table
  double hand_begins = 0, hand_ends = 0;  ///< s of simulated time from the program's start
};
CampaignCell cell_by(std::uint64_t seed);

/// What came of the cells so far.
struct Tally {
  std::size_t cells = 0;
  std::size_t cubes = 0;
  /// By brute force on the true places, one after the other, wherever they are believed to be.
  std::size_t reachable = 0;
  std::size_t placed = 0;  ///< reachable ones in the basket
  std::size_t beyond = 0;  ///< in the basket although brute force found no grasp
  std::size_t unseen = 0;  ///< reachable, left, and the last picture shows none there
  std::size_t thrown = 0;
  std::size_t contacts = 0;
  std::size_t outside = 0;  ///< looks at a joint outside of its limits
  std::size_t refused = 0;  ///< cubes that the last picture shows and that were refused
  std::size_t refused_wrongly = 0;
  std::size_t ghosts = 0;  ///< cubes in the last picture where none lies
  std::size_t knocked = 0, knocked_refused = 0;
  std::size_t hands = 0, hands_noticed = 0;
  std::size_t paused_wrongly = 0;           ///< though nothing came into view
  std::map<std::string, std::size_t> ends;  ///< how programs ended
  std::vector<std::string> findings;        ///< with their seeds

  /// For people.
  std::string table() const;
};

void run_cell(std::uint64_t seed, Tally& tally);

}  // namespace sinew::cubes
