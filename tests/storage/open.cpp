#include "farfield/storage/open.hpp"

#include <algorithm>
#include <memory>

#include "catch.hpp"
#include "farfield/build.hpp"
#include "farfield/cost_model/measured_time.hpp"
#include "farfield/storage/mapped_file.hpp"
#include "farfield/storage/save.hpp"
#include "files.hpp"

using namespace farfield;
using namespace farfield::detail;

namespace {

template <class T>
bool same_bytes(std::span<const T> a, std::span<const T> b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

template <class H>
void require_same(const H& a, const H& b) {
    CHECK(same_bytes(a.nodes(), b.nodes()));
    CHECK(same_bytes(a.order(), b.order()));
    CHECK(same_bytes(a.fragments().first_vertex, b.fragments().first_vertex));
    CHECK(same_bytes(a.fragments().vertices, b.fragments().vertices));
    CHECK(same_bytes(a.fragments().colors, b.fragments().colors));
    CHECK(a.keeps_strict_order() == b.keeps_strict_order());
    if constexpr (!std::is_empty_v<typename H::node_data>) CHECK(same_bytes(a.all_node_data(), b.all_node_data()));
    if constexpr (!std::is_empty_v<typename H::stand_in_data>) CHECK(same_bytes(a.stand_ins(), b.stand_ins()));
    if constexpr (!std::is_empty_v<typename H::pool_element>) CHECK(same_bytes(a.pool(), b.pool()));
    CHECK(bytes_of(a.partition_policy()) == bytes_of(b.partition_policy()));
    CHECK(bytes_of(a.approximation_policy()) == bytes_of(b.approximation_policy()));
    CHECK(bytes_of(a.cost_policy()) == bytes_of(b.cost_policy()));
    CHECK(bytes_of(a.report()) == bytes_of(b.report()));
    CHECK(bytes_of(a.whole_work()) == bytes_of(b.whole_work()));
    CHECK(bytes_of(a.root_cell()) == bytes_of(b.root_cell()));
    CHECK(bytes_of(a.bounds()) == bytes_of(b.bounds()));
    CHECK(a.origin() == b.origin());
    CHECK(a.item_count() == b.item_count());
    CHECK(a.primitive_count() == b.primitive_count());
    CHECK(a.fingerprint() == b.fingerprint());
    CHECK((a.root_stand_in() == nullptr) == (b.root_stand_in() == nullptr));
    CHECK(a.bytes() == b.bytes());
}

template <class H>
std::string refused(const std::filesystem::path& path, const OpenOptions& options = {}) {
    return refusal(path, [&](const auto& p) { open<H>(p, options); });
}
template <class H>
std::string refused(const TemporaryDirectory& directory, const Bytes& bytes, const OpenOptions& options = {}) {
    write_file(directory / "changed", bytes);
    return refused<H>(directory / "changed", options);
}

}  // namespace

TEMPLATE_TEST_CASE("what was saved is opened", "", OctreeOfCubes, OctreeOfTensors, SharedOctreeOfCubes, ExactOctree,
                   ExactSharedOctree, HalvesOfPooledCubes, ExactBsp, BspOfPooledCubes, OctreeOfBspsOfCubes) {
    const TemporaryDirectory directory;
    for (const std::size_t count : {0u, 1u, 2u, 30u, 3000u}) {
        INFO(count << " triangles");
        const auto triangles = scene(count);
        const auto h = built<TestType>(triangles);
        save(h, directory / "h");
        for (const bool verify : {true, false}) {
            const auto opened = open<TestType>(directory / "h", {.verify_checksums = verify});
            CHECK(opened.is_from_file());
            CHECK_FALSE(h.is_from_file());
            require_same(h, opened);
            CHECK(pictures(opened, triangles) == pictures(h, triangles));
        }
    }
}

TEST_CASE("the hierarchy over nothing is opened") {
    const TemporaryDirectory directory;
    save(HalvesOfPooledCubes(), directory / "h");
    require_same(open<HalvesOfPooledCubes>(directory / "h"), HalvesOfPooledCubes());
}

TEST_CASE("primitives in the hierarchy's order need no list of it in the file") {
    const TemporaryDirectory directory;
    auto triangles = scene(2000);
    const auto h = build_in_place<OctreeOfCubes>(triangles);
    save(h, directory / "h");
    const auto opened = open<OctreeOfCubes>(directory / "h");
    CHECK(opened.order().empty());
    require_same(h, opened);
    CHECK(pictures(opened, triangles) == pictures(h, triangles));
}

TEST_CASE("options of the policies come from the file") {
    const TemporaryDirectory directory;
    const auto triangles = scene(500);
    using H = SpatialHierarchy<Octree, ColorCube, MeasuredTime>;
    const ColorCube cube{.samples = 3,
                         .inner = ColorCube::Inner::direct,
                         .opacity = ColorCube::Opacity::thresholded,
                         .coverage_threshold = 0.25f};
    save(build<H>(triangles, {.partition = {.max_depth = 5}, .approximation = cube, .cost_model = {.splat = 1.5f}}),
         directory / "h");
    const auto opened = open<H>(directory / "h");
    CHECK(opened.partition_policy().max_depth == 5);
    CHECK(opened.approximation_policy().samples == 3);
    CHECK(opened.approximation_policy().inner == ColorCube::Inner::direct);
    CHECK(opened.approximation_policy().opacity == ColorCube::Opacity::thresholded);
    CHECK(opened.approximation_policy().coverage_threshold == 0.25f);
    CHECK(opened.cost_policy().splat == 1.5f);
}

TEST_CASE("arrays lie in the mapping, one after the other, and live as long as a copy") {
    const TemporaryDirectory directory;
    const auto triangles = scene(1000);
    save(built<OctreeOfCubes>(triangles), directory / "h");
    const FileHeader header = header_of(read_file(directory / "h"));
    OctreeOfCubes copy;
    {
        const auto opened = open<OctreeOfCubes>(directory / "h");
        copy = opened;
    }
    const auto* const nodes = reinterpret_cast<const std::byte*>(copy.nodes().data());
    const auto* const start = nodes - header.sections[std::size_t(Section::nodes)].offset;
    CHECK(std::memcmp(start, file_magic.data(), file_magic.size()) == 0);
    CHECK(reinterpret_cast<const std::byte*>(copy.stand_ins().data()) ==
          start + header.sections[std::size_t(Section::stand_ins)].offset);
    CHECK(reinterpret_cast<const std::byte*>(copy.order().data()) ==
          start + header.sections[std::size_t(Section::order)].offset);
    CHECK(reinterpret_cast<std::uintptr_t>(nodes) % 64 == 0);
    CHECK(pictures(copy, triangles) == pictures(built<OctreeOfCubes>(triangles), triangles));
}

TEST_CASE("a viewer refuses other primitives than those it was built from") {
    const TemporaryDirectory directory;
    auto triangles = scene(300);
    save(built<OctreeOfCubes>(triangles), directory / "h");
    const auto opened = open<OctreeOfCubes>(directory / "h");
    ZBufferRenderer renderer;
    CHECK_NOTHROW(make_viewer(opened, triangles, renderer));
    const auto fewer = scene(299), others = scene(300, 2);
    CHECK_THROWS_AS(make_viewer(opened, fewer, renderer), std::invalid_argument);
    CHECK_THROWS_AS(make_viewer(opened, others, renderer), std::invalid_argument);
    std::swap(triangles.front(), triangles.back());
    CHECK_THROWS_AS(make_viewer(opened, triangles, renderer), std::invalid_argument);
}

TEST_CASE("what is no hierarchy's file says why") {
    const TemporaryDirectory directory;
    CHECK(refused<OctreeOfCubes>(directory / "none") == "No such file or directory");
    CHECK(refused<OctreeOfCubes>(directory / "") == "is a directory");
    CHECK(refused<OctreeOfCubes>(directory, Bytes()) == "is empty");
    const std::string text = "ply\nformat ascii 1.0\n" + std::string(1000, ' ');
    CHECK(refused<OctreeOfCubes>(directory, Bytes(text.begin(), text.end())) == "is not a farfield hierarchy");

    save(OctreeOfCubes(), directory / "h");
    Bytes bytes = read_file(directory / "h");
    bytes[4] = '\n';  // line ends were changed on the way
    CHECK(refused<OctreeOfCubes>(directory, bytes) == "is not a farfield hierarchy");
}

TEST_CASE("files of other policies, versions and machines say so") {
    const TemporaryDirectory directory;
    save(built<OctreeOfCubes>(scene(100)), directory / "h");
    const Bytes bytes = read_file(directory / "h");
    CHECK(refused<SharedOctreeOfCubes>(directory / "h") ==
          "was saved with another partition: expected 0x4f430001 (OC), found 0x4f430002 (OC)");
    CHECK(refused<ExactOctree>(directory / "h") ==
          "was saved with another approximation: expected 0x45580001 (EX), found 0x43430003 (CC)");
    CHECK(refused<SpatialHierarchy<Octree, ColorCube, MeasuredTime>>(directory / "h") ==
          "was saved with another cost model: expected 0x4d540002 (MT), found 0x54430001 (TC)");

    FileHeader header = header_of(bytes);
    for (const std::uint32_t version : {1u, 4u}) {
        header.version = version;
        CHECK(refused<OctreeOfCubes>(directory, sealed(bytes, header)) ==
              "has format version " + std::to_string(version) +
                  ", this program reads version 5: build and save it again");
    }
    header = header_of(bytes);
    header.byte_order = 0x04030201;
    CHECK(refused<OctreeOfCubes>(directory, sealed(bytes, header)) == "was saved on a machine of the other byte order");
    header = header_of(bytes);
    header.sections[std::size_t(Section::stand_ins)].record_bytes = 48;
    header.sections[std::size_t(Section::stand_ins)].count /= 2;
    CHECK(refused<OctreeOfCubes>(directory, sealed(bytes, header)) ==
          "was saved with other records: section 'stand-ins' has 48 bytes a record, expected 24");
}

TEST_CASE("a truncated file says how much is left of it") {
    const TemporaryDirectory directory;
    save(built<OctreeOfCubes>(scene(100)), directory / "h");
    const Bytes bytes = read_file(directory / "h");
    std::vector<std::size_t> sizes;
    for (std::size_t size = 1; size < 600; ++size) sizes.push_back(size);
    const FileHeader header = header_of(bytes);
    for (const SectionEntry& s : header.sections) {
        for (std::size_t size : {s.offset - 1, s.offset, s.offset + 1, s.offset + s.bytes()}) sizes.push_back(size);
    }
    for (std::size_t size = 600; size < bytes.size(); size += 97) sizes.push_back(size);
    sizes.push_back(bytes.size() - 1);
    for (const std::size_t size : sizes) {
        if (size >= bytes.size()) continue;
        const std::string why =
            refused<OctreeOfCubes>(directory, Bytes(bytes.begin(), bytes.begin() + std::ptrdiff_t(size)));
        CHECK(why.rfind("is truncated: it has " + std::to_string(size) + " bytes", 0) == 0);
    }
    Bytes longer = bytes;
    longer.push_back(0);
    CHECK(refused<OctreeOfCubes>(directory, longer).rfind("is too long: ", 0) == 0);
    // Where the checksum agrees with the shorter size, what lies outside is found.
    Bytes shorter(bytes.begin(), bytes.end() - 64);
    FileHeader agreeing = header;
    agreeing.file_bytes = shorter.size();
    CHECK(refused<OctreeOfCubes>(directory, sealed(shorter, agreeing)) ==
          "is damaged: section 'order' reaches beyond the end");
}

TEST_CASE("a section that begins behind the file's end is not read") {
    const TemporaryDirectory directory;
    // Up to 63 bytes are left out before a section: it may begin behind the end where the one before it does not.
    for (std::size_t count = 40; count < 80; ++count) {
        save(built<ExactOctree>(scene(count)), directory / "h");
        const Bytes bytes = read_file(directory / "h");
        FileHeader header = header_of(bytes);
        const SectionEntry nodes = header.sections[std::size_t(Section::nodes)];
        const SectionEntry order = header.sections[std::size_t(Section::order)];
        const std::uint64_t end = nodes.offset + nodes.bytes();
        CHECK(order.offset + order.bytes() == bytes.size());
        header.file_bytes = end;
        const Bytes cut(bytes.begin(), bytes.begin() + std::ptrdiff_t(end));
        for (const bool verify : {true, false}) {
            CHECK(refused<ExactOctree>(directory, sealed(cut, header), {.verify_checksums = verify}) ==
                  "is damaged: section 'order' reaches beyond the end");
        }
        // One record more than there is room for.
        header = header_of(bytes);
        header.sections[std::size_t(Section::order)].count += 1;
        CHECK(refused<ExactOctree>(directory, sealed(bytes, header)) ==
              "is damaged: section 'order' reaches beyond the end");
    }
}

TEMPLATE_TEST_CASE("a changed byte is found, wherever it is", "", OctreeOfCubes, HalvesOfPooledCubes,
                   BspOfPooledCubes) {
    const TemporaryDirectory directory;
    save(built<TestType>(scene(40)), directory / "h");
    const Bytes bytes = read_file(directory / "h");
    const FileHeader header = header_of(bytes);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        Bytes changed = bytes;
        changed[i] = char(changed[i] ^ (1 << i % 8));
        const std::string why = refused<TestType>(directory, changed);
        CAPTURE(i, why);
        REQUIRE_FALSE(why.empty());
        for (std::size_t s = 0; s < section_count; ++s) {
            if (header.sections[s].offset <= i && i < header.sections[s].offset + header.sections[s].bytes()) {
                CHECK(why == std::string("is damaged: section '") + section_names[s] +
                                 "' does not have the checksum it was saved with");
            }
        }
    }
}

TEMPLATE_TEST_CASE("what was saved to memory is opened from there", "", OctreeOfCubes, ExactSharedOctree,
                   HalvesOfPooledCubes, OctreeOfBspsOfCubes) {
    for (const std::size_t count : {0u, 1u, 30u, 2000u}) {
        INFO(count << " triangles");
        const auto triangles = scene(count);
        const auto h = built<TestType>(triangles);
        const std::size_t size = saved_size(h);
        // An aligned place in memory, and one that is not.
        std::vector<std::byte> memory(size + 128);
        const auto start = std::size_t(-reinterpret_cast<std::uintptr_t>(memory.data()) % 64);
        for (const std::size_t off : {0u, 1u, 4u, 32u}) {
            INFO("off by " << off);
            const std::span<std::byte> bytes(memory.data() + start + off, size);
            save(h, bytes);
            const auto opened = open<TestType>(std::span<const std::byte>(bytes));
            require_same(h, opened);
            CHECK(opened.is_from_file());
            const auto* const nodes = reinterpret_cast<const std::byte*>(opened.nodes().data());
            CHECK((nodes >= bytes.data() && nodes < bytes.data() + size) == (off == 0));
            // What was copied does not need the bytes any more.
            if (off != 0) std::fill(memory.begin(), memory.end(), std::byte(0xff));
            CHECK(pictures(opened, triangles) == pictures(h, triangles));
        }
    }
}

TEMPLATE_TEST_CASE("a hierarchy with notes is that without, and whoever changes a byte of them is found", "",
                   OctreeOfCubes, HalvesOfPooledCubes, ExactBsp) {
    const TemporaryDirectory directory;
    const Notes notes{{"errors", "0 1 2"}, {"who", ""}};
    const auto h = built<TestType>(scene(40));
    save(h, directory / "without");
    save(h, directory / "with", notes);
    const Bytes without = read_file(directory / "without"), with = read_file(directory / "with");
    const std::size_t end = without.size();
    REQUIRE(std::equal(without.begin(), without.end(), with.begin()));
    require_same(open<TestType>(directory / "with"), h);
    Notes back;
    CHECK(wrong_notes(std::as_bytes(std::span(with)).subspan(end), back).empty());
    CHECK(back == notes);
    std::vector<std::byte> memory(saved_size(h, notes));
    save(h, std::span(memory), notes);
    CHECK(std::memcmp(memory.data(), with.data(), with.size()) == 0);
    require_same(open<TestType>(std::span<const std::byte>(memory)), h);
    for (std::size_t i = end; i < with.size(); ++i) {
        Bytes changed = with;
        changed[i] = char(changed[i] ^ (1 << i % 8));
        const bool is_magic = i < end + notes_magic.size();
        CAPTURE(i - end);
        for (const bool verify : {true, false}) {
            const std::string why = refused<TestType>(directory, changed, {.verify_checksums = verify});
            CHECK(why.rfind(is_magic ? "is too long: " : "", 0) == 0);
            CHECK_FALSE(why.empty());
            CHECK((is_magic || why.find("notes") != std::string::npos));
        }
    }
}

TEST_CASE("memory that is handed over lives as long as a copy of the hierarchy") {
    const auto triangles = scene(300);
    const auto h = built<OctreeOfCubes>(triangles);
    const std::size_t size = saved_size(h);
    const auto memory = std::make_shared<std::vector<FileLine>>(size / sizeof(FileLine) + 1);
    const std::span<std::byte> bytes(memory->front().bytes, size);
    save(h, bytes);
    OctreeOfCubes copy;
    {
        const auto opened = open<OctreeOfCubes>(bytes, {}, memory);
        copy = opened;
    }
    CHECK(memory.use_count() == 2);
    require_same(copy, h);
    copy = {};
    CHECK(memory.use_count() == 1);
}

TEST_CASE("bytes in memory that are no hierarchy say why") {
    const auto h = built<OctreeOfCubes>(scene(100));
    std::vector<std::byte> bytes(saved_size(h));
    save(h, std::span(bytes));
    const auto why = [](std::span<const std::byte> from) -> std::string {
        try {
            open<OctreeOfCubes>(from);
            return {};
        } catch (const std::runtime_error& e) {
            return e.what();
        }
    };
    CHECK(why(bytes).empty());
    CHECK(why({}) == "farfield::open: memory: is empty");
    for (std::size_t size = 1; size < bytes.size(); size += 13) {
        CHECK(why(std::span(bytes).first(size)).rfind("farfield::open: memory: is truncated: ", 0) == 0);
    }
    bytes[700] ^= std::byte(1);
    CHECK(why(bytes).rfind("farfield::open: memory: is damaged: ", 0) == 0);
}
