#!/usr/bin/env bash
# Builds the Debian package, looks into it, installs it in a folder that plays the root of a system, and removes it.
#
#   scripts/deb-check.sh [PROFILE]      PROFILE is release, or dev for a quicker look
#
# Nothing outside the target folder is touched: dpkg works on its own database there, and the maintainer scripts make the user
# in the passwd of that folder (DPKG_ROOT). Needs dpkg and what scripts/deb.sh needs;
# runs as root or, where the kernel lets users make namespaces, as anybody. What a running systemd would do with the unit is not
# checked, only that systemd understands it.
set -euo pipefail
cd "$(dirname "$0")/.."
. scripts/missing.sh
profile=${1:-release}
target=${CARGO_TARGET_DIR:-target}
built=$target/$([ "$profile" = dev ] && echo debug || echo "$profile")
fail() { printf 'deb-check: %s\n' "$1" >&2; exit 1; }

command -v dpkg-deb >/dev/null || { missing dpkg dpkg; exit 0; }
if [ "$(id -u)" != 0 ]; then
    unshare --map-root-user true 2>/dev/null || { missing dpkg "root or a user namespace"; exit 0; }
fi
echo "deb-check: building"
if [ "$profile" = release ]; then scripts/release-build.sh; else cargo build --profile "$profile" -p gripd -p gripctl; fi
"$built/gripd" --check-config --config packaging/gripd.toml
"$built/gripd" --check-config --config docs/gripd.toml
# That of gripfleet holds the program as the tests have built it: an optimised network takes minutes, and is looked at by nobody here.
target=$(realpath -m "$target")
(cd fleet && CARGO_TARGET_DIR=$target cargo build --quiet -p gripfleet)
rm -rf "$target/deb-check"
scripts/deb.sh "$target/deb-check" "$profile" dev
deb=$target/deb-check/gripd.deb
fleet=$target/deb-check/gripfleet.deb
library=$target/deb-check/libslip-dev.deb

echo "deb-check: looking into it"
listing=$(dpkg-deb --contents "$deb" | awk '{sub("^0/0$", "root/root", $2); print $1, $2, $6}')
expect() { grep -qxF -- "$1 root/root ./$2" <<<"$listing" || fail "not in the package as $1: $2
$listing"; }
expect -rwxr-xr-x usr/bin/gripd
expect -rwxr-xr-x usr/bin/gripctl
expect -rw-r--r-- etc/gripd/gripd.toml
expect -rw-r--r-- usr/lib/systemd/system/gripd.service
expect -rw-r--r-- usr/lib/udev/rules.d/70-gripd.rules
expect -rw-r--r-- usr/share/man/man1/gripd.1.gz
expect -rw-r--r-- usr/share/man/man1/gripctl-doctor.1.gz
expect -rw-r--r-- usr/share/bash-completion/completions/gripctl
expect -rw-r--r-- usr/share/zsh/vendor-completions/_gripd
expect -rw-r--r-- usr/share/fish/vendor_completions.d/gripd.fish
expect -rw-r--r-- usr/share/doc/gripd/copyright
# gripmon needs a display and is no part of it; gripfleet has a package of its own.
if grep -qE "gripmon|gripfleet" <<<"$listing"; then fail "parts of gripmon or gripfleet in the package"; fi
if grep -vE '^([-d]rw[-x]r-[-x]r-[-x]|lrwxrwxrwx) root/root ' <<<"$listing"; then fail "odd owners or rights"; fi
control=$(dpkg-deb --info "$deb")
for word in "Package: gripd" "Depends: libc6" "conffiles" "postinst" "prerm" "postrm"; do
    grep -qF "$word" <<<"$control" || fail "no '$word' in its control data: $control"
done
if command -v lintian >/dev/null; then lintian --fail-on error "$deb"; else missing lintian lintian; fi

listing=$(dpkg-deb --contents "$fleet" | awk '{sub("^0/0$", "root/root", $2); print $1, $2, $6}')
expect -rwxr-xr-x usr/bin/gripfleet
expect -rw-r--r-- usr/lib/systemd/system/gripfleet.service
expect -rw-r--r-- usr/share/man/man1/gripfleet.1.gz
grep -q "Depends: .*gripd" <<<"$(dpkg-deb --info "$fleet")" || fail "gripfleet does not depend on gripd"

listing=$(dpkg-deb --contents "$library" | awk '{sub("^0/0$", "root/root", $2); print $1, $2, $6}')
expect -rw-r--r-- usr/include/slip.h
expect -rw-r--r-- usr/lib/libslip.a
expect -rw-r--r-- usr/lib/libslip.so.0
expect lrwxrwxrwx usr/lib/libslip.so
expect -rw-r--r-- usr/lib/pkgconfig/slip.pc
expect -rw-r--r-- usr/lib/cmake/slip/slipConfig.cmake

echo "deb-check: installing and removing it"
enter() { if [ "$(id -u)" = 0 ]; then "$@"; else unshare --map-root-user "$@"; fi; }
root=$(realpath "$target")/deb-check/root
mkdir -p "$root"/{etc,var/lib/dpkg/info,var/lib/dpkg/updates,var/log,usr/bin}
touch "$root"/var/lib/dpkg/{status,available}
echo 'root:x:0:0:root:/root:/bin/sh' >"$root/etc/passwd"
printf 'root:x:0:\ndialout:x:20:\n' >"$root/etc/group"
here() { find "$root" \( -type f -o -type l \) -not -path "$root/var/*" -not -name '*-' | sed "s|^$root||" | sort; }
before=$(here)
host=$(sha256sum /etc/passwd /etc/group)
do_dpkg() {
    enter dpkg --root="$root" --force-script-chrootless --force-depends --no-triggers --log=/dev/null "$@" \
        >"$target/deb-check/dpkg.log" 2>&1 || fail "dpkg $*: $(cat "$target/deb-check/dpkg.log")"
}
do_dpkg --install "$deb"
"$root/usr/bin/gripd" --version | grep -qx 'gripd [0-9.]*' || fail "the installed gripd does not run"
"$root/usr/bin/gripctl" --version | grep -qx 'gripctl [0-9.]*' || fail "the installed gripctl does not run"
"$root/usr/bin/gripd" --check-config --config "$root/etc/gripd/gripd.toml"
grep -q '^gripd:.*:/var/lib/gripd:/usr/sbin/nologin$' "$root/etc/passwd" || fail "no user gripd"
grep -q '^dialout:.*[:,]gripd$' "$root/etc/group" || fail "gripd is not in dialout"
gzip -t "$root/usr/share/man/man1/gripd.1.gz"
do_dpkg --install "$deb" # again, as an upgrade does
do_dpkg --install "$fleet"
do_dpkg --install "$library"
[ -e "$root/usr/lib/libslip.so" ] || fail "libslip.so leads nowhere"
"$root/usr/bin/gripfleet" --version | grep -qx 'gripfleet [0-9.]*' || fail "the installed gripfleet does not run"
for module in cdc_acm usbserial; do # or DeviceAllow= leaves out what is plugged in after the start
    for key in Wants After; do
        grep -q "^$key=.*modprobe@$module.service" packaging/gripd.service || fail "gripd.service: $key= lacks modprobe@$module"
    done
done
if command -v systemd-analyze >/dev/null; then
    for name in gripd gripfleet; do
        unit=$target/deb-check/$name.service
        sed "s|^ExecStart=/usr/bin/|ExecStart=$root/usr/bin/|; /^Documentation/d" \
            "$root/usr/lib/systemd/system/$name.service" >"$unit"
        said=$(systemd-analyze verify "$unit" 2>&1) || fail "systemd-analyze verify: $said"
        [ -z "$said" ] || fail "systemd-analyze verify: $said"
        # Exposure in tenths: 0 is none.
        systemd-analyze security --offline=true --threshold=20 --no-pager "$unit" >"$target/deb-check/exposure" ||
            fail "$name is more exposed than 2.0: $(tail -n 1 "$target/deb-check/exposure")"
        tail -n 1 "$target/deb-check/exposure"
    done
else
    missing systemd "systemd-analyze: the unit is not checked"
fi
if udevadm verify --help >/dev/null 2>&1; then
    udevadm verify "$root/usr/lib/udev/rules.d/70-gripd.rules"
else
    missing udevadm "udevadm verify: the udev rule is not checked"
fi
do_dpkg --remove libslip-dev
do_dpkg --remove gripfleet
do_dpkg --remove gripd
left=$(comm -13 <(echo "$before") <(here))
[ "$left" = "/etc/gripd/gripd.toml" ] || fail "removal leaves more than its configuration: $left"
do_dpkg --purge gripd
left=$(comm -13 <(echo "$before") <(here))
[ -z "$left" ] || fail "purging leaves: $left"
[ "$host" = "$(sha256sum /etc/passwd /etc/group)" ] || fail "the users of this computer were changed"
echo "deb-check: done"
