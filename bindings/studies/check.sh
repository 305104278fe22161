#!/usr/bin/env bash
# Installs the package into an environment of its own and tests it: check.sh PATH_OF_RHEXIS. Two minutes at the most.
set -euo pipefail
program=${1:-${RHEXIS:-}}
if [[ -z $program || ! -x $program ]]; then
    echo "name the built program: $0 target/release/rhexis" >&2
    exit 1
fi
RHEXIS=$(cd "$(dirname "$program")" && pwd)/$(basename "$program")
export RHEXIS
cd "$(dirname "$0")"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
# Built from a copy: nothing is left in the source tree.
cp -r pyproject.toml README.md rhexis_studies tests "$folder"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check "$folder[test]"
cd "$folder"
rm -r rhexis_studies build ./*.egg-info 2>/dev/null || true
venv/bin/python -m pytest -q -p no:cacheprovider tests
