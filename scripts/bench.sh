#!/usr/bin/env bash
# Measures against the references; prints the table of ratios, writes build/bench.json.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

echo "sinew: bench"
scripts/packages.sh build bench
configure release "$(keep_toggle release SINEW_TESTS libgtest-dev liborocos-kdl-dev)" \
  -DSINEW_BENCH=ON
build release sinew_bench sinew_wire_rates
build/release/sinew_bench --benchmark_out=build/bench.json --benchmark_out_format=json
echo "  build/bench.json"
build/release/sinew_wire_rates
