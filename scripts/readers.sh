# Sourced by scripts/test. prepare_readers sees to the programs with which tests/promises/test_readers.py reads the atlases. It
# never fails: where nothing can be installed it says what is missing, and those tests are skipped (in CI they fail).

readers_packages=(netcdf-bin cdo nco r-cran-ncdf4 octave-netcdf gdal-bin udunits-bin libnetcdf-dev gcc libc6-dev)
readers_commands=(ncdump cdo ncwa Rscript octave-cli gdalmdiminfo udunits2 nc-config cc)

prepare_readers() {
    local missing=() each log=$checkout/.venv/eulerdisk-readers.log as_root=()
    if command -v dpkg-query >/dev/null && command -v apt-get >/dev/null; then
        for each in "${readers_packages[@]}"; do
            [ "$(dpkg-query -W -f '${db:Status-Status}' "$each" 2>/dev/null)" = installed ] || missing+=("$each")
        done
        [ ${#missing[@]} -eq 0 ] && return
        [ "$(id -u)" = 0 ] || as_root=(sudo -n)
        if [ "$(id -u)" = 0 ] || { [ "${CI:-}" = true ] && sudo -n true 2>/dev/null; }; then
            echo "Installing programs that read netCDF, for the tests (a minute or two, once) ..." >&2
            install_readers >"$log" 2>&1 && return
            echo "That failed, see $log." >&2
        fi
        echo "Tests with some readers of netCDF are skipped. To have them:" >&2
        echo "    sudo apt-get install --no-install-recommends ${missing[*]}" >&2
    else
        for each in "${readers_commands[@]}"; do
            command -v "$each" >/dev/null || missing+=("$each")
        done
        [ ${#missing[@]} -eq 0 ] || echo "Tests with some readers of netCDF are skipped: no ${missing[*]}." >&2
    fi
}

# The second try is for a machine that has not yet any list of packages.
install_readers() {
    local options=(-q -y -o Acquire::Retries=1 -o Acquire::http::Timeout=20 -o DPkg::Lock::Timeout=60)
    local command=(env DEBIAN_FRONTEND=noninteractive apt-get "${options[@]}")
    "${as_root[@]}" "${command[@]}" install --no-install-recommends "${missing[@]}" && return
    "${as_root[@]}" "${command[@]}" update &&
        "${as_root[@]}" "${command[@]}" install --no-install-recommends "${missing[@]}"
}
