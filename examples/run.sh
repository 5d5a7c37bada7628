#!/usr/bin/env bash
# Builds the walkthrough and shows what a far field is worth, on a bare Debian 12 too: installs what is missing. First a
# flight down to a forest of 859 million triangles, then one over an island. From any directory:
#
#   examples/run.sh [WALKTHROUGH-ARGUMENT...]     as in: examples/run.sh --scene molecule --frames 30
#
# With arguments only that is drawn, by default the island with opacity tensors; one that is given twice counts as its
# last. Environment: BUILD_DIR (default: build/examples in the repository), CXX, JOBS (default: one a processor),
# FARFIELD_SKIP_PACKAGES=1 to install nothing.
set -euo pipefail

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
source "$repository/.ci/packages.sh"

out="$repository/out"
# Whoever asks for something may ask for any variant and renderer, of which not all are shown unasked.
first_look=$([[ $# -gt 0 ]] && echo OFF || echo ON)
farfield_build_example "$repository" walkthrough
echo "built in $SECONDS s"

# draw SCENE VARIANTS WALKTHROUGH-ARGUMENT...
draw() {
    mkdir -p "$out/$1"
    echo
    "$build/bin/walkthrough" --scene "$1" --variant "$2" --out "$out/$1" --json "$out/$1/report.json" "${@:3}"
}

if [[ $# -gt 0 ]]; then
    draw island opacity-tensor "$@"
    exit
fi
draw quadrupled-forest opacity-tensor --frames 24
draw island opacity-tensor,color-cube,color-cube-cluster --frames 24
echo
echo "exact | with stand-ins | what is drawn how (gray: triangles; tinted by level: stand-ins):"
for picture in "$out"/{quadrupled-forest,island}/*_opacity-tensor_frame000_side_by_side.png; do
    [[ -f "$picture" ]] && echo "    $picture"
done
echo "all of it in $SECONDS s"
