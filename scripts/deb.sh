#!/usr/bin/env bash
# Packs the Debian packages of programs that are built: gripd.deb (gripd and gripctl), libslip-dev.deb, and gripfleet.deb where gripfleet is
# built too.
#
#   scripts/deb.sh FOLDER [PROFILE [PROFILE]]      of gripd and the library, of gripfleet; each release unless given
#
# Needs dpkg and cargo-deb, which is installed into the target folder where it is missing.
set -euo pipefail
cd "$(dirname "$0")/.."
folder=${1:?usage: scripts/deb.sh FOLDER [PROFILE [PROFILE]]}
profile=${2:-release}
fleet=${3:-release}
target=${CARGO_TARGET_DIR:-target}
PATH=$PATH:$(realpath -m "$target")/tools/bin
command -v cargo-deb >/dev/null || cargo install cargo-deb --version 3.8.0 --locked --debug --root "$target/tools"
rm -rf target/manuals
mkdir -p "$folder"
target=$(realpath -m "$target")
export CARGO_TARGET_DIR=$target
cargo run --quiet -p grip-manuals -- target/manuals
scripts/c-library.sh target/c-library "$profile"
folder=$(realpath -m "$folder")
pack() { cargo deb --package "$1" --profile "$2" --no-build --no-strip --quiet --output "$folder/$3.deb"; }
pack gripd "$profile" gripd
pack slip-ffi "$profile" libslip-dev
cd fleet
if [ ! -x "$target/$([ "$fleet" = dev ] && echo debug || echo "$fleet")/gripfleet" ]; then
    echo "deb: gripfleet is not built and left out"
    exit 0
fi
cargo run --quiet -p fleet-manuals -- target/manuals
pack gripfleet "$fleet" gripfleet
