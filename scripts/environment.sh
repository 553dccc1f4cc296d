# Sourced by the scripts in this folder. Sets `checkout` (the project's folder) and `python` (the interpreter of its virtual
# environment); prepare_environment [GROUP] prepares that environment, optionally with a dependency group of pyproject.toml.
# Runs in bash 3.2 and later.

checkout=$(CDPATH='' cd -- "$(dirname -- "${BASH_SOURCE[0]}")/.." && pwd -P) || exit 1
python=$checkout/.venv/bin/python
# State of the environment: "ready GROUP FINGERPRINT", or "making" until it is complete.
# Without this file, the environment was created by the user: the project is installed into it, and it is replaced only if its
# Python does not run. An environment created here is also replaced if its Python is too old.
state_file=$checkout/.venv/eulerdisk-state

prepare_environment() {
    local group=${1:-none} state
    state=$(cat "$state_file" 2>/dev/null)
    is_ready "$group" "$state" && return

    echo "Setting up $checkout/.venv (takes minutes, only once) ..." >&2
    if [ "$state" = making ] || ! "$python" -c '' 2>/dev/null || { [ -n "$state" ] && ! is_usable "$python"; }; then
        make_environment || exit
    else
        rm -f -- "$state_file"
        "$python" -m pip --version >/dev/null 2>&1 || "$python" -m ensurepip >/dev/null || exit
    fi
    install_project "$group" || exit
    printf 'ready %s %s\n' "$group" "$(fingerprint)" >"$state_file"
}

# An environment with the group test also serves a script that needs no group.
is_ready() {
    local group=$1 state=$2 now
    now=$(fingerprint 2>/dev/null) || return
    [ "$state" = "ready $group $now" ] || [ "$state" = "ready test $now" ]
}

# Changes whenever the project must be installed again; includes the folder, because an editable install points there.
fingerprint() {
    "$python" -c '
import hashlib, pathlib, platform, sys
project = pathlib.Path(sys.argv[1])
print(hashlib.sha256((project / "pyproject.toml").read_bytes()).hexdigest(), platform.python_version(), project)
' "$checkout"
}

make_environment() {
    local base
    base=$(find_python) || return
    rm -rf -- "$checkout/.venv"
    mkdir -- "$checkout/.venv" && echo making >"$state_file" || return
    "$base" -m venv "$checkout/.venv" && return
    echo "The virtual environment $checkout/.venv could not be created with $base; see above." >&2
    return 1
}

# Runs the Python instead of only looking for it: a version manager's placeholder exists but fails.
is_usable() {
    "$1" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 13))' >/dev/null 2>&1
}

find_python() {
    local candidate candidates=(python3.14 python3.13 python3 "${HOME:-}"/.pyenv/versions/3.1[3-9]*/bin/python3)
    [ -z "${PYTHON:-}" ] || candidates=("$PYTHON")
    for candidate in "${candidates[@]}"; do
        # the last pattern finds pyenv's versions that are not active
        if is_usable "$candidate"; then
            printf '%s\n' "$candidate"
            return
        fi
    done
    {
        echo "No usable Python found. The project needs Python 3.13 or newer, with its venv and pip modules."
        echo "Tried: ${candidates[*]}."
        echo "Install one (on Debian and Ubuntu, venv is in the separate package python3-venv), or name one:"
        echo "    PYTHON=/path/to/python3 $0"
    } >&2
    return 2
}

install_project() {
    local log=$checkout/.venv/eulerdisk-install.log
    install_with_pip "$1" >"$log" 2>&1 && return
    cat -- "$log" >&2
    echo "The install into $checkout/.venv failed; pip's messages are above. Fix the cause and run the command again." >&2
    return 1
}

install_with_pip() {
    local install=("$python" -m pip install --quiet --disable-pip-version-check --no-input)
    if [ "$1" = none ]; then
        "${install[@]}" --editable "$checkout"
        return
    fi
    # Dependency groups need pip 25.1; the venv of Python 3.13 and older contains an older one.
    "$python" -m pip install --help | grep -q -e --group || "${install[@]}" --upgrade "pip>=25.1" || return
    "${install[@]}" --editable "$checkout" --group "$checkout/pyproject.toml:$1"
}
