#!/usr/bin/env bash
# Draws scenes x variants x renderers with two builds of the walkthrough and compares every picture byte for byte: what a
# rearrangement must not change. Takes a quarter of an hour; no test runs it.
#
#   tests/promises/same_pictures.sh OLD_WALKTHROUGH NEW_WALKTHROUGH [DIRECTORY]
#
# Environment: SCENES, names and files with blanks between them. Pictures of the old build that lie in DIRECTORY
# (default: a temporary one) are taken as they are.
set -euo pipefail

[[ $# -ge 2 ]] || { sed -n '2,/^set/s/^# \{0,1\}//p' "$0" | sed '$d' >&2; exit 2; }
old="$1" new="$2" directory="${3:-$(mktemp -d)}"
read -r -a scenes <<<"${SCENES:-tree molecule island building chessboard cube}"
renderers=("z-buffer 1" "z-buffer 4" "coverage 1" "coverage 64" "hierarchical-z 1" "painter 4")
differing=0 compared=0

# draw WALKTHROUGH OUT SCENE RENDERER SAMPLES TOLERANCE ARGUMENT...
draw() {
    local walkthrough="$1" out="$2" variants=all
    [[ "$4" != painter ]] || variants=bsp,octree-of-bsps
    "$walkthrough" --scene "$3" --variant "$variants" --renderer "$4" --samples "$5" --tolerance "$6" --size 160x120 \
        --frames 2 --out "$out" "${@:7}" >"$out.txt" 2>&1 || echo "refused by $walkthrough: $(tail -n 1 "$out.txt")"
}

for scene in "${scenes[@]}"; do
    for renderer in "${renderers[@]}"; do
        for place in "flight 2" "far 1 --distance 5 --angle 20"; do
            read -r name tolerance arguments <<<"$place"
            read -r renderer_name samples <<<"$renderer"
            case="${scene##*/}-$renderer_name-$samples-$name"
            for build in old new; do
                out="$directory/$build/$case"
                [[ $build == new || ! -d "$out" ]] || continue
                mkdir -p "$out"
                # shellcheck disable=SC2086
                draw "${!build}" "$out" "$scene" "$renderer_name" "$samples" "$tolerance" $arguments
            done
            while IFS= read -r -d '' picture; do
                compared=$((compared + 1))
                cmp -s "$picture" "$directory/new/$case/${picture##*/}" || {
                    echo "differs: $case/${picture##*/}"
                    differing=$((differing + 1))
                }
            done < <(find "$directory/old/$case" -name '*.png' -print0)
        done
    done
done
echo "$compared pictures compared, $differing differ ($directory)"
[[ $differing == 0 && $compared != 0 ]]
