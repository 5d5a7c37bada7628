#!/usr/bin/env bash
# Builds and runs the tests, on a bare Debian 12 too: installs what is missing. From any directory:
#
#   tests/run.sh [CMAKE-ARGUMENT...]     as in: CXX=clang++ tests/run.sh -DFARFIELD_SANITIZE=ON
#
# Environment: BUILD_DIR (default: build/tests in the repository, build/tests-COMPILER with CXX), CXX, JOBS (default: one
# a processor), FARFIELD_SKIP_PACKAGES=1 to install nothing.
set -euo pipefail

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
source "$repository/.ci/packages.sh"

farfield_install "${farfield_packages[@]}"
build="${BUILD_DIR:-$repository/build/tests${CXX:+-${CXX##*/}}}"
jobs="${JOBS:-$(nproc)}"

farfield_configure "$repository" "$build" \
    -DFARFIELD_BUILD_TESTS=ON -DFARFIELD_BUILD_EXAMPLES=OFF -DFARFIELD_BUILD_BENCH=OFF "$@"
cmake --build "$build" --parallel "$jobs"
# From within: --test-dir would change what a relative BUILD_DIR means for the tests. No tests is an error.
cd "$build"
ctest --no-tests=error --output-on-failure --parallel "$jobs"
