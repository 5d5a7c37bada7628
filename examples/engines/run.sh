#!/usr/bin/env bash
# Builds the forest in an engine and draws it in four ways, on a bare Debian 12 too: installs what is missing. Where there
# is no display it takes one that nobody sees. From any directory:
#
#   examples/engines/run.sh osg|ogre [ARGUMENT...]     as in: examples/engines/run.sh osg --trees 40 --tolerance 2
#
# Environment: as for examples/run.sh.
set -euo pipefail

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
source "$repository/.ci/packages.sh"

engine="${1:-}"
[[ "$engine" == osg || "$engine" == ogre ]] || farfield_fail "say which engine: osg or ogre"
shift
declare -n packages="farfield_${engine}_packages"
first_look=ON
farfield_build_example "$repository" "${engine}_forest" "${packages[@]}"
out="$repository/out/$engine"
mkdir -p "$out"
display=()
[[ -n "${DISPLAY:-}" ]] || display=(xvfb-run -a -s "-screen 0 640x480x24 -nolisten tcp")
"${display[@]}" "$build/bin/${engine}_forest" --out "$out" "$@"
echo "pictures are in $out; side by side: at 64 samples a pixel, then in the table's order"
