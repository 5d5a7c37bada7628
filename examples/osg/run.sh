#!/usr/bin/env bash
# Builds the forest in OpenSceneGraph and draws it in four ways, on a bare Debian 12 too: installs what is missing. Where
# there is no display it takes one that nobody sees. From any directory:
#
#   examples/osg/run.sh [OSG_FOREST-ARGUMENT...]     as in: examples/osg/run.sh --trees 40 --tolerance 2
#
# Environment: as for examples/run.sh.
set -euo pipefail

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
source "$repository/.ci/packages.sh"

farfield_install "${farfield_packages[@]}" "${farfield_osg_packages[@]}"
build="${BUILD_DIR:-$repository/build/examples${CXX:+-${CXX##*/}}}"
farfield_configure "$repository" "$build" -DCMAKE_BUILD_TYPE=Release -DFARFIELD_FIRST_LOOK=ON \
    -DFARFIELD_BUILD_TESTS=OFF -DFARFIELD_BUILD_EXAMPLES=ON -DFARFIELD_BUILD_BENCH=OFF
cmake --build "$build" --parallel "${JOBS:-$(nproc)}" --target osg_forest
out="$repository/out/osg"
mkdir -p "$out"
display=()
[[ -n "${DISPLAY:-}" ]] || display=(xvfb-run -a -s "-screen 0 640x480x24 -nolisten tcp")
"${display[@]}" "$build/bin/osg_forest" --out "$out" "$@"
echo "pictures are in $out: at 64 samples a pixel | plain | LOD | Impostor | farfield"
