# Sourced by scripts/test. prepare_readers [install] looks for the programs with which the tests read atlases and open the
# explorer's page, and installs missing ones only on request. It never fails: the tests of a missing program are skipped, or
# fail in CI.

readers_packages=(netcdf-bin cdo nco r-cran-ncdf4 octave-netcdf gdal-bin udunits-bin libnetcdf-dev gcc libc6-dev chromium firefox-esr)
readers_commands=(ncdump cdo ncwa Rscript octave-cli gdalmdiminfo udunits2 nc-config cc chromium firefox-esr)

prepare_readers() {
    local missing=() each log=$checkout/.venv/eulerdisk-readers.log
    if command -v dpkg-query >/dev/null && command -v apt-get >/dev/null; then
        for each in "${readers_packages[@]}"; do
            [ "$(dpkg-query -W -f '${db:Status-Status}' "$each" 2>/dev/null)" = installed ] || missing+=("$each")
        done
        [ ${#missing[@]} -eq 0 ] && return
        if [ "${1:-}" = install ]; then
            echo "Installing a browser and programs that read netCDF, for the tests (takes minutes, only once) ..." >&2
            install_readers "${missing[@]}" >"$log" 2>&1 && return
            echo "The installation failed, see $log." >&2
        fi
        echo "Tests with some readers of netCDF or a browser are skipped. To install these: scripts/test --readers, or" >&2
        echo "    sudo apt-get install --no-install-recommends ${missing[*]}" >&2
    else
        for each in "${readers_commands[@]}"; do
            command -v "$each" >/dev/null || missing+=("$each")
        done
        [ ${#missing[@]} -eq 0 ] || echo "Tests with some readers of netCDF or a browser are skipped: no ${missing[*]}." >&2
    fi
}

install_readers() {
    local command=(env DEBIAN_FRONTEND=noninteractive apt-get -q -y)
    command+=(-o Acquire::Retries=1 -o Acquire::http::Timeout=20 -o DPkg::Lock::Timeout=60)
    if [ "$(id -u)" != 0 ]; then
        # a person can type a password, CI cannot
        if [ "${CI:-}" = true ]; then command=(sudo -n "${command[@]}"); else command=(sudo "${command[@]}"); fi
    fi
    # A new machine has no list of packages, and an old list names versions that no longer exist. If no list can be fetched,
    # the existing one may be sufficient.
    "${command[@]}" update
    "${command[@]}" install --no-install-recommends "$@" || return
    # the headless browser, which tests prefer where it is packaged
    "${command[@]}" install --no-install-recommends chromium-headless-shell || true
}
