# The doors of the house. Each is a script in scripts/ that says what it does and how long it took;
# full logs go to build/logs/. All of them may be repeated: what is done is not done again.

.PHONY: help run build firmware test bare bench campaign format clean

help:
	@echo "make run       install what is missing, build, and open the panel on five simulated robots"
	@echo "make build     install what is missing, build build/release/sinew"
	@echo "make firmware  install what is missing, build the images of the boards into build/firmware"
	@echo "make test      install what is missing, build and run every test (release, asan/ubsan)"
	@echo "make bare      make run and make test in a bare Debian 12 (root; SUITE=trixie: Debian 13)"
	@echo "make bench     measure against the references: table, and build/bench.json"
	@echo "make campaign  the long checks: format, clang, clang-tidy, tsan, fuzzing, fresh seeds,"
	@echo "               a million faults on every wire (SINEW_FAULTS=1000000), a million sequences"
	@echo "               of plan, jog, override, pause and stop (SINEW_SEQUENCES=1000000), power"
	@echo "               losses (SINEW_POWER_LOSSES=100000), real kill -9 (SINEW_KILLS=1000), outages"
	@echo "               of two processes (SINEW_OUTAGES=1430), the whole system (SINEW_SEEDS=100000), and"
	@echo "               the same seeds by g++ and by clang"
	@echo "               FUZZ_SECONDS=60 per target, SEEDS=5 runs, SOAK_MINUTES=30; PARTS=\"tsan fuzz\" picks some"
	@echo "make format    lay out all C++ with clang-format"
	@echo "make clean     remove build/"

run:
	@scripts/run.sh

build:
	@scripts/build.sh

firmware:
	@scripts/firmware.sh

test:
	@scripts/test.sh

bare:
	@scripts/bare.sh

bench:
	@scripts/bench.sh

campaign:
	@scripts/campaign.sh

format:
	@scripts/format.sh

clean:
	rm -rf build
