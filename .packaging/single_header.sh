#!/usr/bin/env bash
# usage: single_header.sh [HEADER [FILE]]
# Writes one file that holds all of a header, farfield/farfield.hpp if none is named, and of what it includes: for those
# who paste it into an online compiler. GLM and the standard library are still included. Without FILE it is printed.
set -euo pipefail
include="$(cd "$(dirname "${BASH_SOURCE[0]}")/../include" && pwd)"
header="${1:-farfield/farfield.hpp}"
[[ -f "$include/$header" ]] || { echo "single_header.sh: there is no $include/$header" >&2; exit 2; }
[[ $# -lt 2 ]] || exec >"$2"

# A header that is first met between #if and #endif is written there and again where it is included without a condition;
# so each has a guard. An .inl file has none: it is included several times on purpose, and written as often.
awk -v include="$include" -v first="$header" '
    function write_file(name, conditions,    path, line, guard, is_header, depth, other) {
        path = include "/" name
        is_header = name ~ /\.hpp$/
        if (is_header) {
            if (name in written) return
            if (conditions == 0) written[name] = 1
            guard = "FARFIELD_HOLDS_" toupper(name)
            gsub(/[^A-Z0-9]/, "_", guard)
            print "#ifndef " guard "\n#define " guard
        }
        depth = conditions
        while ((getline line < path) > 0) {
            if (line ~ /^[ \t]*#[ \t]*pragma once/) continue
            if (line ~ /^[ \t]*#[ \t]*if/) ++depth
            if (line ~ /^[ \t]*#[ \t]*endif/) --depth
            if (line ~ /^[ \t]*#[ \t]*include[ \t]+"farfield\//) {
                other = line
                sub(/^[^"]*"/, "", other)
                sub(/".*$/, "", other)
                write_file(other, depth)
                continue
            }
            print line
        }
        close(path)
        if (is_header) print "#endif"
    }
    BEGIN {
        print "// Made from " first " of farfield by .packaging/single_header.sh. MIT license; see the repository.\n#pragma once"
        write_file(first, 0)
    }'
