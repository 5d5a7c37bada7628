#!/bin/sh
# What doxygen reads instead of a file, line by line. Of a header: what it declares in namespace farfield is put into the
# group that its folder, or its own name, says. Of a page: doxygen finds no picture behind "../".
case "$1" in
    *.md) exec sed 's|](\(\.\./\)*bench/figures/|](figures/|' "$1" ;;
esac
group="$(printf '%s' "$1" | sed -n 's|.*/include/farfield/\([a-z_]*\).*|\1|p')"
case "$group" in
    spatial_hierarchy) group=hierarchy ;;
    frame | merged_viewer) group=viewer ;;
    executor) group=build ;;
    drawables) group=renderer ;;
    primitive_source) group=primitive ;;
    image) group=view ;;
esac
exec sed -e "s|^namespace farfield {\$|& /** \\\\addtogroup $group */ /** @{ */|" \
    -e 's|^}  // namespace farfield$|/** @} */ &|' "$1"
