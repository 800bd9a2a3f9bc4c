# Sourced by the checks, which fail where something is missing.
#
#   missing WORD WHAT    says what is missing and ends with 1; where GRIP_ALLOW_MISSING names the word (commas between), it says that this is
#                        left out and returns. The words stand in CONTRIBUTING.md.
missing() {
    case ",${GRIP_ALLOW_MISSING:-}," in
    *",$1,"*) echo "${0##*/}: left out: $2" >&2 ;;
    *)
        echo "${0##*/}: missing: $2 (GRIP_ALLOW_MISSING=$1 leaves it out)" >&2
        exit 1
        ;;
    esac
}

#   install_packages PACKAGE...   installs packages of Debian, or ends with 1 and their names
install_packages() {
    command -v apt-get >/dev/null || { echo "${0##*/}: missing: $*; there is no apt-get here" >&2; exit 1; }
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || { echo "${0##*/}: missing: $*; that needs root or sudo" >&2; exit 1; }
        as_root=sudo
    fi
    $as_root apt-get update -q >&2
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@" >&2
}

#   python_work FOLDER   sets target, work (FOLDER in it) and python, that of scripts/python.sh; needs root. Ends with 0 where it may be missing.
python_work() {
    target=${CARGO_TARGET_DIR:-$root/target}
    mkdir -p "$target/$1"
    target=$(cd "$target" && pwd)
    work=$target/$1
    python=$("$root/scripts/python.sh") || { missing pip "the packages of scripts/python.sh"; exit 0; }
    export PYTHONPYCACHEPREFIX="$work/byte-code"
}

#   release_gripctl      sets GRIPCTL, where it is not named, to that of a release build, with gripd and the others beside it; needs root, target
release_gripctl() {
    [ -z "${GRIPCTL:-}" ] || return 0
    CARGO_TARGET_DIR="$target" "$root/scripts/release-build.sh"
    GRIPCTL=$target/release/gripctl
}

#   second_compiler      installs Debian's Rust with its sources (a download of 170 MB) and lld where they are missing
#   core_from_source ARGUMENT...   is its `cargo` with them, with the unstable option that builds core; no flag of the caller leaks in
second_compiler() {
    packages=
    [ -x /usr/bin/cargo ] && [ -x /usr/bin/rustc ] && [ -d /usr/lib/rustlib/src/rust/library/core ] ||
        packages="rustc-web cargo-web rust-web-src rust-web-llvm"
    command -v ld.lld-22 >/dev/null || packages="$packages lld-22"
    # shellcheck disable=SC2086 # a list of packages
    [ -z "$packages" ] || install_packages $packages
}
core_from_source() {
    env -u RUSTFLAGS -u RUSTUP_TOOLCHAIN PATH=/usr/bin:/bin CARGO_HOME="${CARGO_HOME:-$HOME/.cargo}" RUSTC_BOOTSTRAP=1 \
        /usr/bin/cargo "$@" -Zbuild-std=core
}
