#!/bin/sh
# The Arduino library as a folder and a ZIP file: protocol/arduino with grip_link.h and grip_link.c of protocol/c, which stand there alone.
#
#   arduino-library.sh [FOLDER]     FOLDER/GripLink and FOLDER/GripLink.zip; FOLDER is target/arduino where none is named
set -eu
root=$(cd "$(dirname "$0")/.." && pwd)
folder=${1:-${CARGO_TARGET_DIR:-$root/target}/arduino}
mkdir -p "$folder"
rm -rf "$folder/GripLink" "$folder/GripLink.zip"
mkdir -p "$folder/GripLink/src"
cd "$root/protocol/arduino"
cp -R library.properties library.json keywords.txt README.md examples "$folder/GripLink/"
cp src/GripLink.h src/slip_detector.h src/slip_detector.c ../c/grip_link.h ../c/grip_link.c "$folder/GripLink/src/"
cp "$root/LICENSE-MIT" "$root/LICENSE-APACHE" "$folder/GripLink/"
# Links that lead out of the library are dead there.
sed -i -z 's/\[\([^]]*\)\](\.\.[^)]*)/\1/g' "$folder/GripLink/README.md"
cd "$folder"
python3 -m zipfile -c GripLink.zip GripLink
echo "$folder/GripLink.zip"
