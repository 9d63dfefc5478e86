#!/usr/bin/env bash
# Builds the images of the boards into build/firmware, from nothing, with what each holds and its checksum.
# shellcheck source=scripts/lib.sh
source "$(dirname "${BASH_SOURCE[0]}")/lib.sh"

echo "sinew: firmware"
scripts/packages.sh build firmware
# One folder a compiler; the images of all of them end up side by side.
for chip in stm32 atmega2560 stm8s103; do
  step "configure $chip" "configure-$chip" cmake -S "firmware/$chip" -B "build/firmware/$chip" \
    -G Ninja -DCMAKE_TOOLCHAIN_FILE="$PWD/firmware/$chip/toolchain.cmake"
  step "build $chip" "build-$chip" cmake --build "build/firmware/$chip" -j "$(jobs_count)"
  cp "build/firmware/$chip"/*.{bin,hex} build/firmware/
done
cp build/firmware/{stm32,atmega2560}/*.elf build/firmware/ # sdcc makes none
cd build/firmware
arm-none-eabi-size axis-*.elf | sed 's/^/  /'
avr-size bigrobotarm-*.elf | sed 's/^/  /'
sed 's/^/  /' stm8s103/encoder-*.size
sha256sum ./*.bin ./*.hex >SHA256SUMS
sed 's/^/  /' SHA256SUMS
