// Every composable triple (triples.hpp) behind one interface, so that tests of what holds for all of them are compiled
// once and loop at run time. Over Triangle; each approximation is compiled in a file of its own, variants_*.cpp.
#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "farfield/composition.hpp"
#include "farfield/hierarchy/hierarchy_data.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/sampler/grid_sampler.hpp"
#include "farfield/tuning/sampled_error_table.hpp"
#include "farfield/view/local_view.hpp"
#include "support/recorder.hpp"

namespace farfield::test {

class AnyViewer {
  public:
    virtual ~AnyViewer() = default;
    virtual FrameStats frame(const View& view) = 0;

    bool caches_images = false;

    /// A frame. Where images are kept, some frames on the way come before it, so that they are drawn from where they
    /// were not made.
    FrameStats arrive(const View& view, int frames_before = 3) {
        for (int i = caches_images ? frames_before : 0; i > 0; --i) {
            View before = view;
            before.camera.eye += glm::dvec3(view.camera.right) * (2e-4 * double(i) * glm::length(view.camera.eye));
            frame(before);
        }
        return frame(view);
    }
    /// Frames of one view until images are made of all that is worth it.
    FrameStats settle(const View& view) {
        for (int i = caches_images ? 8 : 0; i > 0; --i) frame(view);
        return frame(view);
    }
};

/// A hierarchy and the primitives it was built from, which it borrows.
class AnyHierarchy {
  public:
    virtual ~AnyHierarchy() = default;
    virtual std::span<const Node> nodes() const = 0;
    virtual std::span<const std::uint32_t> order() const = 0;
    virtual const Fragments& fragments() const = 0;
    virtual std::uint32_t item_count() const = 0;
    virtual const BuildReport& report() const = 0;
    virtual const Box& bounds() const = 0;
    virtual const Cell& root_cell() const = 0;
    virtual Cell child(const Cell& cell, std::uint32_t node, unsigned child) const = 0;
    virtual void front_to_back(const Cell& cell, std::uint32_t node, glm::vec4 viewpoint, ChildOrder& order) const = 0;
    virtual std::size_t stand_in_count() const = 0;
    virtual bool root_has_stand_in() const = 0;
    /// By index into stand_ins().
    virtual float error_px(std::size_t stand_in, const Cell& cell, const LocalView& view) const = 0;
    virtual float least_error_px(const Cell& cell, unsigned levels, const LocalView& view) const = 0;
    virtual float cost_of(std::size_t stand_in) const = 0;
    virtual float cost(const Work& work) const = 0;
    /// Arrays that do not depend on the scene's scale: all but node data and vertices of fragments.
    virtual std::vector<std::byte> bytes() const = 0;
    /// What a table becomes that is saved with it to memory, and read for the hierarchy that is opened from there.
    virtual std::optional<SampledErrorTable> stored(const SampledErrorTable& table) const = 0;
    /// Saved to memory and opened from there, which it keeps.
    virtual std::unique_ptr<AnyHierarchy> stored() const = 0;
    virtual std::unique_ptr<AnyViewer> viewer(ZBufferRenderer& renderer) const = 0;
    virtual std::unique_ptr<AnyViewer> viewer(Recorder& renderer) const = 0;
    virtual std::unique_ptr<AnyViewer> viewer_of(std::span<const Triangle> other, Recorder& renderer) const = 0;

    Image picture(const View& view, const ZBufferOptions& options = {}) const {
        ZBufferRenderer renderer(options);
        viewer(renderer)->arrive(view);
        return renderer.image();
    }
    /// What a fresh viewer does in one frame.
    FrameStats frame(const View& view, Recorder& recorder) const { return viewer(recorder)->frame(view); }
};

struct Variant {
    std::string name;
    bool is_shared = false;
    bool is_clipped = false;
    bool stands_in = false;
    bool has_octants = false;    ///< children are octants of their cell
    bool caches_images = false;  ///< viewers draw cells by images that they made in other frames
    std::function<std::unique_ptr<AnyHierarchy>(std::span<const Triangle>, std::uint64_t memory_budget_bytes,
                                                const GridSampler&)>
        build_with;

    std::unique_ptr<AnyHierarchy> build(std::span<const Triangle> triangles, const GridSampler& sampler = {},
                                        std::uint64_t memory_budget_bytes = 0) const {
        return build_with(triangles, memory_budget_bytes, sampler);
    }

    /// Pixels of a picture without stand-ins that differ from the plain loop's: none, but that corners of fragments are
    /// snapped to 1/256 sample, and that their normals are those of what rounding left of them.
    bool is_plain(const Image& picture, const Image& plain) const {
        if (!is_clipped) return picture == plain;
        std::size_t different = 0;
        for (std::size_t i = 0; i < plain.pixels().size(); ++i) {
            const Rgba8 p = picture.pixels()[i], q = plain.pixels()[i];
            int largest = 0;
            for (const int d : {p.r - q.r, p.g - q.g, p.b - q.b, p.a - q.a}) largest = std::max(largest, std::abs(d));
            different += largest > 2;
        }
        return picture.width() == plain.width() && 100 * different <= plain.pixels().size();
    }
};

/// Composable triples by approximation; defined in variants_*.cpp.
std::vector<Variant> exact_variants();
std::vector<Variant> color_cube_variants();
std::vector<Variant> cluster_of_two_variants();
std::vector<Variant> cluster_of_four_variants();
std::vector<Variant> opacity_tensor_variants();
std::vector<Variant> sample_set_variants();
/// With planes in gaps. No file holds their hierarchies, which are those of what the images show: they are not among
/// all_variants().
std::vector<Variant> image_cache_variants();

inline const std::vector<Variant>& all_variants() {
    static const std::vector<Variant> all = [] {
        std::vector<Variant> v;
        for (const auto& family : {exact_variants(), color_cube_variants(), cluster_of_two_variants(),
                                   cluster_of_four_variants(), opacity_tensor_variants(), sample_set_variants()}) {
            v.insert(v.end(), family.begin(), family.end());
        }
        return v;
    }();
    return all;
}

/// A node as a descent finds it.
struct NodeRef {
    std::uint32_t index = 0;
    std::uint32_t parent = 0;  ///< of the root: itself
    Cell cell;
    std::uint32_t end_item = 0;
    std::uint32_t own_end = 0;   ///< of its own run, which begins at first_item
    std::uint32_t end_node = 0;  ///< its proper descendants are [first_child, end_node)
    long stand_in = -1;          ///< index into stand_ins() or -1
};

/// All nodes, parents before children, found with nothing but what Node's contract says.
inline std::vector<NodeRef> all_nodes(const AnyHierarchy& h) {
    std::vector<NodeRef> out;
    const auto nodes = h.nodes();
    const std::function<std::uint32_t(NodeRef)> visit = [&](NodeRef ref) {
        const Node& node = nodes[ref.index];
        const std::size_t at = out.size();
        ref.own_end = node.child_mask ? nodes[node.first_child].first_item : ref.end_item;
        out.push_back(ref);
        std::uint32_t rank = 0, data_rank = 0, end = node.child_mask ? node.first_child : ref.index + 1;
        const auto children = std::uint32_t(std::popcount(node.child_mask));
        if (children != 0) end = node.first_child + children;
        for (unsigned c = 0; c < 8; ++c) {
            if ((node.child_mask >> c & 1) == 0) continue;
            NodeRef child;
            child.index = node.first_child + rank++;
            child.parent = ref.index;
            child.cell = h.child(ref.cell, ref.index, c);
            child.end_item = rank < children ? nodes[child.index + 1].first_item : ref.end_item;
            if (node.stand_in_mask >> c & 1) child.stand_in = long(node.first_child_data + data_rank++);
            end = std::max(end, visit(child));
        }
        out[at].end_node = end;
        return end;
    };
    NodeRef root;
    root.cell = h.root_cell();
    root.end_item = h.item_count();
    root.stand_in = h.root_has_stand_in() ? 0 : -1;
    visit(root);
    return out;
}

}  // namespace farfield::test
