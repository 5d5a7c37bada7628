#include "paged_scene.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#ifdef FARFIELD_HAS_HTTP
#include "farfield/adapters/http_page_source.hpp"
#endif
#ifdef FARFIELD_HAS_OPENGL
#include "opengl/culled_in_software.hpp"
#include "opengl/gl_renderer.hpp"
#include "scenes/renderers/opengl_renderer.hpp"
#endif
#include "farfield/paging/file_page_source.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/pick.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/tuning/error_table.hpp"
#include "farfield/tuning/kept_error_table.hpp"
#include "farfield/tuning/sampled_error_table.hpp"
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

struct ZBuffer {
    using Renderer = farfield::ZBufferRenderer;
    Renderer renderer;
    explicit ZBuffer(const RendererChoice& choice) : renderer({.samples = choice.samples}) {}
    const Image& image() const { return renderer.image(); }
    unsigned texture() const { return 0; }
    void finish() {}
};

#ifdef FARFIELD_HAS_OPENGL
struct OpenGl {
    using Renderer = farfield::opengl::CulledInSoftware<farfield::opengl::GlRenderer>;
    std::shared_ptr<void> context = farfield::scenes::opengl_context();
    farfield::opengl::GlRenderer shading;
    Renderer renderer;
    explicit OpenGl(const RendererChoice& choice)
        : shading({.samples = choice.samples}),
          renderer(shading, farfield::ZBufferOptions{.samples = choice.samples}) {}
    const Image& image() const { return shading.image(); }
    unsigned texture() const { return shading.texture(); }
    void finish() { glFinish(); }  // so that times are times
};
#endif

struct KeptTable {
    farfield::MeasuredWith with;
    farfield::SampledErrorTable table;
};

/// Of the z-buffer, but OpenGL draws the same and errs alike. What is no table, or of another version, is as if it were
/// not there: a scene is shown without.
template <class Pages>
std::vector<KeptTable> kept_tables(const Pages& pages) {
    std::vector<KeptTable> tables;
    for (const farfield::MeasuredWith& with : farfield::error_tables_in(pages.notes())) {
        if (with.renderer != name_of(RendererKind::z_buffer)) continue;
        try {
            tables.push_back({with, farfield::kept_error_table(with, pages).value()});
        } catch (const std::runtime_error&) {
            continue;
        }
    }
    return tables;
}

template <class Pages, class Drawn>
class PagedFrames final : public SceneViewer {
  public:
    PagedFrames(const Pages& pages, const std::vector<KeptTable>& tables, const RendererChoice& choice)
        : by_(choice), viewer_(pages, by_.renderer) {
        for (const KeptTable& kept : tables) {
            for (const farfield::ErrorsAtSamples& at : kept.table.tables()) {
                if (at.samples == choice.samples) tables_.push_back({kept.with.height, at.table});
            }
        }
    }
    FrameStats frame(const View& view) override {
        const FrameStats stats = viewer_.frame(with_tolerance(view));
        by_.finish();
        return stats;
    }
    const Image& image() const override { return by_.image(); }
    unsigned texture() const override { return by_.texture(); }

  private:
    struct TableAtHeight {
        int height;  ///< of the pictures that were measured
        farfield::ErrorTable table;
    };

    /// Where an error is wanted and the file has a table for so many samples, the tolerance that keeps it: by the table
    /// of pictures that are most nearly as high, for the window has any size.
    View with_tolerance(View view) const {
        if (view.wanted.is_any() || tables_.empty()) return view;
        const auto ratio = [&](const TableAtHeight& t) {
            return std::abs(std::log(double(t.height) / double(view.whole_height())));
        };
        const auto nearest =
            std::min_element(tables_.begin(), tables_.end(),
                             [&](const TableAtHeight& a, const TableAtHeight& b) { return ratio(a) < ratio(b); });
        view.tolerance_px = nearest->table.tolerance_for(view.wanted).trial.tolerance_px;
        view.wanted.rmse = farfield::WantedError::any().rmse;
        return view;
    }

    Drawn by_;
    farfield::Viewer<Pages, PagedPrimitive, typename Drawn::Renderer> viewer_;
    std::vector<TableAtHeight> tables_;
};

template <class Pages>
class PagedBuilt final : public BuiltScene {
  public:
    explicit PagedBuilt(const Pages& pages) : pages_(pages), tables_(kept_tables(pages)) {
        facts_.bytes = pages.bytes();
        facts_.cells = pages.node_count();
        facts_.levels = pages.report().levels;
    }
    std::unique_ptr<SceneViewer> viewer(const RendererChoice& choice) const override {
        if (!draws_pages(choice.kind)) {
            throw std::invalid_argument("the renderer " + std::string(name_of(choice.kind)) +
                                        " does not draw from pages here");
        }
#ifdef FARFIELD_HAS_OPENGL
        if (choice.kind == RendererKind::opengl)
            return std::make_unique<PagedFrames<Pages, OpenGl>>(pages_, tables_, choice);
#endif
        return std::make_unique<PagedFrames<Pages, ZBuffer>>(pages_, tables_, choice);
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
    std::vector<KeptTable> tables_;
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

bool draws_pages(RendererKind kind) {
#ifdef FARFIELD_HAS_OPENGL
    if (kind == RendererKind::opengl) return true;
#endif
    return kind == RendererKind::z_buffer;
}

PagedScene open_paged_scene(const std::string& where, std::size_t cache_bytes) {
    if (is_address(where)) {
#ifdef FARFIELD_HAS_HTTP
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
