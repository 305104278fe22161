#!/usr/bin/env bash
# Builds the wheel and tests it in an environment of its own: ./check.sh [--module FILE] [--notebooks] [--verify]. PYTHON names the interpreter,
# python3 by default. --module tests a module that is built (lib_rhexis.so of a build of the workspace) instead of a wheel. --notebooks runs the
# tutorial too. --verify takes the wheel with the feature `verify`, a minute more.
set -euo pipefail
module='' notebooks=false features=()
while [ $# -gt 0 ]; do
    case $1 in
        --module) module=$(realpath "${2:?--module needs the path of the built module}") && shift ;;
        --notebooks) notebooks=true ;;
        --verify) features=(--features verify) ;;
        *)
            echo "check.sh: no option $1: --module FILE, --notebooks or --verify" >&2
            exit 2
            ;;
    esac
    shift
done
cd "$(dirname "$0")"
root=$(cd ../.. && pwd)

missing() {
    echo "check.sh: $1" >&2
    exit 1
}
python=${PYTHON:-python3}
command -v cargo >/dev/null 2>&1 || missing "cargo is not on the PATH: install a Rust toolchain (see rust-version in Cargo.toml)"
command -v "$python" >/dev/null 2>&1 || missing "$python is not there: install python3 (3.10 or newer), or set PYTHON"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' || missing "$python is older than 3.10: set PYTHON to a newer one"
"$python" -c 'import ensurepip, venv' >/dev/null 2>&1 || missing "$python makes no environments: install python3-venv"

export CARGO_TARGET_DIR=${CARGO_TARGET_DIR:-$root/target}
# Nobody debugs what is built here; nor is it built as one unit.
export CARGO_PROFILE_RELEASE_DEBUG=false CARGO_PROFILE_RELEASE_LTO=off

started=$SECONDS
told() {
    echo "-- $1: after $((SECONDS - started)) s"
}

venv=$CARGO_TARGET_DIR/python-venv
[ -x "$venv/bin/python" ] || "$python" -m venv "$venv"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --upgrade "maturin>=1.7,<2" \
    "numpy>=1.24" "cma>=4" "gymnasium>=1.0" "ipykernel>=6" "matplotlib>=3.7" "meshio>=5" "mypy>=1.10" "nbclient>=0.9" "nbformat>=5" \
    "pytest>=8" "tqdm>=4" || missing "pip cannot install what is needed: is the package index reachable?"
told "environment"

"$venv/bin/python" -m pip uninstall --quiet --disable-pip-version-check --yes rhexis
packages=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_path("purelib"))')
rm -rf "$packages/rhexis"
if [ -n "$module" ]; then
    cp -r python/rhexis "$packages/rhexis"
    cp "$module" "$packages/rhexis/_rhexis.abi3.so"
    told "module"
else
    wheels=$CARGO_TARGET_DIR/wheels
    rm -rf "$wheels"
    "$venv/bin/maturin" build --release --locked --quiet ${features[@]+"${features[@]}"} --interpreter "$venv/bin/python" --out "$wheels"
    "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall "$wheels"/rhexis-*.whl
    told "wheel"
fi

# The stubs say what the module has, and the rest follows them.
"$venv/bin/python" -m mypy.stubtest rhexis --mypy-config-file pyproject.toml --allowlist tests/stubtest.txt
"$venv/bin/python" -m mypy
told "types"

left_out=(--ignore tests/test_tutorial.py)
if $notebooks; then left_out=(); fi
MPLBACKEND=agg "$venv/bin/python" -m pytest -q --durations=5 ${left_out[@]+"${left_out[@]}"} "${PYTEST_ARGS:-tests}"
told "tests"
