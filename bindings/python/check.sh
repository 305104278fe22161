#!/usr/bin/env bash
# Builds the wheel and tests it in an environment of its own: ./check.sh [--lint] [--verify]. PYTHON names the interpreter, python3 by default.
# --lint adds clippy, which compiles the engine a second time and a third. --verify takes the wheel with the feature `verify`, a minute more.
set -euo pipefail
lint=false features=()
for option in "$@"; do
    case $option in
        --lint) lint=true ;;
        --verify) features=(--features verify) ;;
        *)
            echo "check.sh: no option $option: --lint or --verify" >&2
            exit 2
            ;;
    esac
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

cargo fmt --check
wheels=$CARGO_TARGET_DIR/wheels
rm -rf "$wheels"
"$venv/bin/maturin" build --release --locked --quiet ${features[@]+"${features[@]}"} --interpreter "$venv/bin/python" --out "$wheels"
"$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-deps --force-reinstall "$wheels"/rhexis-*.whl
told "wheel"

# The stubs say what the module has, and the rest follows them.
"$venv/bin/python" -m mypy.stubtest rhexis --mypy-config-file pyproject.toml --allowlist tests/stubtest.txt
"$venv/bin/python" -m mypy
told "types"

MPLBACKEND=agg "$venv/bin/python" -m pytest -q --durations=5 "${PYTEST_ARGS:-tests}"
told "tests"

if $lint; then
    cargo clippy --release --locked --all-targets -- -D warnings
    cargo clippy --release --locked --all-targets --features verify -- -D warnings
    told "lints"
fi
