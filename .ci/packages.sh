# Sourced by all run.sh, examples/view.sh, examples/web.sh and .ci/run: what a bare Debian 12 needs.

farfield_packages=(g++ cmake make libglm-dev catch2 libbenchmark-dev zlib1g-dev libstb-dev libcli11-dev
    nlohmann-json3-dev libcurl4-openssl-dev)
# For bench/run.sh and .ci/run.
farfield_chart_packages=(gnuplot-nox)
# For examples/view.sh: a window and what draws in it, and OpenGL without a GPU.
farfield_viewer_packages=(libglfw3-dev libimgui-dev libepoxy-dev libegl-dev libegl-mesa0 libgl-dev libgl1-mesa-dri)
# For examples/osg and examples/ogre: an engine each, and a display that nobody sees.
farfield_osg_packages=(libopenscenegraph-dev libgl-dev libgl1-mesa-dri xvfb xauth)
farfield_ogre_packages=(libogre-1.12-dev libgl-dev libgl1-mesa-dri xvfb xauth)
# For examples/web.sh: a web server; and a browser for its --check (400 MB). It takes npm too, where there is none.
farfield_web_packages=(python3)
farfield_browser_packages=(chromium)
# For .ci/run: a second compiler, formatting, the reference; ccache makes the next run short.
farfield_check_packages=(clang libclang-rt-14-dev clang-format-14 doxygen ccache nginx-light libzstd-dev xvfb
    xdotool openmpi-bin libopenmpi-dev)
# For whoever wants others' renderers in bench_coverage_peers; nothing installs them unasked.
farfield_peer_packages=(libembree-dev libepoxy-dev libegl-dev libegl-mesa0 libgl1-mesa-dri)

farfield_fail() {
    echo "${0##*/}: $*" >&2
    exit 1
}

# farfield_install PACKAGE...: installs those that are missing, and asks for no rights if none is. On a machine without
# apt set FARFIELD_SKIP_PACKAGES=1 and see to them in another way: CMake says what it does not find.
farfield_install() {
    [[ -z "${FARFIELD_SKIP_PACKAGES:-}" ]] || return 0
    local package missing=() as_root=()
    command -v apt-get >/dev/null && command -v dpkg-query >/dev/null ||
        farfield_fail "no apt on this machine: install the like of '$*' and set FARFIELD_SKIP_PACKAGES=1"
    for package in "$@"; do
        [[ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" == installed ]] || missing+=("$package")
    done
    [[ ${#missing[@]} -gt 0 ]] || return 0
    if [[ "$(id -u)" != 0 ]]; then
        command -v sudo >/dev/null || farfield_fail "neither root nor sudo to install: ${missing[*]}"
        as_root=(sudo)
    fi
    as_root+=(env DEBIAN_FRONTEND=noninteractive)
    echo "installing ${missing[*]}"
    "${as_root[@]}" apt-get -qq update || farfield_fail "apt-get update failed"
    "${as_root[@]}" apt-get -qq install -y --no-install-recommends "${missing[@]}" >/dev/null ||
        farfield_fail "apt-get could not install: ${missing[*]}"
}

# farfield_build_example REPOSITORY TARGET PACKAGE...: builds a program of the examples, with what it needs installed,
# and sets `build` to where it was built.
farfield_build_example() {
    local repository="$1" target="$2"
    shift 2
    farfield_install "${farfield_packages[@]}" "$@"
    build="${BUILD_DIR:-$repository/build/examples${CXX:+-${CXX##*/}}}"
    farfield_configure "$repository" "$build" -DCMAKE_BUILD_TYPE=Release -DFARFIELD_FIRST_LOOK="${first_look:-OFF}" \
        -DFARFIELD_BUILD_TESTS=OFF -DFARFIELD_BUILD_EXAMPLES=ON -DFARFIELD_BUILD_BENCH=OFF
    cmake --build "$build" --parallel "${JOBS:-$(nproc)}" --target "$target"
}

# farfield_configure SOURCE BUILD CMAKE-ARGUMENT...: with the compiler in CXX, if it is set.
farfield_configure() {
    local source="$1" build="$2" cached
    shift 2
    if [[ -n "${CXX:-}" ]]; then
        command -v "$CXX" >/dev/null || farfield_fail "no such compiler: CXX=$CXX"
        # CMake keeps the first compiler of a build directory, and loses the arguments if it is told of another.
        if [[ -f "$build/CMakeCache.txt" ]]; then
            cached="$(sed -n 's/^CMAKE_CXX_COMPILER:[A-Z]*=//p' "$build/CMakeCache.txt")"
            [[ "$(readlink -f "$cached")" == "$(readlink -f "$(command -v "$CXX")")" ]] ||
                farfield_fail "$build was configured for $cached, not $CXX: remove it, or set BUILD_DIR"
        fi
    fi
    cmake -S "$source" -B "$build" "$@"
}
