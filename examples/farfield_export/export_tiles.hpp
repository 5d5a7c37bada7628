// A hierarchy as 3D Tiles 1.1: a tree of tiles that a browser loads as far as a view asks for.
//
// A tile belongs to a cell. Where stand-ins replace what they stand for (REPLACE) its content is a cut through the
// cell's subtree, chosen as frames choose one, the largest error first, until it is as large as a tile may be; its
// children are the tiles of the cell's children. Where cells hold samples (ADD; Klein et al. 2002) a tile holds those
// of the cells some levels below its own, so that every primitive is in one tile and what has been loaded stays.
//
// `geometricError` is the largest error of what the tile shows, as a length: the errors that stand-ins were built with,
// in a parallel view in which one unit is one pixel. A viewer divides it by the distance to the tile's box, which holds
// the box of every cell that stands in; so its errorTarget (maximumScreenSpaceError) is an upper bound of what
// View::tolerance_px bounds.
//
// Coordinates of contents and boxes are the hierarchy's, in single precision; how far from zero these lie is said in
// double precision, by the root's `transform`.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <queue>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "farfield/approximation.hpp"
#include "farfield/approximation/opacity_tensor.hpp"
#include "farfield/drawables.hpp"
#include "farfield/frame/subtree.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/view/local_view.hpp"
#include "gaussian.hpp"
#include "tile_content.hpp"

namespace farfield_export {

struct ExportOptions {
    /// Triangles, splats and faces of a tile, more or less: up to twice as many where that leaves nothing for tiles
    /// below it, and more where one cell by itself holds more.
    std::size_t tile_size = 8192;
    /// Levels between the cell of a tile and the cells whose samples it holds (ADD).
    unsigned sample_levels = 4;
    /// Points along with triangles (ADD), in tiles that have children: what is shown while these are not is smaller
    /// than pixels, and the rest is missing. A viewer had better hide them where children are shown.
    bool adds_points = true;
    /// Tiles that one JSON file holds, more or less; others lie in files of their own that a viewer loads as it goes.
    std::size_t tiles_in_file = 512;
    /// What is to be added to the primitives' coordinates, as scenes far from zero leave it out (Scene::origin).
    glm::dvec3 origin{0};
    GaussianOptions gaussian{};
};

struct ExportReport {
    std::uint64_t tiles = 0;  ///< that have contents
    std::uint64_t files = 0, bytes = 0;
    std::uint64_t triangles = 0;  ///< of primitives; one that is in several tiles (REPLACE) counts in each
    std::uint64_t splats = 0, face_triangles = 0, points = 0;
    unsigned levels = 0;
};

/// Takes a file of the tileset: a name without folders, and its bytes. The last one is tileset.json.
using StoreFile = std::function<void(const std::string& name, std::string_view bytes)>;

/// H is a hierarchy in memory, over these primitives, or a PagedHierarchy, of which no more is in memory than its cache
/// may hold: it is looked at a tile at a time.
template <class H, class P>
class TilesetExport {
    using A = typename H::approximation_type;
    static constexpr bool is_paged = farfield::PagedAtRunTime<H>;
    static constexpr bool adds = A::facts.samples_primitives;
    static_assert(A::facts.stands_in, "farfield_export: without stand-ins there is nothing to show from afar");
    static_assert(H::assignment == farfield::Assignment::unique,
                  "farfield_export: a primitive in several cells would be in several tiles");
    static_assert(!farfield::PrimitiveWithInstance<P>, "farfield_export: expand instances first");

  public:
    TilesetExport(H& hierarchy, std::span<const P> primitives, StoreFile store, const ExportOptions& options = {})
        : hierarchy_(hierarchy),
          primitives_(primitives),
          store_(std::move(store)),
          options_(options),
          policy_(hierarchy.approximation_policy()) {
        if constexpr (requires { policy_.samples_up_to_px; }) {
            policy_.samples_up_to_px = std::max(policy_.samples_up_to_px, 1.0f);  // its samples will be drawn
        }
    }

    /// Throws std::invalid_argument if there is nothing to export or the origin is not finite, std::runtime_error if a
    /// page is missing, and what storing throws.
    ExportReport run() {
        path_.clear();
        const glm::dvec3 o = options_.origin + hierarchy_.origin();
        if (!std::isfinite(o.x) || !std::isfinite(o.y) || !std::isfinite(o.z))
            throw std::invalid_argument("farfield_export: the scene's origin is not finite");
        std::optional<Tile> root = adds ? sampled_tile() : replaced_tile();
        if (!root) throw std::invalid_argument("farfield_export: the scene is empty");
        if (o != glm::dvec3(0)) {
            root->json["transform"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, o.x, -o.z, o.y, 1};
        }
        store_tileset("tileset", *root);
        return report_;
    }

  private:
    using Json = nlohmann::ordered_json;

    struct Tile {
        Json json;
        farfield::Box box;  ///< of its content and its children, in the hierarchy's coordinates
        float error = 0;
        std::size_t count = 1;  ///< of tiles, with those below
    };
    /// What a look at a tile's cell has found.
    struct Found {
        TileContent content{};
        farfield::Box box = farfield::Box::empty();  ///< of the cells that stand in
        float error = 0;
        unsigned children = 0;  ///< a mask, of those that tiles are to be made for
        bool has_own_run = false;
    };
    struct Waiting {
        float error;
        std::uint32_t number;
        std::uint64_t items;
        farfield::Subtree subtree;
        bool operator<(const Waiting& other) const {
            return error != other.error ? error < other.error : number > other.number;
        }
    };

    // ---- tiles

    /// None: there is nothing in it.
    std::optional<Tile> replaced_tile() {
        Found found = look([&](const farfield::Subtree& s) { return cut(s); });
        std::optional<Tile> tile = begin_tile(found, "");
        if (found.has_own_run && found.children != 0) {
            // No child's tile holds what lies in the cell itself, and it is replaced with the rest.
            Found own = look([&](const farfield::Subtree& s) {
                Found out;
                add_run(hierarchy_.nodes()[s.node].first_item, farfield::end_of_own_run(hierarchy_, s), out.content);
                return out;
            });
            add_child(tile, begin_tile(own, "o"));
        }
        return with_children(std::move(tile), found.children, [&] { return replaced_tile(); });
    }

    std::optional<Tile> sampled_tile() {
        const Found found = look([&](const farfield::Subtree& s) { return samples(s); });
        return with_children(begin_tile(found, ""), found.children, [&] { return sampled_tile(); });
    }

    template <class Make>
    std::optional<Tile> with_children(std::optional<Tile> tile, unsigned children, Make&& make) {
        for (unsigned child = 0; child < 8; ++child) {
            if ((children >> child & 1) == 0) continue;
            path_.push_back(child);
            add_child(tile, make());
            path_.pop_back();
        }
        if (!tile) return tile;
        tile->json["boundingVolume"]["box"] = box_of(tile->box);
        tile->json["geometricError"] = tile->error;
        if (tile->count > options_.tiles_in_file && !path_.empty()) {
            const std::string name = name_of_tile("");
            store_tileset(name, *tile);
            Json stub;
            stub["boundingVolume"] = tile->json["boundingVolume"];
            stub["geometricError"] = tile->error;
            stub["content"]["uri"] = name + ".json";
            tile->json = std::move(stub);
            tile->count = 1;
        }
        return tile;
    }

    std::string name_of_tile(const char* suffix) const {
        std::string name = "r";
        for (const unsigned child : path_) name += char('0' + child);
        return name + suffix;
    }

    std::optional<Tile> begin_tile(const Found& found, const char* suffix) {
        report_.levels = std::max(report_.levels, unsigned(path_.size()) + 1);
        Tile tile{Json::object(), found.box, found.error};
        // In the order in which people look for them.
        tile.json["boundingVolume"] = nullptr;
        tile.json["geometricError"] = found.error;
        if (found.content.is_empty()) {
            if (found.children == 0) return {};
        } else {
            const TileContent& c = found.content;
            tile.box.add(c.bounds());
            const std::string name = name_of_tile(suffix) + ".glb", bytes = glb_of(c);
            store(name, bytes);
            tile.json["content"]["uri"] = name;
            ++report_.tiles;
            report_.triangles += c.surfaces.triangles();
            report_.face_triangles += c.faces.triangles();
            report_.splats += c.splats.size();
            report_.points += c.points.size();
        }
        tile.json["boundingVolume"] = {{"box", box_of(tile.box)}};
        return tile;
    }
    static void add_child(std::optional<Tile>& tile, std::optional<Tile> child) {
        if (!child) return;
        tile->box.add(child->box);
        tile->error = std::max(tile->error, child->error);
        tile->count += child->count;
        tile->json["children"].push_back(std::move(child->json));
    }

    void store(const std::string& name, std::string_view bytes) {
        ++report_.files;
        report_.bytes += bytes.size();
        store_(name, bytes);
    }
    void store_tileset(const std::string& name, Tile& root) {
        Json tileset;
        tileset["asset"] = {{"version", "1.1"}};
        // Of a picture without it: all of it is missing.
        tileset["geometricError"] = std::max(root.error, root.box.largest_side());
        root.json["refine"] = adds ? "ADD" : "REPLACE";
        tileset["root"] = root.json;
        store(name + ".json", tileset.dump());
    }

    /// Up is z in tiles and y in glTF; viewers turn glTF.
    static Json box_of(const farfield::Box& box) {
        const glm::dvec3 lower(box.lower), upper(box.upper), c = (lower + upper) * 0.5, h = (upper - lower) * 0.5;
        return {c.x, -c.z, c.y, h.x, 0, 0, 0, h.z, 0, 0, 0, h.y};
    }

    // ---- what is in them

    template <class F>
    Found look(F&& f) {
        if constexpr (is_paged) {
            const farfield::WaitingFrame<H> frame(hierarchy_);
            return f(subtree_on_path());
        } else {
            return f(subtree_on_path());
        }
    }
    farfield::Subtree subtree_on_path() const {
        farfield::Subtree at = farfield::whole_of(hierarchy_);
        for (const unsigned child : path_) {
            const farfield::Node& node = hierarchy_.nodes()[at.node];
            at = farfield::detail::child_of(hierarchy_, at, node, hierarchy_.data_of(at.node), child);
            go_to_contents(at);
        }
        return at;
    }
    void go_to_contents([[maybe_unused]] farfield::Subtree& s) const {
        if constexpr (is_paged) {
            if (!hierarchy_.is_portal(hierarchy_.nodes()[s.node]) || hierarchy_.follow(s, 1)) return;
            const std::string why = hierarchy_.cache_stats().last_failure;
            throw std::runtime_error("farfield_export: a page is missing: " +
                                     (why.empty() ? "the cache has no room for what a tile shows" : why));
        }
    }
    template <class F>
    void for_each_child(const farfield::Subtree& s, F&& f) const {
        farfield::for_each_child<farfield::VisitOrder::any>(hierarchy_, s, glm::vec4(0), f);
    }

    /// Primitives in a subtree; of what lies in pages about as many.
    std::uint64_t items_in(const farfield::Subtree& s) const {
        const farfield::Node& node = hierarchy_.nodes()[s.node];
        if constexpr (is_paged) {
            if (hierarchy_.is_portal(node)) return hierarchy_.items_below(node);
            std::uint64_t items = farfield::end_of_own_run(hierarchy_, s) - node.first_item;
            for_each_child(s, [&](farfield::Subtree& child) { items += items_in(child); });
            return items;
        } else {
            return s.end_item - node.first_item;
        }
    }

    void add_run(std::uint32_t first, std::uint32_t end, TileContent& content) const {
        const auto source = farfield::Source<P>{
            primitives(), hierarchy_.order(), hierarchy_.item_count(), hierarchy_.origin(), 0, hierarchy_.fragments()};
        for (std::uint32_t position = first; position < end; ++position) {
            const std::size_t before = content.surfaces.positions.size();
            source.polygons(position, [&](const farfield::Polygon& polygon) { content.surfaces.add(polygon); });
            if (adds && options_.adds_points && content.surfaces.positions.size() > before) {
                add_point(before, content);
            }
        }
    }
    std::span<const P> primitives() const {
        if constexpr (is_paged) {
            return hierarchy_.primitives();
        } else {
            return primitives_;
        }
    }
    /// In the middle of what has been added.
    static void add_point(std::size_t first, TileContent& content) {
        const auto& from = content.surfaces;
        const float part = 1 / float(from.positions.size() - first);
        glm::vec3 middle(0);
        glm::vec4 color(0);
        for (std::size_t i = first; i < from.positions.size(); ++i) {
            middle += from.positions[i] * part;
            color += farfield::to_vec4(from.colors[i]) * part;
        }
        content.points.push_back(middle);
        content.point_colors.push_back(farfield::to_rgba8(color));
    }
    void add_stand_in(const farfield::Subtree& s, TileContent& content) const {
        const auto& data = hierarchy_.stand_ins()[s.stand_in];
        if constexpr (std::is_same_v<A, farfield::OpacityTensor>) {
            const GaussianSplat splat = gaussian_of(policy_, data, s.cell, options_.gaussian);
            if (splat.opacity > 0) content.splats.push_back(splat);
        } else {
            farfield::detail::stand_in_polygons(policy_, data, hierarchy_.pool(), s.cell,
                                                [&](const farfield::Polygon& p) { content.faces.add(p); });
        }
    }

    /// A length.
    float error_of(const farfield::Subtree& s) const {
        if (!s.has_stand_in()) return std::numeric_limits<float>::infinity();
        return policy_.error_px(hierarchy_.stand_ins()[s.stand_in], s.cell, one_pixel_a_unit_) *
               farfield::detail::error_of_replaced_levels(hierarchy_.nodes()[s.node]);
    }

    Found cut(const farfield::Subtree& whole) const {
        Found found;
        std::priority_queue<Waiting> queue;
        std::uint64_t items_waiting = 0;
        std::uint32_t number = 0;
        const auto open = [&](auto&& self, farfield::Subtree s) -> void {
            go_to_contents(s);
            add_run(hierarchy_.nodes()[s.node].first_item, farfield::end_of_own_run(hierarchy_, s), found.content);
            for_each_child(s, [&](farfield::Subtree& child) {
                if (!child.has_stand_in()) return self(self, child);
                const std::uint64_t items = items_in(child);
                items_waiting += items;
                queue.push({error_of(child), number++, items, child});
            });
        };
        const farfield::Node& node = hierarchy_.nodes()[whole.node];
        open(open, whole);
        while (!queue.empty()) {
            const std::size_t triangles = found.content.surfaces.triangles();
            const bool is_near_end = triangles + items_waiting <= 2 * options_.tile_size;
            if (!is_near_end && triangles + queue.size() >= options_.tile_size) break;
            const Waiting next = queue.top();
            queue.pop();
            items_waiting -= next.items;
            open(open, next.subtree);
        }
        if (queue.empty()) return found;
        found.error = queue.top().error;
        found.children = node.child_mask;
        found.has_own_run = farfield::end_of_own_run(hierarchy_, whole) != node.first_item;
        for (; !queue.empty(); queue.pop()) {
            const farfield::Subtree& s = queue.top().subtree;
            add_stand_in(s, found.content);
            found.box.add(s.cell.box());
        }
        return found;
    }

    Found samples(const farfield::Subtree& whole) const {
        Found found;
        std::vector<farfield::Subtree> lowest;
        std::uint64_t items = 0;
        const auto descend = [&](auto&& self, farfield::Subtree s, unsigned levels) -> void {
            if (levels == 0) {
                items += items_in(s);
                lowest.push_back(s);
                return;
            }
            go_to_contents(s);
            // The tiles of cells above hold what lies here, and there is none above the root.
            if (path_.empty()) add_own_run(s, found.content);
            for_each_child(s, [&](farfield::Subtree& child) { self(self, child, levels - 1); });
        };
        descend(descend, whole, options_.sample_levels);
        if (items <= options_.tile_size) {
            for (const farfield::Subtree& s : lowest) add_all(s, found.content);
            // Nothing is missing that points would have to make up for.
            found.content.points.clear();
            found.content.point_colors.clear();
            return found;
        }
        found.children = hierarchy_.nodes()[whole.node].child_mask;
        for (farfield::Subtree& s : lowest) {
            go_to_contents(s);
            add_own_run(s, found.content);
            if (hierarchy_.nodes()[s.node].child_mask == 0) continue;
            found.box.add(s.cell.box());
            const float error = error_of(s);
            found.error = std::max(found.error, std::isfinite(error) ? error : 1.5f * s.cell.largest_side());
        }
        return found;
    }
    void add_own_run(const farfield::Subtree& s, TileContent& content) const {
        add_run(hierarchy_.nodes()[s.node].first_item, farfield::end_of_own_run(hierarchy_, s), content);
    }
    void add_all(farfield::Subtree s, TileContent& content) const {
        go_to_contents(s);
        add_own_run(s, content);
        for_each_child(s, [&](farfield::Subtree& child) { add_all(child, content); });
    }

    static farfield::LocalView one_pixel_a_unit() {
        farfield::View view;
        view.camera = farfield::Camera::orthographic({0, 0, 1}, {0, 0, 0}, {0, 1, 0}, 1);
        view.width = view.height = 2;
        view.tolerance_px = 1;
        return {view, glm::dvec3(0), 1};
    }

    H& hierarchy_;
    std::span<const P> primitives_;
    StoreFile store_;
    ExportOptions options_;
    A policy_;
    farfield::LocalView one_pixel_a_unit_ = one_pixel_a_unit();
    std::vector<unsigned> path_;  ///< to the cell of the tile that is made: the numbers of children
    ExportReport report_;
};

/// A hierarchy in memory.
template <class H, class P>
ExportReport export_tiles(const H& hierarchy, const std::vector<P>& primitives, StoreFile store,
                          const ExportOptions& options = {}) {
    return TilesetExport<const H, P>(hierarchy, primitives, std::move(store), options).run();
}
/// A file of pages.
template <farfield::PagedAtRunTime H>
ExportReport export_tiles(H& pages, StoreFile store, const ExportOptions& options = {}) {
    return TilesetExport<H, typename H::primitive_type>(pages, {}, std::move(store), options).run();
}

}  // namespace farfield_export
