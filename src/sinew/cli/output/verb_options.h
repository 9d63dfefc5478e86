#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "sinew/cli/output/verb.h"

/// Options that several verbs have.
namespace sinew::cli {

inline const std::string kPorts = "serial device, tcp:HOST:PORT, spidev or simwire:unix:PATH";

/// @param options  has wire, profile and without
template <class Options>
void add_variant(CLI::App& verb, Options& options) {
  verb.add_option("--wire", options.wire,
                  "which of the robot's wires; as in its file where left out");
  verb.add_option("--profile", options.profile,
                  "which variant of its device; an unknown name lists them");
  verb.add_option("--without", options.without,
                  "joints whose boards are missing, by name or as J3, comma between; the others "
                  "can be used")
      ->delimiter(',');
}

}  // namespace sinew::cli
