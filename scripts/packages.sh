#!/usr/bin/env bash
# packages.sh SET...: installs the Debian packages of the named sets (build, panel, browser, firmware, test,
# bench, campaign, format) that are missing. Asks apt for nothing where nothing is missing.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

packages_of() {
  case $1 in
    build) echo g++ cmake ninja-build libtomlplusplus-dev nlohmann-json3-dev libcli11-dev \
      libfmt-dev libboost-dev libssl-dev libpng-dev libturbojpeg0-dev libapriltag-dev \
      libeigen3-dev ;;
    # Another node than Debian's will do, and brings an npm that Debian's is at odds with.
    panel) command -v node >/dev/null && command -v npm >/dev/null || echo nodejs npm ;;
    browser) command -v chromium >/dev/null || echo chromium ;;
    test) echo libgtest-dev liborocos-kdl-dev python3 python3-jsonschema \
      python3-websockets openssl ;;
    # The compilers with the headers of their libraries, what runs the images on this machine, and what writes
    # them.
    firmware) echo gcc-arm-none-eabi libnewlib-arm-none-eabi libstdc++-arm-none-eabi-dev \
      gcc-avr avr-libc arduino-core-avr sdcc libunicorn-dev libsimavr-dev sdcc-ucsim stm32flash \
      avrdude ;;
    bench) echo libbenchmark-dev liborocos-kdl-dev ;;
    campaign) echo clang-19 clang-tidy-19 clang-format-19 libclang-rt-19-dev ;;
    format) echo clang-format-19 ;;
    *) die "packages.sh: no set of packages is called $1" ;;
  esac
}

wanted=()
for set in "$@"; do
  read -ra packages < <(packages_of "$set") || true # an empty set
  wanted+=("${packages[@]}")
done
mapfile -t wanted < <(printf '%s\n' "${wanted[@]}" | sed '/^$/d' | sort -u)

# Elsewhere than on Debian the packages have other names; what can be checked are the tools.
if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
  for tool in g++ cmake ninja; do
    command -v "$tool" >/dev/null ||
      die "this is not Debian and $tool is missing: install what Debian calls ${wanted[*]}"
  done
  echo "  not Debian: going on with the g++, cmake and ninja found here"
  exit 0
fi

missing=()
for package in "${wanted[@]}"; do
  have_packages "$package" || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  printf '  %-34s %10s\n' "packages" "all here"
  exit 0
fi

as_root=()
by_hand="apt-get update && apt-get install -y --no-install-recommends ${missing[*]}"
if ((EUID != 0)); then
  command -v sudo >/dev/null ||
    die "packages are missing and neither root nor sudo is here; run as root: $by_hand"
  # Asked for here, where the question can be seen; the installation writes to a log.
  sudo -v || die "packages are missing and sudo did not allow to install them; as root: $by_hand"
  as_root=(sudo)
fi

apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=300 \
    -o Acquire::Retries=2 "$@"
}
install_missing() {
  # A failed update may still leave usable lists; the installation decides.
  apt update || true
  apt install -y --no-install-recommends "${missing[@]}"
}

printf '  installing %s\n' "${missing[*]}" | fold -s -w 96
step "packages" "packages" install_missing ||
  die "could not install packages (is there a network?); as root: $by_hand"
