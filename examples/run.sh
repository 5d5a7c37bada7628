#!/usr/bin/env bash
# Builds the examples and draws the island with every variant, on a bare Debian 12 too: installs what is missing. From
# any directory:
#
#   examples/run.sh [WALKTHROUGH-ARGUMENT...]     as in: examples/run.sh --size 640x360 --frames 30
#
# Arguments go to the walkthrough after those below; one that is given twice counts as its last. Environment: BUILD_DIR
# (default: build/examples in the repository), CXX, JOBS (default: one a processor), FARFIELD_SKIP_PACKAGES=1 to install
# nothing.
set -euo pipefail

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
source "$repository/.ci/packages.sh"

farfield_install "${farfield_packages[@]}"
build="${BUILD_DIR:-$repository/build/examples${CXX:+-${CXX##*/}}}"
out="$repository/out/island"

farfield_configure "$repository" "$build" -DCMAKE_BUILD_TYPE=Release \
    -DFARFIELD_BUILD_TESTS=OFF -DFARFIELD_BUILD_EXAMPLES=ON -DFARFIELD_BUILD_BENCH=OFF
cmake --build "$build" --parallel "${JOBS:-$(nproc)}"

mkdir -p "$out"
"$build/bin/walkthrough" --scene island --variant all --out "$out" --json "$out/report.json" "$@"
echo "images: $out"
echo "table:  $out/report.json"
