#!/usr/bin/env bash
# The main job in a terminal, on one page: robots drive programs over their own bytes against
# simulated devices with their physics; then the inverse finds the same pose.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

show() {
  printf '\n$ %s\n' "$*"
  "$@"
}

sinew=build/release/sinew
show "$sinew" run robots/bigrobotarm/sequence.txt --robot bigrobotarm

show "$sinew" run robots/learm/wave.sinew --robot learm
show "$sinew" run robots/hexapod/nod.sinew --robot hexapod

# Where the last line of the sequence ends, and every way for the joints to get there.
joints=0,-1.8,-45,-67.5,0
show "$sinew" fk bigrobotarm --joints-deg "$joints"
pose=$("$sinew" fk bigrobotarm --joints-deg "$joints" | sed -n 's/.*--pose-mm-deg //p')
show "$sinew" ik bigrobotarm --pose-mm-deg "$pose"

cat <<EOF

Try next:
  $sinew robots                                   the six robots
  $sinew ik learm --point-mm 200,0,20             a pick, tool pitch chosen
  $sinew fk learm --joints-deg 0,0,90,90,0 --frames   every matrix of the chain
  $sinew sim maxarm --link /tmp/arm               a device for your own program to talk to
  $sinew run robots/robot-arm-2/first_moves.sinew --robot robot-arm-2 --time-scale 20
  $sinew doctor                                   what this computer offers to robots
  $sinew serve                                    all five at once; sinew status and sinew move talk to it
  $sinew run robots/bigrobotarm/sequence.txt --robot bigrobotarm --plot run.svg --record run.csv
EOF
