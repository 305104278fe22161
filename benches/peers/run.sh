#!/usr/bin/env bash
# Installs the other engines, runs all on the scenes, prints run time against error and writes the table of it.
# run.sh [--quick] [--page] [--dir DIR] [--out FILE]: installs and builds into DIR, target/peers by default; FILE is benches/results/peers.csv
# by default, with --quick a file in DIR. --page puts the tables into README.md. RHEXIS=PATH names a built program.
# Needs Python 3.11 or newer, Rust, PyPI and crates.io.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
folder=$root/target/peers
out=
options=()
is_quick=
while (($#)); do
    case $1 in
        --quick) options+=(--quick) is_quick=1 ;;
        --page) options+=(--page) ;;
        --dir | --out)
            [[ $# -ge 2 ]] || { echo "$1 wants a path" >&2 && exit 2; }
            if [[ $1 == --dir ]]; then folder=$2; else out=$2; fi
            shift
            ;;
        *) sed -n '2,5s/^# //p' "$0" >&2 && exit 2 ;;
    esac
    shift
done
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
if [[ -z $out && -n $is_quick ]]; then out=$folder/quick.csv; fi
if [[ -n $out ]]; then out=$(realpath -m "$out"); fi
if [[ -n ${RHEXIS:-} ]]; then RHEXIS=$(realpath "$RHEXIS"); fi
export PYTHONDONTWRITEBYTECODE=1 WARP_CACHE_PATH=$folder/warp

echo "installing into $folder"
[[ -x $folder/venv/bin/python ]] || python3 -m venv "$folder/venv"
install() {
    "$folder/venv/bin/pip" install --quiet --disable-pip-version-check --requirement "$here/requirements/$1.txt" >"$folder/$1.log" 2>&1
}
install base || { cat "$folder/base.log" >&2 && exit 1; }

# An engine that cannot be had is named in the table, and the others run all the same.
missing=()
miss() {
    missing+=(--missing "$1=$2: $(tail -n 1 "$folder/$1.log")")
    echo "$1 is left out: $2, see $folder/$1.log" >&2
}
for engine in mujoco newton; do
    install "$engine" || miss "$engine" "pip install failed"
done
cargo build --quiet --release --locked --manifest-path "$here/rapier/Cargo.toml" --target-dir "$folder/rapier" 2>"$folder/rapier.log" ||
    miss rapier "cargo build failed"
if [[ -z ${RHEXIS:-} ]]; then
    cargo build --quiet --release --locked --manifest-path "$root/Cargo.toml" --package rhexis-cli --target-dir "$folder/rhexis"
fi

export RAPIER_PEER=$folder/rapier/release/rhexis-peer-rapier RHEXIS_PEER=${RHEXIS:-$folder/rhexis/release/rhexis}
# Engines write their logs where they run.
cd "$folder"
"$folder/venv/bin/python" "$here/measure.py" "${options[@]}" "${missing[@]}" ${out:+--out "$out"}
