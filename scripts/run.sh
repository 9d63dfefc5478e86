#!/usr/bin/env bash
# Installs what is missing, builds, and does the main job.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

scripts/build.sh
echo "sinew: run"
exec scripts/demo.sh
