#!/bin/sh
# Keys and certificates for one router and for everybody who may speak to it, made with openssl: an authority of your own, the router's
# name and address, then one name for each that connects. The names are those in router.json5.
#
#   sh certificates.sh FOLDER ROUTER-NAME ROUTER-ADDRESS NAME...
#   sh certificates.sh /etc/grip/keys router.lab 10.0.0.1 gripper-1 gripper-2 viewer operator
#
# Runs again for more names: the authority and what is there already stay.
set -eu

if [ $# -lt 4 ]; then
    sed -n '2,8s/^# \{0,1\}//p' "$0" >&2
    exit 2
fi
folder=$1 router=$2 address=$3
shift 3
days=730
umask 077
mkdir -p "$folder"
cd "$folder"

new_key() { openssl genpkey -algorithm EC -pkeyopt ec_paramgen_curve:P-256 -out "$1"; }

if [ ! -e authority.key ]; then
    new_key authority.key
    openssl req -x509 -new -key authority.key -days 3650 -subj "/CN=grippers" -out authority.pem \
        -addext "basicConstraints=critical,CA:TRUE" -addext "keyUsage=critical,keyCertSign"
fi

# name, purpose, further names
certificate() {
    if [ -e "$1.pem" ]; then return; fi
    new_key "$1.key"
    openssl req -new -key "$1.key" -subj "/CN=$1" -out "$1.csr"
    printf 'basicConstraints=CA:FALSE\nextendedKeyUsage=%s\nsubjectAltName=%s\n' "$2" "$3" >"$1.ext"
    openssl x509 -req -in "$1.csr" -CA authority.pem -CAkey authority.key -CAcreateserial \
        -days "$days" -extfile "$1.ext" -out "$1.pem" 2>/dev/null
    rm "$1.csr" "$1.ext"
}

certificate router serverAuth "DNS:$router,IP:$address"
for name in "$@"; do
    certificate "$name" clientAuth "DNS:$name"
done
echo "keys and certificates are in $folder; keep authority.key where nobody else can read it"
