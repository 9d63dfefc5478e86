#!/usr/bin/env bash
# Builds the images of the boards into build/firmware, from nothing, with what each holds and its checksum.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

echo "sinew: firmware"
scripts/packages.sh build firmware
configure_images() {
  cmake -S firmware/stm32 -B build/firmware -G Ninja \
    -DCMAKE_TOOLCHAIN_FILE="$PWD/firmware/stm32/toolchain.cmake"
}
step "configure firmware" configure-firmware configure_images
step "build firmware" build-firmware cmake --build build/firmware -j "$(jobs_count)"
cd build/firmware
arm-none-eabi-size ./*.elf | sed 's/^/  /'
sha256sum ./*.bin ./*.hex >SHA256SUMS
sed 's/^/  /' SHA256SUMS
