#include "paged_scene.hpp"

#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <utility>

#if FARFIELD_HAS_HTTP
#include "farfield/adapters/http_page_source.hpp"
#endif
#include "farfield/paging/file_page_source.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/pick.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "scenes/paged_variants.hpp"

namespace viewer {
namespace {

using farfield::FrameStats;
using farfield::Image;
using farfield::View;
using farfield::scenes::BuiltScene;
using farfield::scenes::PagedPrimitive;
using farfield::scenes::PickedInScene;
using farfield::scenes::RendererChoice;
using farfield::scenes::RendererKind;
using farfield::scenes::SceneViewer;

bool is_address(const std::string& where) {
    return where.rfind("http://", 0) == 0 || where.rfind("https://", 0) == 0;
}

template <class Pages>
class PagedFrames final : public SceneViewer {
  public:
    PagedFrames(const Pages& pages, const RendererChoice& choice)
        : renderer_({.samples = choice.samples}), viewer_(pages, renderer_) {}
    FrameStats frame(const View& view) override { return viewer_.frame(view); }
    const Image& image() const override { return renderer_.image(); }

  private:
    farfield::ZBufferRenderer renderer_;
    farfield::Viewer<Pages, PagedPrimitive, farfield::ZBufferRenderer> viewer_;
};

template <class Pages>
class PagedBuilt final : public BuiltScene {
  public:
    explicit PagedBuilt(const Pages& pages) : pages_(pages) {
        facts_.bytes = pages.bytes();
        facts_.cells = pages.node_count();
        facts_.levels = pages.report().levels;
    }
    std::unique_ptr<SceneViewer> viewer(const RendererChoice& choice) const override {
        if (choice.kind != RendererKind::z_buffer) throw std::invalid_argument("pages are drawn by the z-buffer here");
        return std::make_unique<PagedFrames<Pages>>(pages_, choice);
    }
    std::optional<PickedInScene> pick(const View& view, glm::dvec2 pixel) const override {
        Pages own = pages_;  // whoever picks may be another thread
        const auto picked = farfield::pick(own, view, pixel);
        if (!picked) return std::nullopt;
        PickedInScene out;
        out.depth = picked->distance;
        out.point = farfield::ray_through(view, pixel).at(picked->distance);
        out.path = {picked->page, picked->item};
        for (const auto& v : picked->primitive.vertices) out.corners.push_back(glm::dvec3(v));
        return out;
    }

  private:
    Pages pages_;
};

template <class Source>
PagedScene open(const std::shared_ptr<Source>& source, const std::string& where, std::size_t cache_bytes) {
    PagedScene scene;
    const bool is_known = farfield::scenes::any_paged_variant([&](auto type, std::string_view name) {
        using H = typename decltype(type)::type;
        if (!farfield::holds_pages_of<H, PagedPrimitive>(*source)) return false;
        const auto pages = farfield::open_pages_of<H, PagedPrimitive>(source, where, {.most_bytes = cache_bytes});
        using Pages = std::remove_cvref_t<decltype(pages)>;
        scene.built = std::make_shared<PagedBuilt<Pages>>(pages);
        scene.variant = name;
        scene.bounds = {glm::dvec3(pages.bounds().lower) + pages.origin(),
                        glm::dvec3(pages.bounds().upper) + pages.origin()};
        scene.primitives = pages.primitive_count();
        scene.file_bytes = pages.bytes();
        scene.pages = pages.page_count();
        return true;
    });
    if (!is_known) throw std::runtime_error(where + " is no file of pages that farfield_build makes");
    return scene;
}

}  // namespace

bool is_paged_scene(const std::string& where) {
    constexpr std::string_view end = ".farfield";
    return is_address(where) ||
           (where.size() > end.size() && where.compare(where.size() - end.size(), end.size(), end) == 0);
}

PagedScene open_paged_scene(const std::string& where, std::size_t cache_bytes) {
    if (is_address(where)) {
#if FARFIELD_HAS_HTTP
        return open(std::make_shared<farfield::HttpPageSource>(where), where, cache_bytes);
#else
        throw std::runtime_error(
            "this viewer was built without libcurl: give it a file, or install "
            "libcurl4-openssl-dev and build again");
#endif
    }
    return open(std::make_shared<farfield::FilePageSource>(where), where, cache_bytes);
}

}  // namespace viewer
