// Files of others: what each must give is written in the README beside them.
#include "scenes/load/load.hpp"

#include "files.hpp"
#include "scenes/load/load_detail.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

namespace {

struct Expected {
    const char* file;
    std::uint64_t triangles;
};

}  // namespace

TEST_CASE("meshes of others have the triangles that their list says", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    const auto expected = GENERATE(
        // Two nodes of Mountains share one mesh, and some of 2CylinderEngine's do: more than the list's meshes.
        values<Expected>({{"meshes/bun_zipper.ply", 69451},
                          {"meshes/bun_zipper_res4.ply", 948},
                          {"meshes/colored_airplane.ply", 10796},
                          {"meshes/dragon_vrip_res3.ply", 47794},
                          {"meshes/happy-buddha-100k.obj", 100000},
                          {"meshes/pirate.obj", 5010},
                          {"meshes/snowden-bust-lo-derived.obj", 37629},
                          {"meshes/spot.obj", 5856},
                          {"off/abstr.off", 68},
                          {"off/assimp-Cube.off", 12},
                          {"off/ballA.off", 3796},
                          {"off/cgal-bgl-full.off", 4},
                          {"off/cgal-dino.off", 7828},
                          {"off/cgal-mesh_with_colors.off", 6},
                          {"off/cone.off", 40},
                          {"off/cube.off", 12},
                          {"off/dodec.off", 36},
                          {"off/dodec2.off", 36},
                          {"off/facecube.off", 12},
                          {"off/hypercube.off", 24},
                          {"off/mushroom.off", 448},
                          {"off/pmp-fandisk_quads.off", 1528},
                          {"off/tref.off", 640},
                          {"off/vertcube.off", 12},
                          {"architecture/geomview-office.oogl", 7219},
                          {"architecture/house.glb", 10497},
                          {"architecture/quake-e1m1-derived.obj", 14515},
                          {"vegetation/PalmTree.gltf", 10124},
                          {"vegetation/grass-trees.glb", 380},
                          {"vegetation/low-poly-tree.glb", 1126},
                          {"terrain/Mountains.gltf", 2 * 12800},
                          {"gltf/2CylinderEngine.glb", 121496},
                          {"gltf/BoxVertexColors.glb", 12},
                          {"gltf/Duck.glb", 4212},
                          {"gltf/VertexColorTest/VertexColorTest.gltf", 36},
                          {"gltf/many-cubes.gltf", 6012}}));
    CAPTURE(expected.file);
    CHECK(outcome(folder / expected.file).empty());
    CHECK(triangle_count(load(folder / expected.file)) == expected.triangles);
}

TEST_CASE("molecules and particles of others have the atoms that their list says", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    // 1LCD: the first of three models.
    const auto expected = GENERATE(values<Expected>({{"molecules/1A8O.pdb", 644},
                                                     {"molecules/1LCD.pdb", 1137},
                                                     {"molecules/2XHE.pdb", 6315},
                                                     {"molecules/3sn6.pdb", 10274},
                                                     {"molecules/7pbl.pdb", 31396},
                                                     {"molecules/il2.pdb", 2084},
                                                     {"points/M_protein.xyz", 1561},
                                                     {"points/lammps-albite_triclinic.dump", 17},
                                                     {"points/lammps-thylakoid.data", 4001}}));
    CAPTURE(expected.file);
    LoadOptions options;
    options.sphere_triangle_budget = 0;
    CHECK(triangle_count(load(folder / expected.file, options)) == 20 * expected.triangles);
}

TEST_CASE("colors of others' files arrive", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    const auto colors = [&](const char* file) {
        std::vector<std::uint32_t> seen;
        const Scene scene = load(folder / file, unlit());
        for (const VertexColoredTriangle& t : scene.groups[0].triangles) {
            for (const Rgba8 c : t.rgba) seen.push_back(c.r | static_cast<std::uint32_t>(c.g << 8 | c.b << 16));
        }
        std::sort(seen.begin(), seen.end());
        return std::unique(seen.begin(), seen.end()) - seen.begin();
    };
    CHECK(colors("off/cgal-bgl-full.off") == 4);
    CHECK(colors("off/facecube.off") == 6);
    CHECK(colors("off/vertcube.off") == 8);
    CHECK(colors("meshes/colored_airplane.ply") > 100);
    CHECK(colors("gltf/BoxVertexColors.glb") > 3);
    CHECK(colors("gltf/Duck.glb") > 20);
    CHECK(colors("vegetation/grass-trees.glb") >= 3);
    CHECK(colors("vegetation/PalmTree.gltf") >= 2);
    CHECK(colors("meshes/bun_zipper_res4.ply") == 1);
}

TEST_CASE("malformed files give a scene that makes sense or a message", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    std::vector<std::string> loaded;
    std::size_t refused = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder / "malformed")) {
        if (outcome(entry.path()).empty()) {
            loaded.push_back(entry.path().filename().string());
        } else {
            ++refused;
        }
    }
    std::sort(loaded.begin(), loaded.end());
    CHECK(loaded == std::vector<std::string>{"biopython__disordered.pdb", "draco__deg_faces.obj",
                                             "draco__float_inf_point_cloud.ply", "pymol__odd01.pdb",
                                             "trimesh__negative_indices.obj"});
    CHECK(refused >= 14);
}

TEST_CASE("files cut short give a scene that makes sense or a message", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    const std::string file =
        GENERATE(as<std::string>{}, "meshes/bun_zipper_res4.ply", "meshes/colored_airplane.ply", "meshes/spot.obj",
                 "meshes/pirate.obj", "off/mushroom.off", "off/cgal-bgl-full.off", "off/vertcube.off",
                 "off/hypercube.off", "gltf/BoxVertexColors.glb", "gltf/Duck.glb", "vegetation/grass-trees.glb",
                 "gltf/VertexColorTest/VertexColorTest.gltf", "molecules/1A8O.pdb", "points/M_protein.xyz",
                 "points/lammps-albite_triclinic.dump", "points/lammps-thylakoid.data");
    CAPTURE(file);
    const std::string whole = content_of(folder / file);
    REQUIRE(whole.size() > 100);
    const TemporaryDirectory directory;
    const std::string name = std::filesystem::path(file).filename().string();
    std::size_t refused = 0;
    // Near both ends every byte counts; in between, a few cuts.
    std::vector<std::size_t> lengths;
    for (std::size_t i = 0; i < 24; ++i) {
        lengths.push_back(i);
        lengths.push_back(whole.size() * i / 24);
        lengths.push_back(whole.size() - 1 - i);
    }
    for (const std::size_t length : lengths) {
        CAPTURE(length);
        refused += !outcome(directory.write(name, std::string_view(whole).substr(0, length))).empty();
    }
    CHECK(refused > 0);
}

TEST_CASE("files with bytes changed give a scene that makes sense or a message", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    const std::string file =
        GENERATE(as<std::string>{}, "meshes/bun_zipper_res4.ply", "meshes/colored_airplane.ply", "off/vertcube.off",
                 "off/cgal-mesh_with_colors.off", "gltf/BoxVertexColors.glb", "vegetation/grass-trees.glb",
                 "points/lammps-albite_triclinic.dump", "malformed/trimesh__negative_indices.obj");
    CAPTURE(file);
    const std::string whole = content_of(folder / file);
    const TemporaryDirectory directory;
    const std::string name = std::filesystem::path(file).filename().string();
    std::mt19937 random(20260);  // the engine, unlike distributions, is the same everywhere
    for (int round = 0; round < 60; ++round) {
        CAPTURE(round);
        std::string changed = whole;
        // Headers are where it hurts.
        const std::size_t reach = round % 2 == 0 ? std::min<std::size_t>(whole.size(), 600) : whole.size();
        for (int i = 0; i < 3; ++i) {
            changed[random() % reach] =
                round % 3 == 0 ? static_cast<char>(random() % 256) : "0123456789-.eE \n"[random() % 16];
        }
        outcome(directory.write(name, changed));
    }
}

TEST_CASE("what is no readable file of a known kind is refused", "[scenes][load]") {
    const TemporaryDirectory directory;
    const auto contains = [](const std::string& text, const char* part) {
        return text.find(part) != std::string::npos;
    };
    CHECK(contains(outcome(directory.path() / "missing.off"), "no such file"));
    CHECK(contains(outcome(directory.path() / "missing.glb"), "no such file"));
    CHECK(contains(outcome(directory.write("scene.docx", "x")), "unknown extension '.docx'"));
    CHECK(contains(outcome(directory.write("scene", "x")), "unknown extension '', and nothing known inside"));
    std::filesystem::create_directory(directory.path() / "folder.ply");
    CHECK(contains(outcome(directory.path() / "folder.ply"), "not a regular file"));
}

TEST_CASE("light darkens a mesh's colors and nothing else", "[scenes][load]") {
    const TemporaryDirectory directory;
    const auto file =
        directory.write("a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 0 1\n3 0 2 1 200 100 0\n3 0 1 2 200 100 0\n");
    const auto plain = load(file, unlit()).groups[0].triangles, lit = load(file).groups[0].triangles;
    REQUIRE(lit.size() == 2);
    CHECK(plain[0].rgba[0] == Rgba8{200, 100, 0});
    CHECK(lit[0].vertices == plain[0].vertices);
    CHECK(lit[0].rgba[0].r > lit[1].rgba[0].r);  // the first faces up
    CHECK(lit[0].rgba[0].r <= 200);
    CHECK(lit[1].rgba[0].b == 0);
}

TEST_CASE("where another axis is up, light comes from above and from the same side", "[scenes][load]") {
    const TemporaryDirectory directory;
    // A direction with y up, as a file says it where the axis is up.
    const auto in_file = [](glm::vec3 p, glm::vec3 up) {
        if (up.z == 1) return glm::vec3(p.x, -p.z, p.y);
        if (up.z == -1) return glm::vec3(p.x, p.z, -p.y);
        if (up.x == 1) return glm::vec3(p.y, p.x, -p.z);
        return p;
    };
    const auto text = [&](const std::vector<glm::vec3>& points, glm::vec3 up) {
        std::string lines;
        for (const glm::vec3 p : points) {
            const glm::vec3 q = in_file(p, up);
            lines += std::to_string(q.x) + " " + std::to_string(q.y) + " " + std::to_string(q.z) + "\n";
        }
        return lines;
    };
    const std::vector<glm::vec3> tetrahedron{{0, 0, 0}, {1, 0.25f, 0}, {0.5f, 2, 0}, {0.25f, 0.5f, 1}};
    std::vector<glm::vec3> slope;  // of points without normals
    for (int i = 0; i < 64; ++i) {
        const auto x = float(i % 8), z = float(i / 8);
        slope.emplace_back(x, 0.25f * x - 0.125f * z, z);
    }
    const auto colors = [&](glm::vec3 up) {
        std::vector<Rgba8> all;
        const std::string faces = "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n";
        for (const auto& [name, content] : {std::pair("mesh.off", "OFF\n4 4 0\n" + text(tetrahedron, up) + faces),
                                            std::pair("cloud.pts", text(slope, up))}) {
            LoadOptions options;
            options.up = up;
            const Scene scene = load(directory.write(name, content), options);
            CHECK(scene.up == up);
            for (const VertexColoredTriangle& t : scene.groups[0].triangles) all.push_back(t.rgba[0]);
        }
        return all;
    };
    const std::vector<Rgba8> expected = colors({0, 1, 0});
    REQUIRE(expected.size() == 4 + 4 * slope.size());
    CHECK(expected[0] != expected[1]);
    for (const glm::vec3 up : {glm::vec3(0, 0, 1), glm::vec3(0, 0, -1), glm::vec3(1, 0, 0)}) {
        const std::vector<Rgba8> found = colors(up);
        REQUIRE(found.size() == expected.size());
        std::size_t different = 0;
        for (std::size_t i = 0; i < found.size(); ++i) different += std::abs(int(found[i].r) - int(expected[i].r)) > 1;
        INFO("up " << up.x << " " << up.y << " " << up.z);
        CHECK(different == 0);
    }
    // The sky is above atoms, too.
    LoadOptions options;
    options.up = {0, 0, 1};
    const Scene atom = load(directory.write("one.xyz", "1\none\nC 0 0 0\n"), options);
    glm::vec3 bright(0), dark(0);
    for (const VertexColoredTriangle& t : atom.groups[0].triangles) {
        (t.rgba[0].b > 110 ? bright : dark) += t.vertices[0];
    }
    CHECK(bright.z > dark.z);
}

TEST_CASE("files without a known extension are known by their content", "[scenes][load]") {
    const TemporaryDirectory directory;
    const char* const contents[] = {
        "# by hand\nCOFF\n3 1 0\n0 0 0 1 0 0 1\n1 0 0 1 0 0 1\n0 1 0 1 0 0 1\n3 0 1 2\n",
        "{ LIST { OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2 } }",
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
        "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "# Blender\n\nmtllib none.mtl\no x\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "3\ncomment\nC 0 0 0\nH 1 0 0\nH 0 1 0\n",
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id type x "
        "y "
        "z\n1 1 0 0 0\n",
        "LAMMPS\n\n1 atoms\n1 atom types\n\nAtoms # atomic\n\n1 1 0 0 0\n",
        "HEADER    X\nATOM      1  CA  ALA A   1      11.104   6.134  -6.504  1.00  0.00           C\n",
        "1,2,3\n4,5,6\n"};
    for (const char* const content : contents) {
        CAPTURE(content);
        CHECK(outcome(directory.write("scene", content)).empty());
        CHECK(outcome(directory.write("scene.001", content)).empty());
    }
}

TEST_CASE("packed files are unpacked", "[scenes][load]") {
    // OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n, by gzip -9n.
    const unsigned char packed[] = {0x1f, 0x8b, 0x08, 0x00, 0x00, 0x00, 0x00, 0x00, 0x02, 0x03, 0xf3, 0x77,
                                    0x73, 0xe3, 0x32, 0x56, 0x30, 0x54, 0x30, 0xe0, 0x32, 0x50, 0x00, 0x42,
                                    0x2e, 0x43, 0x30, 0x69, 0x00, 0x16, 0x31, 0x56, 0x00, 0xd1, 0x46, 0x5c,
                                    0x00, 0x02, 0x15, 0x14, 0xa5, 0x24, 0x00, 0x00, 0x00};
    const std::string bytes(reinterpret_cast<const char*>(packed), sizeof packed);
    const TemporaryDirectory directory;
    for (const char* name : {"scene.off.gz", "scene.off", "scene.gz", "scene", "scene.OFF.GZ"}) {
        CAPTURE(name);
        const Scene scene = load(directory.write(name, bytes));
        CHECK(triangle_count(scene) == 1);
        CHECK(scene.name == "scene");
    }
    CHECK(outcome(directory.write("padded.off.gz", bytes + std::string(100, '\0'))).empty());
    CHECK(outcome(directory.write("cut.off.gz", bytes.substr(0, bytes.size() - 9))).find("cut short") !=
          std::string::npos);
    std::string damaged = bytes;
    damaged[20] = static_cast<char>(damaged[20] ^ 0x55);
    CHECK(outcome(directory.write("damaged.off.gz", damaged)).find("gzip") != std::string::npos);
}

TEST_CASE("numbers beyond what a double holds are large or small, as they are written", "[scenes][load]") {
    using scenes::detail::number;
    CHECK(number<double>("1e999") == std::numeric_limits<double>::infinity());
    CHECK(number<double>("-1e999") == -std::numeric_limits<double>::infinity());
    CHECK(number<double>("1e-999") == 0.0);
    CHECK(number<double>("0." + std::string(400, '0') + '1') == 0.0);
    CHECK(number<double>("0." + std::string(400, '0') + "1e401") == Approx(1.0));
    CHECK(number<double>(std::string(400, '1')) == std::numeric_limits<double>::infinity());
    CHECK(number<double>("1e99999999999999999999") == std::numeric_limits<double>::infinity());
    CHECK(number<double>("1e-99999999999999999999") == 0.0);
    CHECK(number<double>("+1.5") == 1.5);
    CHECK_FALSE(number<double>("1.5f"));
    CHECK_FALSE(number<double>("1.#IND"));
}

TEST_CASE("small files of meshes that hide faults give what they say", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    const auto triangles = [&](const char* file) {
        return load(folder / "reports" / file, unlit()).groups[0].triangles;
    };
    const auto area = [&](const char* file) {
        float sum = 0.0f;
        for (const auto& t : triangles(file)) {
            sum += 0.5f * glm::length(glm::cross(t.vertices[1] - t.vertices[0], t.vertices[2] - t.vertices[0]));
        }
        return sum;
    };
    CHECK(triangles("nokd.obj")[0].rgba[0] == Rgba8{255, 255, 255});
    CHECK(triangles("comment_end.obj").size() == 2);
    CHECK(area("ply-concave.ply") == Approx(7.0f));
    CHECK(triangles("ply-tristrips.ply").size() == 4);
    CHECK(area("ply-tristrips.ply") == Approx(2.0f));
    const Scene terrain = load(folder / "reports" / "ply-utm.ply");
    CHECK(triangle_count(terrain) == 3200);
    CHECK(std::abs(terrain.origin.x) > 1e5);
    CHECK(bounds(terrain).largest_side() < 1e3f);
    std::vector<float> heights;
    for (const auto& t : terrain.groups[0].triangles) {
        for (const glm::vec3& v : t.vertices) heights.push_back(v.x);
    }
    std::sort(heights.begin(), heights.end());
    CHECK(std::unique(heights.begin(), heights.end()) - heights.begin() ==
          41);  // columns that are as many as they were
    CHECK(outcome(folder / "reports" / "huge.off").find("vertex 1 is too far away to be drawn") != std::string::npos);
    // A cube of 1e19 has the light of one of 1.
    const auto lit = load(folder / "reports" / "cube-1e19.off").groups[0].triangles;
    CHECK_FALSE(lit[0].rgba == lit[2].rgba);
}
