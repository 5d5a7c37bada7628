// A hierarchy, or a list, drawn by any renderer, whose types the rest of a program need not know.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/coverage/coverage_work.hpp"
#include "farfield/geometry/box.hpp"
#include "farfield/geometry/polygon.hpp"
#include "farfield/image.hpp"
#include "farfield/primitive/triangle.hpp"
#include "farfield/viewer.hpp"
#include "support/pair.hpp"

namespace farfield::bench {

/// Draws frames of what it was made for, which outlives it.
class Drawer {
  public:
    virtual ~Drawer() = default;
    virtual FrameStats frame(const View& view) = 0;
    virtual const Image& image() const = 0;                  ///< of the last frame
    virtual CoverageWork work() const { return {}; }         ///< likewise, of renderers with masks
    virtual std::size_t pyramid_bytes() const { return 0; }  ///< likewise
};

template <class R>
class RendererDrawer : public Drawer {
  public:
    template <class Options>
    explicit RendererDrawer(const Options& options) : renderer_(options) {}
    const Image& image() const override { return renderer_.image(); }
    CoverageWork work() const override {
        if constexpr (requires { renderer_.work(); }) {
            return renderer_.work();
        } else {
            return {};
        }
    }
    std::size_t pyramid_bytes() const override {
        if constexpr (requires { renderer_.pyramid_bytes(); }) {
            return renderer_.pyramid_bytes();
        } else {
            return 0;
        }
    }

  protected:
    R renderer_;
};

template <class H, class P, class R>
class HierarchyDrawer final : public RendererDrawer<R> {
  public:
    template <class Options>
    HierarchyDrawer(const H& hierarchy, std::span<const P> primitives, const Options& options)
        : RendererDrawer<R>(options), viewer_(hierarchy, primitives, this->renderer_) {}
    FrameStats frame(const View& view) override { return viewer_.frame(view); }

  private:
    Viewer<H, P, R> viewer_;
};

template <class R, class H, class P, class Options>
std::unique_ptr<Drawer> drawer(const H& hierarchy, const std::vector<P>& primitives, const Options& options) {
    return std::make_unique<HierarchyDrawer<H, P, R>>(hierarchy, std::span<const P>(primitives), options);
}

/// Primitives in the order in which they lie, without a hierarchy.
template <class P, class R>
class ListDrawer final : public RendererDrawer<R> {
  public:
    template <class Options>
    ListDrawer(const std::vector<P>& primitives, const Options& options)
        : RendererDrawer<R>(options), source_{.primitives = primitives, .order = {}} {
        source_.item_count = std::uint32_t(primitives.size());
        source_.id = this->renderer_.upload(source_);
        Box bounds = Box::empty();
        for (const P& p : primitives) bounds.add(p.bounds());
        diagonal_ = glm::length(bounds.size());
    }
    ~ListDrawer() override { this->renderer_.release(source_.id); }
    FrameStats frame(const View& view) override {
        const LocalView local(view, glm::dvec3(0), diagonal_);
        this->renderer_.begin_frame(local);
        this->renderer_.set_view(local);
        const std::array<Range, 1> all{{{0, source_.item_count}}};
        this->renderer_.draw(source_, std::span<const Range>(all));
        this->renderer_.end_frame();
        return {};
    }

  private:
    Source<P> source_;
    float diagonal_;
};

template <class R, class P, class Options>
std::unique_ptr<Drawer> list_drawer(const std::vector<P>& primitives, const Options& options) {
    return std::make_unique<ListDrawer<P, R>>(primitives, options);
}

/// How much of everything a run of a program measures.
struct Run {
    Patience patience;
    std::size_t most_views = 100;
    bool is_quick = false;

    std::vector<View> some(std::vector<View> views) const {
        views.resize(std::min(views.size(), most_views));
        return views;
    }
    PairTimes pair(const View& view, Drawer& ours, Drawer& other) const {
        return in_turns(
            patience, [&] { ours.frame(view); }, [&] { other.frame(view); });
    }
    std::vector<PairTimes> pairs(const std::vector<View>& views, Drawer& ours, Drawer& other) const {
        std::vector<PairTimes> result;
        for (const View& view : views) result.push_back(pair(view, ours, other));
        return result;
    }
};

/// Drawers that take turns in one run, all of them on each view, and the rows that compare two of them. What they draw
/// outlives it.
class Race {
  public:
    Race(const Run& run, std::string scene) : run_(run), scene_(std::move(scene)) {}

    Drawer& add(const std::string& who, std::unique_ptr<Drawer> drawer) {
        names_.push_back(who);
        drawers_.push_back(std::move(drawer));
        return *drawers_.back();
    }
    Drawer& operator[](const std::string& who) const { return *drawers_[index(who)]; }

    void draw(const std::vector<View>& views) {
        for (const View& view : views) {
            std::vector<std::function<void()>> frames;
            for (const auto& drawer : drawers_) frames.push_back([&view, &drawer] { drawer->frame(view); });
            turns_.push_back(in_turns(run_.patience, frames));
        }
    }

    void row(const std::string& ours, const std::string& other, const Wanted& wanted = {}) const {
        std::vector<PairTimes> pairs;
        for (const Turns& turns : turns_) pairs.push_back(pair_of(turns[index(ours)], turns[index(other)]));
        Table::add(scene_ + ": " + ours + ", " + other, pairs, wanted);
    }

  private:
    std::size_t index(const std::string& who) const {
        const auto found = std::find(names_.begin(), names_.end(), who);
        if (found == names_.end()) throw std::logic_error("nobody is called " + who);
        return std::size_t(found - names_.begin());
    }

    const Run& run_;
    std::string scene_;
    std::vector<std::string> names_;
    std::vector<std::unique_ptr<Drawer>> drawers_;
    std::vector<Turns> turns_;  ///< one a view
};

/// A quadrilateral of one color.
struct Quadrilateral {
    std::array<glm::vec3, 4> vertices{};
    Rgba8 rgba{};

    Box bounds() const {
        Box box = Box::empty();
        for (const glm::vec3& v : vertices) box.add(v);
        return box;
    }
    template <class Sink>
    void polygons(Sink&& sink) const {
        sink(Polygon{vertices, {&rgba, 1}});
    }
};

/// Of pairs of triangles as scenes make them: a, b, c and a, c, d.
inline std::vector<Quadrilateral> quadrilaterals_of(std::span<const VertexColoredTriangle> triangles) {
    std::vector<Quadrilateral> result;
    for (std::size_t i = 0; i + 1 < triangles.size(); i += 2) {
        const auto &one = triangles[i].vertices, &other = triangles[i + 1].vertices;
        result.push_back({{one[0], one[1], one[2], other[2]}, triangles[i].rgba[0]});
    }
    return result;
}

}  // namespace farfield::bench
