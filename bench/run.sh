#!/usr/bin/env bash
# Builds the chart of speed against accuracy and draws it, on a bare Debian 12 too: installs what is missing. From any
# directory:
#
#   bench/run.sh [CHART-ARGUMENT...]     as in: bench/run.sh --quick
#
# Up to 15 minutes, 2 with --quick; Ctrl-C draws what there is by then. Ends with the table at equal error and the page to
# open in a browser, out/chart/index.html, which needs no network and shows every point and its picture. Arguments go to the program; --help says what
# there is. Environment: BUILD_DIR (default: build/bench in the repository), CXX, JOBS (default: one a processor),
# FARFIELD_SKIP_PACKAGES=1 to install nothing.
set -euo pipefail

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
source "$repository/.ci/packages.sh"

farfield_install "${farfield_packages[@]}" "${farfield_chart_packages[@]}"
build="${BUILD_DIR:-$repository/build/bench${CXX:+-${CXX##*/}}}"

farfield_configure "$repository" "$build" -DCMAKE_BUILD_TYPE=Release \
    -DFARFIELD_BUILD_TESTS=OFF -DFARFIELD_BUILD_EXAMPLES=OFF -DFARFIELD_BUILD_BENCH=ON
cmake --build "$build" --parallel "${JOBS:-$(nproc)}" --target bench_chart

# Of options given twice the last counts.
exec "$build/bin/bench_chart" --out "$repository/out/chart" "$@"
