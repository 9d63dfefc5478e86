#!/usr/bin/env bash
# The main job on one page: the BigRobotArm drives its sample sequence, against the simulated
# device.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

demo=(build/release/sinew run robots/bigrobotarm/sequence.txt --robot bigrobotarm)
printf '$ %s\n' "${demo[*]}"
exec "${demo[@]}"
