// Writes a scene as 3D Tiles 1.1, which a browser opens (examples/web.sh), CesiumJS and engines too.
//
//     farfield_export SCENE FOLDER [--variant NAME] [--tile N] [--pictures]
//
// SCENE is one of those that are generated, a model's file, or a file of pages that farfield_build made, which may be
// larger than memory: a tile at a time is.
#include <algorithm>
#include <chrono>
#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <fstream>
#include <glm/vec3.hpp>
#include <ios>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "export_tiles.hpp"
#include "farfield/build.hpp"
#include "farfield/paging/open_pages.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/viewer.hpp"
#include "pictures.hpp"
#include "scenes/catalog.hpp"
#include "scenes/load/load.hpp"
#include "scenes/paged_origin.hpp"
#include "scenes/paged_variants.hpp"
#include "scenes/scene.hpp"

namespace {

using farfield::scenes::PagedPrimitive;
using Clock = std::chrono::steady_clock;

struct Request {
    std::string scene;
    std::filesystem::path folder;
    std::string variant = "opacity-tensor";
    std::uint64_t memory_mib = 256;
    farfield_export::ExportOptions options;
    bool draws = false;
};

void write_file(const std::filesystem::path& path, std::string_view bytes) {
    std::ofstream out(path, std::ios::binary);
    out.write(bytes.data(), std::streamsize(bytes.size()));
    out.close();
    if (!out) throw std::runtime_error(path.string() + ": cannot be written");
}

farfield_export::StoreFile storing_in(const std::filesystem::path& folder) {
    return [folder](const std::string& name, std::string_view bytes) { write_file(folder / name, bytes); };
}

/// Of the processor as well, which tells more on a machine that has other things to do.
struct Times {
    Clock::time_point begin = Clock::now();
    std::clock_t work = std::clock();
    double seconds() const { return std::chrono::duration<double>(Clock::now() - begin).count(); }
    double of_work() const { return std::max(double(std::clock() - work) / CLOCKS_PER_SEC, 1e-6); }
};

void report(const farfield_export::ExportReport& r, std::uint64_t primitives, const Times& times) {
    std::printf("%llu tiles, %u levels, %llu files, %.1f MiB: %llu splats, %llu faces, %llu triangles, %llu points\n",
                static_cast<unsigned long long>(r.tiles), r.levels, static_cast<unsigned long long>(r.files),
                double(r.bytes) / 1048576, static_cast<unsigned long long>(r.splats),
                static_cast<unsigned long long>(r.face_triangles / 2), static_cast<unsigned long long>(r.triangles),
                static_cast<unsigned long long>(r.points));
    std::printf("exported in %.2f s, %.2f s of them of a processor: %.2f million triangles of the scene a second\n",
                times.seconds(), times.of_work(), double(primitives) / 1e6 / times.of_work());
}

/// All triangles at 64 samples a pixel, and what frames within a pixel draw at 16.
template <class H>
void draw(const H& hierarchy, const std::vector<PagedPrimitive>& primitives, glm::dvec3 origin,
          const std::filesystem::path& folder) {
    const auto& bounds = hierarchy.bounds();
    const auto views = farfield_export::views_of(
        {glm::dvec3(bounds.lower) + hierarchy.origin(), glm::dvec3(bounds.upper) + hierarchy.origin()});
    write_file(folder / "views.json", farfield_export::json_of(views, origin));
    for (const auto& [name, view] : views) {
        for (const bool is_exact : {true, false}) {
            farfield::ZBufferRenderer renderer({.samples = is_exact ? 64 : 16});
            auto viewer = farfield::make_viewer(hierarchy, primitives, renderer);
            farfield::View v = view;
            v.tolerance_px = is_exact ? 0.0f : 1.0f;
            viewer.frame(v);
            farfield_export::write_pam(renderer.image(), folder / (name + (is_exact ? "_exact.pam" : "_own.pam")));
        }
    }
}

template <class H>
void export_scene(const Request& request) {
    farfield::scenes::Scene scene = [&] {
        for (const std::string& name : farfield::scenes::names()) {
            if (name == request.scene) return farfield::scenes::make(name);
        }
        return farfield::scenes::load(request.scene);
    }();
    if (scene.groups.size() > 1) scene = farfield::scenes::expanded(scene);
    std::vector<PagedPrimitive>& primitives = scene.groups.back().triangles;
    if (primitives.empty()) throw std::invalid_argument(request.scene + ": there is nothing to export");
    const H hierarchy = farfield::build_in_place<H>(primitives, {});
    farfield_export::ExportOptions options = request.options;
    options.origin = scene.origin;
    const Times times;
    const auto written = farfield_export::export_tiles(hierarchy, primitives, storing_in(request.folder), options);
    report(written, primitives.size(), times);
    if (request.draws) draw(hierarchy, primitives, scene.origin, request.folder);
}

/// False if the file is of another variant.
template <class H>
bool export_pages(const Request& request) {
    farfield::FilePageSource source(request.scene);
    if (!farfield::holds_pages_of<H, PagedPrimitive>(source)) return false;
    farfield::PageCacheOptions cache;
    cache.most_bytes = std::size_t(request.memory_mib << 20);
    auto pages = farfield::open_pages<H, PagedPrimitive>(request.scene, cache);
    farfield_export::ExportOptions options = request.options;
    options.origin = farfield::scenes::origin_in(pages.notes(), request.scene);
    const Times times;
    const auto written = farfield_export::export_tiles(pages, storing_in(request.folder), options);
    report(written, pages.primitive_count(), times);
    return true;
}

bool is_page_file(const std::filesystem::path& path) {
    return path.extension() == ".farfield";
}

void run(const Request& request) {
    std::filesystem::create_directories(request.folder);
    // It is written last: where there is one, all that it names is there, and of one scene.
    std::filesystem::remove(request.folder / "tileset.json");
    if (is_page_file(request.scene)) {
        if (request.draws) throw std::invalid_argument("--pictures are drawn of scenes in memory, not of pages");
        const bool known = farfield::scenes::any_paged_variant(
            [&](auto type, std::string_view) { return export_pages<typename decltype(type)::type>(request); });
        if (!known) throw std::invalid_argument(request.scene + ": is not a file of pages that farfield_build made");
        return;
    }
    const bool known = farfield::scenes::any_paged_variant([&](auto type, std::string_view name) {
        if (name != request.variant) return false;
        export_scene<typename decltype(type)::type>(request);
        return true;
    });
    if (!known)
        throw std::invalid_argument("no variant '" + request.variant +
                                    "'; there are opacity-tensor, color-cube and sample-tree");
}

}  // namespace

int main(int argc, char** argv) {
    try {
        Request request;
        CLI::App app("Writes a scene as 3D Tiles 1.1: FOLDER/tileset.json and what belongs to it.");
        app.add_option("SCENE", request.scene, "a generated scene, a model's file, or pages (.farfield)")->required();
        app.add_option("FOLDER", request.folder, "where to write")->required();
        app.add_option("--variant", request.variant,
                       "opacity-tensor (splats), color-cube (faces) or sample-tree (triangles, ADD)")
            ->capture_default_str();
        app.add_option("--tile", request.options.tile_size, "triangles, splats and faces a tile, more or less")
            ->capture_default_str()
            ->check(CLI::Range(64, 1 << 20));
        app.add_option("--memory", request.memory_mib, "MiB of pages in memory")
            ->capture_default_str()
            ->check(CLI::Range(1, 1 << 20));
        app.add_flag("--pictures", request.draws, "draws views of the scene as well, to compare a browser's with");
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            if (error.get_exit_code() == 0) return app.exit(error);
            throw std::invalid_argument(error.what());
        }
        run(request);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "farfield_export: " << error.what() << "\n";
        return 2;
    }
}
