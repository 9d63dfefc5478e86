#!/usr/bin/env bash
# Installs what is missing, builds, and opens the simulated cell: the panel's address is printed, and
# all five robots show what they can do until somebody moves one. Where no terminal is, the
# demonstration is played once and that is the end.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

scripts/build.sh
echo "sinew: run"
sinew=build/release/sinew
if [[ -t 0 && -t 2 ]]; then
  echo "  Ctrl-C ends it; more to try in the terminal: scripts/demo.sh"
  if [[ $(uname) == Linux && -z ${DISPLAY:-} && -z ${WAYLAND_DISPLAY:-} ]]; then
    echo "  no windows here: the panel opens in a browser elsewhere once its port is carried there, as by"
    echo "  ssh -L 8700:127.0.0.1:8700 THIS-COMPUTER; how the robots fare is told below"
  fi
  exec "$sinew" serve --demo
fi
echo "  no terminal here: the demonstration is played once, then this ends"
exec "$sinew" serve --demo-once
