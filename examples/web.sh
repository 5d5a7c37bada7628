#!/usr/bin/env bash
# Exports a scene as 3D Tiles and shows it in a browser, on a bare Debian 12 too: installs what is missing, prints an
# address, and serves until it is stopped. From any directory:
#
#   examples/web.sh [SCENE]      a scene of walkthrough --list, or a file of your own; the forest by default
#   examples/web.sh --check      looks at it in a headless browser, compares with our own pictures, and ends
#
# Environment: as for run.sh, and PORT (default: 8080), CHROMIUM (default: the one on the PATH).
set -euo pipefail

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
source "$repository/.ci/packages.sh"

checks=
scene=forest
for argument in "$@"; do
    case "$argument" in
    --check) checks=1 ;;
    -*) farfield_fail "there is no option $argument" ;;
    *) scene="$argument" ;;
    esac
done

packages=("${farfield_web_packages[@]}")
[[ -z "$checks" || -n "${CHROMIUM:-}" ]] || packages+=("${farfield_browser_packages[@]}")
command -v npm >/dev/null && command -v node >/dev/null || packages+=(npm)
farfield_install "${farfield_packages[@]}" "${packages[@]}"
build="${BUILD_DIR:-$repository/build/examples${CXX:+-${CXX##*/}}}"
farfield_configure "$repository" "$build" -DCMAKE_BUILD_TYPE=Release -DFARFIELD_FIRST_LOOK=ON \
    -DFARFIELD_BUILD_TESTS=OFF -DFARFIELD_BUILD_EXAMPLES=ON -DFARFIELD_BUILD_BENCH=OFF
cmake --build "$build" --parallel "${JOBS:-$(nproc)}" --target farfield_export --target farfield_compare

# What is served: the page, and a folder of tiles for each variant.
web="$build/web"
mkdir -p "$web"
cp "$repository/examples/web/package.json" "$repository/examples/web/index.html" "$web"
npm install --prefix "$web" --no-fund --no-audit --silent
NODE_PATH="$web/node_modules" "$web/node_modules/.bin/esbuild" "$repository/examples/web/page.js" --bundle --format=esm \
    --minify --log-level=warning --outfile="$web/page.js"
variants=(opacity-tensor color-cube sample-tree)
[[ "$scene" != *.farfield ]] || variants=(pages)
for variant in "${variants[@]}"; do
    rm -rf "${web:?}/$variant"
    echo "$scene, $variant:"
    if [[ "$variant" == pages ]]; then
        "$build/bin/farfield_export" "$scene" "$web/$variant"
    else
        "$build/bin/farfield_export" "$scene" "$web/$variant" --variant "$variant" ${checks:+--pictures}
    fi
done
printf '"%s"\n' "${variants[@]}" | paste -sd, | sed 's/.*/[&]/' >"$web/tilesets.json"

if [[ -n "$checks" ]]; then
    exec node "$repository/examples/web/check.mjs" "$web" "$build/bin/farfield_compare" \
        "${CHROMIUM:-$(command -v chromium)}"
fi
echo "open http://127.0.0.1:${PORT:-8080}/?tileset=${variants[0]} (end with Ctrl-C)"
exec python3 -m http.server --bind 127.0.0.1 --directory "$web" "${PORT:-8080}"
