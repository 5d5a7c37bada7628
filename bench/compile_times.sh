#!/usr/bin/env bash
# What a list of variants costs to compile (include/farfield/tuning/README.md): processor seconds and memory of a file
# that builds and draws with each, by their number; of the file that holds the list where measurements are declared
# only; and of one that instantiates one of them. On a quiet machine, from any directory:
#
#   bench/compile_times.sh [OPTION...]     options of the compiler, by default -O2. Environment: CXX
set -euo pipefail

repository="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
directory="$(mktemp -d)"
trap 'rm -r "$directory"' EXIT

cat > "$directory/experiment.hpp" <<'END'
#include <cstddef>
#include <tuple>
#include <vector>

#include "farfield/approximation/color_cube.hpp"
#include "farfield/approximation/color_cube_cluster.hpp"
#include "farfield/approximation/exact.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/cost_model/triangle_count.hpp"
#include "farfield/partition/octree.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/tuning/variants.hpp"
using namespace farfield;
template <class Variant>
std::size_t measure(const Variant&, const std::vector<Triangle>&);
END
cat > "$directory/experiment_of.hpp" <<'END'
#include "experiment.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
template <class Variant>
std::size_t measure(const Variant& variant, const std::vector<Triangle>& scene) {
    ZBufferRenderer renderer;
    const auto hierarchy = variant.build(scene);
    auto viewer = make_viewer(hierarchy, scene, renderer);
    return std::size_t(viewer.frame({.camera = Camera::perspective({5, 5, 30}, {5, 5, 0}, {0, 1, 0}, 0.8f)}).primitives);
}
END
# list HEADER PARTITIONS APPROXIMATIONS COST-MODELS
list() {
    cat <<END
#include "$1"
int main() {
    const std::vector<Triangle> scene(100);
    const auto variants = variants_of(std::tuple{$2}, std::tuple{$3}, std::tuple{$4});
    std::size_t sum = 0;
    for_each_variant(variants, [&](const auto& variant) { sum += measure(variant, scene); });
    return int(sum);
}
END
}
# row NAME FILE [OPTION...]
row() {
    local used
    used="$({ /usr/bin/time -f '%U %M' "${CXX:-g++}" -std=c++20 "${@:3}" "-I$repository/include" -c "$directory/$2" \
        -o "$directory/object.o"; } 2>&1)" || { echo "$used" >&2; exit 1; }
    echo "| $1 | ${used% *} | $((${used#* } / 1024)) |"
}

octree='Named{"", Octree{}}'
both="$octree, Named{\"shared\", SharedOctree{}}"
exact='Named{"exact", Exact{}}'
two="$exact, Named{\"cube\", ColorCube{}}"
four="$two, Named{\"tensor\", OpacityTensor{}}, Named{\"cluster\", ColorCubeCluster<2>{}}"
count='Named{"", TriangleCount{}}'
prices="$count, Named{\"time\", MeasuredTime{}}"
list experiment_of.hpp "$octree" "$exact" "$count" > "$directory/1.cpp"
list experiment_of.hpp "$octree" "$two" "$count" > "$directory/2.cpp"
list experiment_of.hpp "$octree" "$four" "$count" > "$directory/4.cpp"
list experiment_of.hpp "$octree" "$four" "$prices" > "$directory/8.cpp"
list experiment_of.hpp "$both" "$four" "$prices" > "$directory/16.cpp"
list experiment.hpp "$both" "$four" "$prices" > "$directory/list.cpp"
echo '#include "experiment_of.hpp"' > "$directory/0.cpp"
{
    echo '#include "experiment_of.hpp"'
    echo 'template std::size_t measure(const NamedVariant<Octree, OpacityTensor, TriangleCount>&,'
    echo '                             const std::vector<Triangle>&);'
} > "$directory/one.cpp"

[[ $# -gt 0 ]] || set -- -O2
echo "| $* | seconds | MiB |"
echo "|-|-|-|"
row "the headers alone" 0.cpp "$@"
for count in 1 2 4 8 16; do row "a file with $count of them" "$count.cpp" "$@"; done
row "the list of 16, where they are declared" list.cpp "$@"
row "a file that instantiates one, tensors" one.cpp "$@"
