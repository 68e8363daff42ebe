# What scripts/test and scripts/check share: paths, the required programs, and steps whose times are printed at the end.
# To be sourced from the top directory.
exec </dev/null
root=$PWD
target=${CARGO_TARGET_DIR:-target}
[[ $target == /* ]] || target=$root/$target
scratch=$target/check
venv=$target/venv/bin
python=${PYTHON:-python3}
programs=$target/debug
export CARGO_TERM_PROGRESS_WHEN=never PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_INPUT=1
# Line numbers of backtraces take a tenth of the time to compile.
export CARGO_PROFILE_DEV_DEBUG=false
# Incremental compilation makes a first build slower, and a change of this setting builds all again.
export CARGO_INCREMENTAL=0
# One selection of packages and features for all tests, so that each dependency is compiled once. The module for Python is in
# it, although it has no Rust tests, and is built with the features of the others: so the wheel reuses their builds. The benches
# reuse them too, and are left out because scripts/test does not need their packages. The bridge to Rapier is left out because
# Rapier asks for features of common packages, which would be compiled twice for the wheel.
tested=(--locked --all-features --workspace --exclude supple-benches --exclude supple-rapier)
export MATURIN_PEP517_ARGS="--locked --profile dev --features supple/default,supple/internals,supple-io/default"

current="required programs"
began=$SECONDS
times=()

finish_step() { times+=("$(printf '%5d s  %s' $((SECONDS - began)) "$current")"); }

step() {
    finish_step
    current=$1 began=$SECONDS
    printf '\n==> %s\n' "$current"
}

finish() {
    finish_step
    printf '\n==> all passed\n'
    printf '%s\n' "${times[@]}"
    printf '%5d s  in all\n' "$SECONDS"
}

# Prints the step that failed, if the exit status is not 0.
on_exit() {
    local status=$?
    if ((status != 0)); then printf '\n==> FAILED (exit %d) in: %s\n' "$status" "$current" >&2; fi
}
trap on_exit EXIT

fail() {
    printf '%s\n' "$1" >&2
    exit 1
}

# Builds the wheel and installs it, with the packages that tests and checks need, into an environment of its own.
install_module() {
    rm -rf "$target/wheels"
    "$python" -m venv --clear "$target/venv"
    "$venv/pip" wheel --quiet --no-deps --wheel-dir "$target/wheels" .
    wheel=$(echo "$target"/wheels/*.whl)
    "$venv/pip" install --quiet "$wheel"
}

command -v cargo >/dev/null || fail "cargo is not installed; install Rust with rustup"
command -v "$python" >/dev/null || fail "$python is not installed; install Python 3.10 or newer, or set PYTHON to its path"
"$python" -c 'import sys; sys.exit(sys.version_info < (3, 10))' ||
    fail "$("$python" --version) is too old: Python 3.10 or newer is required; set PYTHON to the path of a newer interpreter"
"$python" -c 'import venv, ensurepip' 2>/dev/null ||
    fail "$python lacks venv; install it (on Debian the package python3-venv)"
cargo --version
"$python" --version
