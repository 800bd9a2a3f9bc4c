#!/bin/sh
# The Arduino library: packed, its manifests checked, its sketches compiled for an ATmega2560 with the core of Arduino and for a Cortex-M0+
# without one, and run in simavr or against an emulated part, where the Python peer reads their samples over the link. The detector in QEMU, on a Cortex-M4, a Cortex-M33, and a
# Cortex-M3 and a RISC-V without floating point: the same bytes as on this machine. Installs the compilers and emulators (Debian) where they are missing.
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
. "$root/scripts/missing.sh"
target=${CARGO_TARGET_DIR:-$root/target}
work=$target/arduino
mkdir -p "$work"
work=$(cd "$work" && pwd)

core=/usr/share/arduino/hardware/arduino/avr
packages=
command -v avr-g++ >/dev/null || packages="gcc-avr avr-libc"
[ -f "$core/cores/arduino/Arduino.h" ] || packages="$packages arduino-core-avr"
[ -f /usr/include/simavr/sim_avr.h ] || packages="$packages libsimavr-dev libelf-dev"
command -v arm-none-eabi-g++ >/dev/null || packages="$packages gcc-arm-none-eabi"
[ -d /usr/lib/arm-none-eabi/newlib ] || packages="$packages libnewlib-arm-none-eabi"
command -v qemu-system-arm >/dev/null || packages="$packages qemu-system-arm"
command -v qemu-system-riscv32 >/dev/null || packages="$packages qemu-system-misc"
[ -d /usr/lib/picolibc/riscv64-unknown-elf ] || packages="$packages gcc-riscv64-unknown-elf picolibc-riscv64-unknown-elf"
[ -f /usr/lib/xtensa-lx106-elf/picolibc.specs ] || packages="$packages gcc-xtensa-lx106 picolibc-xtensa-lx106-elf"
# shellcheck disable=SC2086 # a list of packages
[ -z "$packages" ] || install_packages $packages

"$root/scripts/arduino-library.sh" "$work"
library=$work/GripLink
# What is packed is what the Rust and Python peers are compared with.
cmp "$library/src/grip_link.c" "$root/protocol/c/grip_link.c"
cmp "$library/src/grip_link.h" "$root/protocol/c/grip_link.h"
# Each keyword is a word of the headers.
cut -f 1 "$library/keywords.txt" | while read -r word; do
    [ "$word" = GripLink ] || grep -qw "$word" "$library/src/"*.h || { echo "keywords.txt: $word is in no header" >&2; exit 1; }
done
"$("$root/scripts/python.sh" || echo python3)" "$root/protocol/arduino/test/manifests.py" "$library"

# Debian's compiler for AVR has DECIMAL_DIG for C alone.
chip="-mmcu=atmega2560 -DF_CPU=16000000L -DARDUINO=10819 -DARDUINO_AVR_MEGA2560 -DARDUINO_ARCH_AVR -DDECIMAL_DIG=__DECIMAL_DIG__"
search="-I$core/cores/arduino -I$core/variants/mega -I$core/libraries/Wire/src -I$library/src"
build=$work/build
rm -rf "$build"
mkdir -p "$build/core"
for source in "$core/cores/arduino/"*.c "$core/cores/arduino/"*.S; do
    # shellcheck disable=SC2086 # lists of flags
    avr-gcc $chip $search -w -Os -ffunction-sections -fdata-sections -c "$source" -o "$build/core/$(basename "$source").o"
done
for source in "$core/cores/arduino/"*.cpp; do
    # shellcheck disable=SC2086
    avr-g++ $chip $search -w -Os -std=gnu++11 -fno-exceptions -fno-threadsafe-statics -ffunction-sections -fdata-sections -c "$source" \
        -o "$build/core/$(basename "$source").o"
done
wire=$core/libraries/Wire/src
# shellcheck disable=SC2086
avr-g++ $chip $search -w -Os -std=gnu++11 -fno-exceptions -ffunction-sections -c "$wire/Wire.cpp" -o "$build/core/Wire.o"
# shellcheck disable=SC2086
avr-gcc $chip $search -w -Os -ffunction-sections -c "$wire/utility/twi.c" -o "$build/core/twi.o"
avr-ar rcs "$build/core.a" "$build/core/"*.o
warnings="-Wall -Wextra -Werror"
# shellcheck disable=SC2086
avr-gcc $chip $search $warnings -std=c99 -Os -ffunction-sections -c "$library/src/grip_link.c" -o "$build/grip_link.o"
for sketch in piezo gripper loadcell accelerometer; do
    # shellcheck disable=SC2086
    avr-g++ $chip $search $warnings -Os -std=gnu++11 -fno-exceptions -fno-threadsafe-statics -ffunction-sections -fdata-sections \
        -x c++ -include Arduino.h -c "$library/examples/$sketch/$sketch.ino" -o "$build/$sketch.o"
    # shellcheck disable=SC2086
    avr-g++ $chip -Os -Wl,--gc-sections "$build/$sketch.o" "$build/grip_link.o" "$build/core.a" -lm -o "$build/$sketch.elf"
    avr-size "$build/$sketch.elf" | awk -v name="$sketch" 'NR == 2 { print name ", ATmega2560: flash " $1 + $2 ", static RAM " $2 + $3 " bytes" }'
    # The same text for a Cortex-M0+, against the few functions of a core that it uses.
    arm-none-eabi-g++ -mcpu=cortex-m0plus -mthumb -ffreestanding -std=c++11 -fno-exceptions -fno-threadsafe-statics $warnings -Os \
        "-I$root/protocol/arduino/test/core" "-I$root/protocol/firmware/include" "-I$library/src" \
        -x c++ -include Arduino.h -c "$library/examples/$sketch/$sketch.ino" -o "$build/$sketch-m0.o"
done
arm-none-eabi-gcc -mcpu=cortex-m0plus -mthumb -ffreestanding -std=c99 $warnings -Os "-I$root/protocol/firmware/include" \
    -c "$library/src/grip_link.c" -o "$build/grip_link-m0.o"
arm-none-eabi-size "$build/grip_link-m0.o" | awk 'NR == 2 { print "grip_link.c, Cortex-M0+: flash " $1 + $2 " bytes" }'

cc -std=c99 -D_POSIX_C_SOURCE=200809L -O2 "$root/protocol/arduino/test/board.c" -o "$build/board" -lsimavr -lelf -lm
for sketch in piezo loadcell; do
    python3 "$root/protocol/arduino/test/check.py" "$sketch" "$build/board" "$build/$sketch.elf"
done
# The accelerometers on this computer, with a part on I2C that loses its power once.
cc -std=c99 -O2 -c "$library/src/grip_link.c" -o "$build/grip_link-host.o"
for part in ADXL345=0x53,0x00,0xE5,0x32 LIS2DW12=0x19,0x0F,0x44,0x28 MPU6050=0x68,0x75,0x68,0xBB; do
    # shellcheck disable=SC2086
    c++ -std=c++11 -O2 $warnings "-D${part%%=*}" "-DPART_BYTES=${part#*=}" "-I$root/protocol/arduino/test/core" "-I$library/src" \
        -x c++ -include Arduino.h "$library/examples/accelerometer/accelerometer.ino" "$root/protocol/arduino/test/host.cpp" \
        -x none "$build/grip_link-host.o" -o "$build/${part%%=*}"
    python3 "$root/protocol/arduino/test/check.py" accelerometer "$build/${part%%=*}" "$build/${part%%=*}"
done

# The detector alone: its sketch for a Cortex-M0+, its source for an AVR too, since an IDE compiles every source of a library.
warnings="$warnings -Wconversion"
# shellcheck disable=SC2086
avr-gcc $chip $search $warnings -std=c99 -Os -c "$library/src/slip_detector.c" -o "$build/slip_detector.o"
# shellcheck disable=SC2086
arm-none-eabi-g++ -mcpu=cortex-m0plus -mthumb -std=c++11 -fno-exceptions $warnings -Os "-I$root/protocol/arduino/test/core" "-I$library/src" \
    -x c++ -include Arduino.h -c "$library/examples/detector/detector.ino" -o "$build/detector-m0.o"
source="$library/src/slip_detector.c $root/protocol/arduino/test/detector.c"
# shellcheck disable=SC2086
cc -std=c99 -O2 -ffp-contract=off $warnings "-I$library/src" $source -o "$build/detector" -lm
python3 "$root/protocol/arduino/test/readings.py" >"$build/readings"
"$build/detector" 1600 0 <"$build/readings" >"$build/expected"
detector() { # NAME MACHINE VECTORS MHZ FLAGS..: on this processor of QEMU; its RAM of 4 MB begins with the vectors, SysTick counts so many MHz
    name=$1 machine=$2 vectors=$3 tick=$((1000 / $4))
    shift 4
    arm-none-eabi-gcc "$@" -mthumb -O2 -ffp-contract=off -c "$library/src/slip_detector.c" -o "$build/slip_detector-m.o"
    arm-none-eabi-size "$build/slip_detector-m.o" | awk -v name="$name" 'NR == 2 { print "slip_detector.c, " name ": flash " $1 + $2 " bytes" }'
    # shellcheck disable=SC2086
    arm-none-eabi-gcc "$@" -mthumb -O2 -ffp-contract=off $warnings "-I$library/src" $source "$root/protocol/arduino/test/processor.c" \
        --specs=rdimon.specs "-DINSTRUCTIONS=${tick}u" "-DSTACK=$vectors + 0x400000" -Wl,--wrap=sd_step \
        "-Wl,--section-start=.vectors=$vectors" "-Wl,-Ttext-segment=$(printf '0x%x' $((vectors + 0x8000)))" -lm -o "$build/detector-m.elf"
    timeout 120 qemu-system-arm -M "$machine" -display none -monitor none -serial none -icount shift=0 \
        -semihosting-config enable=on,target=native,arg=detector,arg=1600,arg=0 -kernel "$build/detector-m.elf" <"$build/readings" >"$build/got"
    cmp "$build/got" "$build/expected"
}
detector Cortex-M4 mps2-an386 0x0 25 -mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -mfloat-abi=hard
detector Cortex-M3 mps2-an385 0x0 25 -mcpu=cortex-m3
detector 'Cortex-M33, as in an RP2350' mps2-an505 0x10000000 20 -mcpu=cortex-m33 -mfpu=fpv5-sp-d16 -mfloat-abi=hard
bare() { # NAME PROCESSOR FLAGS..: the size of the sources for a processor of Espressif
    name=$1 processor=$2
    shift 2
    for part in slip_detector grip_link; do
        # shellcheck disable=SC2086
        "$processor-gcc" "$@" -std=c99 -Os $warnings -c "$library/src/$part.c" -o "$build/$part-e.o"
        "$processor-size" "$build/$part-e.o" | awk -v name="$part.c, $name" 'NR == 2 { print name ": flash " $1 + $2 " bytes" }'
    done
}
bare ESP8266 xtensa-lx106-elf -mlongcalls --specs=/usr/lib/xtensa-lx106-elf/picolibc.specs
bare ESP32-C3 riscv64-unknown-elf -march=rv32imc -mabi=ilp32 --specs=picolibc.specs
riscv64-unknown-elf-gcc -march=rv32imc -mabi=ilp32 -std=c99 -O2 -ffp-contract=off --specs=picolibc.specs --crt0=hosted --oslib=semihost "-I$library/src" \
    "$library/src/slip_detector.c" "$root/protocol/arduino/test/processor.c" -Wl,--wrap=sd_step -Wl,--defsym=__flash=0x80000000 \
    -Wl,--defsym=__flash_size=2M -Wl,--defsym=__ram=0x80200000 -Wl,--defsym=__ram_size=2M -lm -o "$build/detector-v.elf"
(cd "$build" && rm -f got && timeout 120 qemu-system-riscv32 -M virt -bios none -display none -monitor none -serial none -icount shift=0 \
    -semihosting-config enable=on,target=native -kernel detector-v.elf)
cmp "$build/got" "$build/expected"
echo "slip_detector.c: the same states and statistics on all four as on this machine"
