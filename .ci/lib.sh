# Shared by `run` and `full`: settings of the build, and parts that are timed. Sourced, from the repository's root.

# No part debugs these builds: without debug information it links faster and takes less of the disk. Nor is it timed: without
# optimisation across units it is built sooner.
export CARGO_INCREMENTAL=0 CARGO_PROFILE_RELEASE_DEBUG=false CARGO_PROFILE_RELEASE_LTO=off
target=${CARGO_TARGET_DIR:-$PWD/target}
# One set of features for all that is built, so that the engine is compiled once.
workspace=(--workspace --features bevy_rhexis/gizmos)

need() {
    command -v "$1" >/dev/null 2>&1 || { echo "$1 is not on the PATH: $2" >&2; exit 1; }
}

parts=()
print_parts() {
    local status=$? part
    printf '\n%8s  part\n' seconds
    for part in "${parts[@]}"; do printf '%8s  %s\n' "${part%%|*}" "${part#*|}"; done
    printf '%8s  in all\n' "$SECONDS"
    [ "$status" = 0 ] || echo "FAILED: ${current:-before the first part}" >&2
}
trap print_parts EXIT

# part NAME COMMAND...: runs the command, and lists its time in the table at the end.
part() {
    current=$1
    local started=$SECONDS
    echo "== $1"
    "${@:2}"
    parts+=("$((SECONDS - started))|$1")
    current=
}

# not_run NAME REASON: a part that this machine cannot run is in the table too.
not_run() {
    echo "== $1: NOT RUN: $2" >&2
    parts+=("NOT RUN|$1: $2")
}

# Sources of each long part. `passed` has the hash with which it last passed.
declare -A sources=(
    [notebooks]="bindings/python tests/public_api.txt"
    [page]="bindings/web tests/public_api.txt"
    [studies]="bindings/studies tests/public_api.txt"
    [trainer]="bindings/bevy tests/public_api.txt"
)
hash_of() {
    # shellcheck disable=SC2086 # several paths
    git ls-files --stage -- ${sources[$1]} | sha256sum | cut -c 1-16
}
has_passed() {
    grep -qxF "$1 $(hash_of "$1")" .ci/passed
}
note_passed() {
    sed -i "s/^$1 .*/$1 $(hash_of "$1")/" .ci/passed
}

page() {
    RHEXIS_PROGRAM=$target/release/rhexis bindings/web/check.sh --page
}
notebooks() {
    bindings/python/check.sh --notebooks
}
studies() {
    bindings/studies/check.sh "$target/release/rhexis"
}
trainer() {
    if command -v apt-get >/dev/null 2>&1 && [ "$(id -u)" = 0 ]; then
        apt-get update -qq && apt-get install -y -qq --no-install-recommends libasound2-dev libudev-dev libxkbcommon-dev pkg-config >/dev/null
    fi
    cargo clippy --locked --package bevy_rhexis --features trainer --examples -- -D warnings
}
