#!/bin/sh
# Counts the instructions of 50 steps of fig2-tear (1,500 triangles) in Rust and through C, with positions and triangles fetched after each:
# overhead.sh. It fails where a step through C takes more than 1 % more.
set -eu
cd "$(dirname "$0")"

if ! command -v valgrind >/dev/null 2>&1; then
    echo "overhead.sh: valgrind is not there: install the package valgrind" >&2
    exit 1
fi
program=$(cargo test --release -p rhexis-c --test memory --no-run --message-format short 2>&1 | sed -n 's/.*Executable.*(\(.*\))/\1/p')
[ -n "$program" ] || cargo test --release -p rhexis-c --test memory --no-run
# Cargo names it from the root of the workspace, or by its full path.
cd ../..

# Instructions of so many steps with all that comes before them, and the hash at the end.
counted() {
    RHEXIS_STEPS=$2 valgrind --tool=callgrind --callgrind-out-file=/dev/null "$program" --ignored --exact "$1" --nocapture 2>&1 |
        sed -n 's/.*Collected : \([0-9]*\).*/\1/p; s/.*hash \([0-9a-f]*\).*/\1/p' | tr '\n' ' '
}

for way in counted_in_rust counted_through_c; do
    counted $way 10
    counted $way 60
done | awk '{
    if (NF != 8 || $1 != $5 || $3 != $7) { print "overhead.sh: the steps were not the same, or not counted: " $0; exit 1 }
    rust = ($4 - $2) / 50
    c = ($8 - $6) / 50
    printf "a step in Rust: %.0f instructions; through C: %.0f more, %.4f %%\n", rust, c - rust, 100 * (c / rust - 1)
    exit !(c / rust <= 1.01)
}'
