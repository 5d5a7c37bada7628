#!/usr/bin/env bash
# Builds the viewer and opens its window, on a bare Debian 12 with a display: installs what is missing. From any
# directory:
#
#   examples/view.sh [VIEWER-ARGUMENT...]     as in: examples/view.sh quadrupled-forest, or a file of your own
#
# Environment: as for run.sh.
set -euo pipefail

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
source "$repository/.ci/packages.sh"

farfield_install "${farfield_packages[@]}" "${farfield_viewer_packages[@]}"
build="${BUILD_DIR:-$repository/build/examples${CXX:+-${CXX##*/}}}"
farfield_configure "$repository" "$build" -DCMAKE_BUILD_TYPE=Release -DFARFIELD_FIRST_LOOK=OFF \
    -DFARFIELD_BUILD_TESTS=OFF -DFARFIELD_BUILD_EXAMPLES=ON -DFARFIELD_BUILD_BENCH=OFF
cmake --build "$build" --parallel "${JOBS:-$(nproc)}" --target viewer
exec "$build/bin/viewer" "$@"
