// Opens stored hierarchies whose bytes were changed, and draws what opens: it must be refused, or drawn within its
// arrays.
#include "farfield/storage/open.hpp"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <stdexcept>
#include <vector>

#include "farfield/paging/file_notes.hpp"
#include "farfield/renderer/z_buffer_renderer.hpp"
#include "farfield/storage/notes.hpp"
#include "farfield/storage/save.hpp"
#include "fuzz/fuzz.hpp"
#include "fuzz/input.hpp"
#include "scenes/renderers/coverage_tilers.hpp"
#include "storage/files.hpp"

namespace farfield::fuzz {
namespace {

/// The checksum of what follows the hierarchy agrees, too.
Bytes with_sealed_notes(Bytes bytes) {
    const std::uint64_t end = header_of(bytes).file_bytes;
    detail::NotesHeader notes;
    if (end > bytes.size() || bytes.size() - end < sizeof notes) return bytes;
    std::memcpy(&notes, bytes.data() + end, sizeof notes);
    notes.checksum = notes.checksum_with(std::as_bytes(std::span(bytes)).subspan(std::size_t(end) + sizeof notes));
    std::memcpy(bytes.data() + end, &notes, sizeof notes);
    return bytes;
}

/// A stored hierarchy of some triangles, its bytes changed as the input says. What changes seals it again may agree.
template <class Hierarchy>
void open_changed(Input& in) {
    static const std::vector<Triangle> triangles = scene(60);
    static const Bytes stored = [] {
        const auto h = built<Hierarchy>(triangles);
        const Notes notes{{"a", "1 2 3"}, {"b", ""}};
        std::vector<std::byte> bytes(std::size_t(saved_size(h, notes)));
        save(h, std::span(bytes), notes);
        const auto* chars = reinterpret_cast<const char*>(bytes.data());
        return Bytes(chars, chars + bytes.size());
    }();
    Bytes bytes = stored;
    const bool is_sealed = in.below(2) == 0;
    const bool verifies = in.below(2) == 0;
    if (in.one_in(16)) bytes.resize(in.bits() % (bytes.size() + 1));
    while (!in.is_empty() && !bytes.empty()) {
        // Half of all changes in the header, which says what the rest means, and some at the end, where notes are.
        const std::size_t part = in.below(2) ? bytes.size() : std::min(bytes.size(), sizeof(detail::FileHeader));
        const std::size_t most = std::min<std::size_t>(part, in.one_in(8) ? 80 : part);
        const std::size_t at = in.bits() % most + (part == bytes.size() ? part - most : 0);
        switch (in.below(4)) {
            case 0:
                bytes[at] = char(in.byte());
                break;
            case 1:
                bytes[at] = char(bytes[at] + 1 - 2 * int(in.below(2)));
                break;
            case 2: {  // a number, where numbers lie
                const std::uint32_t word = in.one_in(2) ? in.bits() : 0xffffffffu << in.below(32);
                if (at / 4 * 4 + 4 <= bytes.size()) std::memcpy(bytes.data() + at / 4 * 4, &word, 4);
                break;
            }
            default: {  // something else of the file
                const std::size_t from = in.bits() % bytes.size();
                const std::size_t count = std::min<std::size_t>({in.byte(), bytes.size() - at, bytes.size() - from});
                std::memmove(bytes.data() + at, bytes.data() + from, count);
            }
        }
    }
    if (is_sealed && bytes.size() >= sizeof(detail::FileHeader)) bytes = with_sealed_notes(sealed(std::move(bytes)));
    try {
        const auto opened = open<Hierarchy>(std::as_bytes(std::span(bytes)), {.verify_checksums = verifies});
        read_notes(std::as_bytes(std::span(bytes)));
        pictures(opened, triangles, 16);
        if constexpr (DrawableWith<Hierarchy, Triangle, CoverageRenderer>) {
            CoverageRenderer renderer;
            auto viewer = make_viewer(opened, triangles, renderer);
            viewer.frame({.camera = Camera::perspective({0.4, 0.6, 1.8}, {0.5, 0.5, 0.5}, {0, 1, 0}, 1),
                          .width = 24,
                          .height = 24});
        }
    } catch (const std::runtime_error&) {
    } catch (const std::invalid_argument&) {  // the viewer: other primitives
    }
}

}  // namespace

void run(std::span<const std::uint8_t> bytes) {
    Input in(bytes);
    switch (in.below(5)) {
        case 0:
            return open_changed<OctreeOfCubes>(in);
        case 1:
            return open_changed<OctreeOfTensors>(in);
        case 2:
            return open_changed<ExactSharedOctree>(in);
        case 3:
            return open_changed<BspOfPooledCubes>(in);
        default:
            return open_changed<OctreeOfBspsOfCubes>(in);
    }
}

}  // namespace farfield::fuzz
