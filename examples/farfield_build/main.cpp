// Builds a file of pages, which may be larger than memory: walkthrough --scene FILE.farfield flies through it.
//
//     farfield_build SCENE OUT.farfield [--variant NAME] [--memory MiB] [--threads N] [--share I/N | --join N] [--pack]
//
// Under MPI (mpirun -np N farfield_build ...) every process builds a share, and the first joins them. Whatever was
// stopped, or lost with its process, goes on when the same command is given again.
//
// Of a model that lies far from zero a note says how far, which pages do not (scenes/paged_origin.hpp).
#include <chrono>
#include <CLI/CLI.hpp>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>
#include <type_traits>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#if FARFIELD_HAS_MPI
#include <mpi.h>
#endif

#if FARFIELD_HAS_ZSTD
#include "farfield/adapters/zstd_pages.hpp"
#endif
#include "farfield/build_pages.hpp"
#include "farfield/executor.hpp"
#include "farfield/paging/pack_pages.hpp"
#include "large_blocks.hpp"
#include "report/progress.hpp"
#include "scene_stream.hpp"
#include "scenes/paged_origin.hpp"
#include "scenes/paged_variants.hpp"

namespace {

struct Request {
    std::string scene;
    std::filesystem::path out;
    std::string variant = "opacity-tensor";
    std::uint64_t memory_mib = 256;
    unsigned threads = 0;
    std::string share;
    std::uint32_t join = 0;
    bool packs = false;
};

/// One process of several, all of which do the same until the last of them is done.
struct Processes {
    int index = 0, count = 1;
    Processes([[maybe_unused]] int* argc, [[maybe_unused]] char*** argv) {
#if FARFIELD_HAS_MPI
        MPI_Init(argc, argv);
        MPI_Comm_rank(MPI_COMM_WORLD, &index);
        MPI_Comm_size(MPI_COMM_WORLD, &count);
#endif
    }
    ~Processes() {
#if FARFIELD_HAS_MPI
        MPI_Finalize();
#endif
    }
    Processes(const Processes&) = delete;
    Processes& operator=(const Processes&) = delete;
    void wait_for_all() const {
#if FARFIELD_HAS_MPI
        MPI_Barrier(MPI_COMM_WORLD);
#endif
    }
    /// One that fails leaves the others waiting for good.
    [[noreturn]] static void give_up() {
#if FARFIELD_HAS_MPI
        MPI_Abort(MPI_COMM_WORLD, 2);
#endif
        std::_Exit(2);
    }
};

farfield::PageShare parse_share(const std::string& text) {
    farfield::PageShare share;
    int used = 0;
    if (std::sscanf(text.c_str(), "%u/%u%n", &share.index, &share.count, &used) != 2 ||
        std::size_t(used) != text.size() || share.index >= share.count) {
        throw std::invalid_argument("--share must be I/N with I from 0 to N - 1, not '" + text + "'");
    }
    return share;
}

/// Tells of phases on a line, as the programs do.
auto progress_told() {
    auto progress = std::make_shared<farfield::report::Progress>();
    return [progress, last = -1, percent = -1](const farfield::BuildProgress& p) mutable {
        constexpr const char* names[] = {"splitting", "sampling", "reading", "counting", "moving", "building"};
        if (last != int(p.phase)) {
            progress->begin(names[int(p.phase)], p.total != 0 ? 100 : 0);
            last = int(p.phase);
            percent = 0;
        }
        if (p.total != 0) {
            for (; percent < int(100 * p.done / p.total); ++percent) progress->step();
        }
        return true;
    };
}

/// A build needs the same memory for one group of primitives after the other, and what has been given back to the
/// system in between is cleared anew each time.
void keep_memory_that_was_freed() {
#if defined(__GLIBC__)
    ::mallopt(M_MMAP_THRESHOLD, 1 << 30);
    ::mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}

/// A build that is stopped while it packs has its file, which is not packed.
void pack(const Request& request) {
    if (!request.packs) return;
#if FARFIELD_HAS_ZSTD
    farfield::pack_pages(farfield::ZstdPages(), request.out, request.out, farfield::ThreadExecutor(request.threads));
#endif
}

template <class H>
void build(const Request& request, const Processes& processes) {
    using P = farfield::scenes::PagedPrimitive;
    farfield::PageBuildOptions<H> options;
    options.memory_bytes = request.memory_mib << 20;
    options.build.executor = farfield::ThreadExecutor(request.threads);
    if (processes.index == 0) options.build.progress = progress_told();
    if (request.join != 0) {
        farfield::join_page_shares<H, P>(request.out, request.join, options);
        return pack(request);
    }
    keep_memory_that_was_freed();
    const farfield::scenes::SceneStream scene = [&] {
        // What a model's file holds is not to need the memory that the build may take.
        const farfield::scenes::LargeBlocksInFiles files(std::filesystem::absolute(request.out).parent_path());
        return farfield::scenes::scene_stream(request.scene);
    }();
    farfield::PageShare share{std::uint32_t(processes.index), std::uint32_t(processes.count)};
    if (!request.share.empty()) share = parse_share(request.share);
    options.notes = farfield::scenes::notes_of_origin(scene.origin);
    farfield::build_page_share<H, P>(scene.triangles, request.out, share, options);
    if (!request.share.empty()) return;
    processes.wait_for_all();
    if (processes.index != 0) return;
    farfield::join_page_shares<H, P>(request.out, share.count, options);
    pack(request);
}

void run(const Request& request, const Processes& processes) {
    const auto begin = std::chrono::steady_clock::now();
    const bool known = farfield::scenes::any_paged_variant([&](auto type, std::string_view name) {
        if (name != request.variant) return false;
        build<typename decltype(type)::type>(request, processes);
        return true;
    });
    if (!known)
        throw std::invalid_argument("no variant '" + request.variant +
                                    "'; there are opacity-tensor, color-cube and sample-tree");
    if (processes.index != 0 || !request.share.empty()) return;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf("%s: %.1f MiB in %.1f s\n", request.out.string().c_str(),
                double(std::filesystem::file_size(request.out)) / 1048576, seconds);
}

/// What a reader takes for too little memory may be a disk that is full.
void refuse(const std::string& why) {
    std::cerr << "farfield_build: " << why;
    if (const int error = farfield::scenes::error_of_files(); error != 0) {
        std::cerr << ": what a model holds goes into files beside the one to be made, which the system refused: "
                  << std::generic_category().message(error);
    }
    std::cerr << "\n";
}

}  // namespace

int main(int argc, char** argv) {
    const Processes processes(&argc, &argv);
    try {
        Request request;
        CLI::App app("Builds a file of pages, which may be larger than memory, for walkthrough --scene OUT.farfield.");
        app.add_option("SCENE", request.scene, "chessboard:N, landscape:N (N triangles: 1M, 400M), or a model's file")
            ->required();
        app.add_option("OUT", request.out, "the file to make")->required();
        app.add_option("--variant", request.variant, "opacity-tensor, color-cube or sample-tree")
            ->capture_default_str();
        app.add_option("--memory", request.memory_mib,
                       "MiB that the build takes, of each process; the file depends on it")
            ->capture_default_str()
            ->check(CLI::Range(1, 1 << 20));
        app.add_option("--threads", request.threads, "0: as many as the machine runs at once")->capture_default_str();
        auto* const share =
            app.add_option("--share", request.share, "I/N: builds one of N shares, I from 0, and stops");
        app.add_option("--join", request.join, "N: joins shares that were built before")->excludes(share);
#if FARFIELD_HAS_ZSTD
        app.add_flag("--pack", request.packs, "packs pages by zstd when all is built");
#endif
        try {
            app.parse(argc, argv);
        } catch (const CLI::ParseError& error) {
            if (error.get_exit_code() == 0) return app.exit(error);
            throw std::invalid_argument(error.what());
        }
        run(request, processes);
        return 0;
    } catch (const std::bad_alloc&) {
        refuse("there is not enough memory");
    } catch (const std::exception& error) {
        refuse(error.what());
    }
    if (processes.count > 1) Processes::give_up();
    return 2;
}
