#!/usr/bin/env bash
# Builds build/release/sinew: what a user needs, no tests. The tree is the one of `make test`, so
# neither builds again what the other has built.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

echo "sinew: build"
scripts/packages.sh build
scripts/panel.sh
configure release "$(keep_toggle release SINEW_TESTS libgtest-dev liborocos-kdl-dev)" \
  "$(keep_toggle release SINEW_BENCH libbenchmark-dev liborocos-kdl-dev)"
build release sinew
printf '  %s\n' "build/release/sinew"
