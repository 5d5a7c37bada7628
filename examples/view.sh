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

farfield_build_example "$repository" viewer "${farfield_viewer_packages[@]}"
exec "$build/bin/viewer" "$@"
