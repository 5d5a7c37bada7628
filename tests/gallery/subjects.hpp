// The scenes of the failure gallery at sizes for tests, and the cells that a frame draws stand-ins of.
#pragma once

#include <algorithm>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "farfield/cost_model/measured_time.hpp"
#include "farfield/view/frustum.hpp"
#include "scenes/generate/gallery.hpp"
#include "support/pictures.hpp"
#include "support/random.hpp"
#include "support/variants.hpp"

namespace farfield::test {

struct Subject {
    std::string name;  ///< with the severity
    std::vector<Triangle> triangles;
    glm::dvec3 towards_viewer;
    bool is_opaque = false;

    /// Perspective, 0.9 radians; at a distance of 4 the unit ball takes half of the picture.
    View view(double distance, int size, float tolerance) const {
        return looking(towards_viewer * distance, {}, size, tolerance);
    }
    /// What perspective shows of the unit ball from far away.
    View orthographic_view(int size, float tolerance) const {
        return looking_orthographic(towards_viewer * 4.0, {}, 4, size, tolerance);
    }
};

/// Each scene of the gallery at these severities, but those that show a loss of contents: only tensors promise to keep
/// them, and errors.cpp holds them to it.
inline std::vector<Subject> subjects(std::uint32_t triangles, std::initializer_list<float> severities) {
    std::vector<Subject> out;
    for (const scenes::GalleryEntry& entry : scenes::gallery()) {
        if (entry.failure == "loss") continue;
        for (const float severity : severities) {
            scenes::GalleryScene s = scenes::make_gallery(entry.name, severity, triangles);
            std::string name = s.name + " " + std::to_string(severity).substr(0, 4);
            out.push_back({std::move(name), std::move(s.triangles), glm::dvec3(s.towards_viewer), s.is_opaque});
        }
    }
    return out;
}

/// All variants, but of those that cut polygons, which takes long, clusters of one size and one cost model: none says
/// where they cut.
inline const std::vector<Variant>& gallery_variants() {
    static const std::vector<Variant> some = [] {
        std::vector<Variant> v = all_variants();
        std::erase_if(v, [](const Variant& one) {
            return one.is_clipped && (one.name.find(MeasuredTime::unit) != std::string::npos ||
                                      one.name.find("ColorCubeCluster<2>") != std::string::npos);
        });
        const std::vector<Variant> images = image_cache_variants();
        v.insert(v.end(), images.begin(), images.end());
        return v;
    }();
    return some;
}

/// Whether a picture is told by its view alone. Where images are kept it is not: cells are drawn by what they looked
/// like from somewhere else, displaced by up to the images' threshold, with the samples of then, beside cells that are
/// not. So such a picture is near to the plain loop's and never promised to equal it, what is drawn is not the cut, and
/// seams between cells may open by as much.
inline bool is_told_by_view(const Variant& variant) {
    return !variant.caches_images;
}

/// Whether cells are cubes: not where planes divide them, in gaps or along polygons.
inline bool has_cubes(const Variant& variant) {
    return variant.has_octants && !variant.is_clipped;
}

/// Clusters look at each of their cubes through a grid of two by two points. What is thinner than those lie apart is
/// lost or magnified by chance: twigs are first lost and then, at a lower tolerance, as thick as a cube. What does not
/// hold for these pairs is tested to fail, so that whoever mends it takes them out here.
/// Color cubes do the same, by four points, where the partition is a BSP: six faces are composited of octants alone, so
/// that of other cells each is looked at as a whole.
inline bool is_known_to_lose(const Variant& variant, const Subject& subject) {
    const char* loses = has_cubes(variant) ? "ColorCubeCluster" : "ColorCube";
    return variant.name.find(loses) != std::string::npos && subject.name.rfind("twigs", 0) == 0;
}

/// Pictures may be blank: twigs that are lost, see above; and slats, all at distances at which points hit or miss all
/// of them. What is left then is a face as narrow as a slat, for cells of BSPs are no cubes, and may pass between
/// samples.
inline bool is_known_to_vanish(const Variant& variant, const Subject& subject) {
    return !has_cubes(variant) && variant.name.find("ColorCube") != std::string::npos &&
           (subject.name.rfind("twigs", 0) == 0 || subject.name.rfind("slats", 0) == 0);
}

/// Tensors over slats about as far apart as cells are large: a cell holds one slat or two, and its rectangle lies on
/// the bright or on the dark side of the truth. One pixel may be worse than four, and from frame to frame an error may
/// turn into its opposite. So may it over a wall that lies in a plane of cells (seen: 0.0156 at a tolerance of 1,
/// 0.0117 at 4).
inline bool is_known_to_alternate(const Variant& variant, const Subject& subject) {
    return variant.name.find("OpacityTensor") != std::string::npos &&
           (subject.name.rfind("slats", 0) == 0 || subject.name == "wall 0.00");
}

/// Splats over the same slats lie as these do, one or two in a cell, and so err to either side from frame to frame,
/// too: seen 1.85 times the error, where that is 0.015 at most.
inline bool is_known_to_oppose(const Variant& variant, const Subject& subject) {
    return is_known_to_alternate(variant, subject) ||
           (variant.name.find("AreaSplat") != std::string::npos && subject.name.rfind("slats", 0) == 0);
}

/// Tensors in cells of BSPs over twigs: the sides of one twig come into cells of their own, and those at its back are
/// deposited too. The smaller the cells, the more: 1.2 to 1.5 times what twigs cover at a tolerance of 4, 1.5 to 1.75
/// at 1. The error may rise by a step of a channel, where half of one is allowed (of 24 pairs of seeds and partitions
/// 11 did so with the planes of polygons, too, that BSPs once preferred).
inline bool is_known_to_fall_apart(const Variant& variant, const Subject& subject) {
    return variant.is_clipped && variant.name.find("OpacityTensor") != std::string::npos &&
           subject.name.rfind("twigs", 0) == 0;
}

/// Errors of tensors have 32 steps: where one lies between two, the unit of length decides which it gets, and with
/// sheets most cells of a level have the same one.
inline bool is_known_to_tie(const Variant& variant, const Subject& subject) {
    return variant.is_shared && variant.name.find("OpacityTensor") != std::string::npos &&
           subject.name.rfind("sheets", 0) == 0;
}

/// Color cubes in cells of BSPs over a wall that no axis plane is parallel to: from frame to frame an error may come
/// near to its opposite (seen: 1.54 times the error at a tolerance of 4).
inline bool is_known_to_turn(const Variant& variant, const Subject& subject) {
    return variant.is_clipped && variant.name.find(", ColorCube,") != std::string::npos &&
           subject.name.rfind("wall", 0) == 0;
}

/// What a viewer holds against the tolerance.
inline float drawn_error_px(const AnyHierarchy& h, const NodeRef& node, const LocalView& view) {
    return h.error_px(std::size_t(node.stand_in), node.cell, view) *
           detail::error_of_replaced_levels(h.nodes()[node.index]);
}

/// As a viewer that nothing is hidden from decides: the contract of Viewer, over what all_nodes finds. By index into
/// stand_ins(), ascending.
inline std::vector<std::size_t> cut_of(const AnyHierarchy& h, const std::vector<NodeRef>& nodes,
                                       const LocalView& view) {
    std::vector<char> settled(h.nodes().size(), 0);
    std::vector<PlaneMask> masks(h.nodes().size(), all_planes);
    std::vector<std::size_t> cut;
    for (const NodeRef& node : nodes) {
        if (node.index != 0) {
            settled[node.index] = settled[node.parent];
            masks[node.index] = masks[node.parent];
        }
        if (settled[node.index]) continue;
        PlaneMask& mask = masks[node.index];
        if (mask != 0) mask = crossed_planes(view.planes, node.cell.bounds_center, node.cell.bounds_half, mask);
        if (mask == outside_a_plane) {
            settled[node.index] = 1;
            continue;
        }
        if (node.stand_in < 0 || !(view.tolerance_px > 0)) continue;
        if (drawn_error_px(h, node, view) > view.tolerance_px) continue;
        settled[node.index] = 1;
        cut.push_back(std::size_t(node.stand_in));
    }
    std::sort(cut.begin(), cut.end());
    return cut;
}

}  // namespace farfield::test
