#include "variants.hpp"

namespace walkthrough {
namespace {

constexpr Variant table[] = {
    {"exact", "every triangle in the frustum; the reference", exact},
    {"color-cube", "adaptive octree, blended faces made from their children's (Chamberlain et al. 1996)", color_cube},
    {"color-cube-direct", "likewise, every cell drawn instead of made from its children", color_cube_direct},
#ifndef FARFIELD_FIRST_LOOK
    {"color-cube-shared", "likewise, triangles in every cell they touch as in the paper", color_cube_shared},
#endif
    {"color-cube-cluster", "adaptive octree, 4 x 4 x 4 cubes a cell (Chamberlain et al. 1995)", color_cube_cluster},
    {"color-cube-1995", "octree of uniform depth, opaque faces, distance is depth (Chamberlain et al. 1995)",
     color_cube_1995, farfield::DistanceMeasure::depth},
    {"opacity-tensor", "adaptive octree, projected area in any direction, drawn by the area law", opacity_tensor},
#ifndef FARFIELD_FIRST_LOOK
    {"sample-tree", "adaptive octree, samples of polygons, tensors for what they leave (Klein et al. 2002)",
     sample_tree},
    {"sample-tree-splats", "likewise, opaque splats in place of tensors, as in the paper", sample_tree_splats},
    {"sample-tree-sided", "likewise, tensors with a color for each side that things are seen from", sample_tree_sided},
    {"bsp", "binary space partition, strictly front to back (Fuchs et al. 1980, as Greene 1996 draws it)", bsp},
    {"octree-of-bsps", "octree of such partitions (Greene 1996, section 5.1)", octree_of_bsps},
    {"gap-bsp", "every triangle in the frustum, planes in gaps between things (Shade et al. 1996)", gap_bsp},
    {"image-cache", "images of cells, reused from frame to frame (Shade et al. 1996)", image_cache},
    {"image-cache-lod", "likewise, of what opacity-tensor draws", image_cache_lod},
#endif
};

}  // namespace

std::span<const Variant> variants() {
    return table;
}

const Variant* find_variant(std::string_view name) {
    for (const Variant& v : table) {
        if (v.name == name) return &v;
    }
    return nullptr;
}

}  // namespace walkthrough
