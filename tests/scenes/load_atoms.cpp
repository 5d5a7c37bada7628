#include "files.hpp"
#include "scenes/load/element.hpp"

using namespace farfield;
using namespace farfield::scenes;
using namespace farfield::scenes::test;

namespace {

Scene read(const std::string& name, const std::string& content) {
    const TemporaryDirectory directory;
    LoadOptions options = unlit();
    options.sphere_triangle_budget = 20;  // icosahedra
    return load(directory.write(name, content), options);
}

std::string failure(const std::string& name, const std::string& content) {
    const TemporaryDirectory directory;
    return outcome(directory.write(name, content));
}

bool contains(const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
}

std::uint64_t atoms(const Scene& scene) {
    return triangle_count(scene) / 20;
}

glm::vec3 center(const Scene& scene, std::size_t atom) {
    Box box = Box::empty();
    for (std::size_t t = 20 * atom; t < 20 * (atom + 1); ++t) box.add(scene.groups[0].triangles[t].bounds());
    return box.center();
}

Rgba8 color(const Scene& scene, std::size_t atom) {
    return scene.groups[0].triangles[20 * atom].rgba[0];
}

const std::string nitrogen = "ATOM      1  N   MET A  25      51.748  19.748  27.301  1.00 10.81           N\n";
const std::string carbon_a = "ATOM      2  CA AMET A  25      51.216  19.092  28.509  0.50 10.64           C\n";
const std::string carbon_b = "ATOM      3  CA BMET A  25      52.216  19.092  28.509  0.50 10.64           C\n";
const std::string calcium = "HETATM    4 CA    CA A  99       1.000   2.000   3.000\n";

}  // namespace

TEST_CASE("PDB: first model, first alternate, elements also from names", "[scenes][load]") {
    const Scene scene = read("test.pdb", "MODEL        1\n" + nitrogen + carbon_a + carbon_b + calcium +
                                             "ENDMDL\nMODEL        2\n" + nitrogen + "ENDMDL\nEND\n");
    REQUIRE(atoms(scene) == 3);
    CHECK(glm::length(center(scene, 1) - glm::vec3(51.216f, 19.092f, 28.509f)) < 1e-3f);
    CHECK(color(scene, 0) == find_element("N")->color);
    CHECK(color(scene, 1) == find_element("C")->color);
    CHECK(color(scene, 2) == find_element("Ca")->color);
    const std::string nameless = "ATOM      2  CA  MET A  25      51.216  19.092  28.509\n";
    CHECK(color(read("test.ent", nameless), 0) == find_element("C")->color);
    const std::string hydrogen = "ATOM      2 HG21 VAL A  25      51.216  19.092  28.509\n";
    CHECK(color(read("test.ent", hydrogen), 0) == find_element("H")->color);
}

TEST_CASE("PDB: what is wrong is said, with its line", "[scenes][load]") {
    CHECK(contains(failure("a.pdb", ""), "no atoms"));
    CHECK(contains(failure("a.pdb", "HEADER\nEND\n"), "no atoms"));
    CHECK(contains(failure("a.pdb", nitrogen + nitrogen.substr(0, 50) + "\n"), "line 2"));
    CHECK(contains(failure("a.pdb", "ATOM      1  N   MET A  25      51.x48  19.748  27.301\n"), "line 1: '51.x48'"));
    CHECK(contains(failure("a.pdb", "ATOM      1  N   MET A  25         nan  19.748  27.301\n"), "not finite"));
}

TEST_CASE("atoms get finer spheres where there is room for them", "[scenes][load]") {
    const TemporaryDirectory directory;
    const auto file = directory.write("test.pdb", nitrogen);
    LoadOptions options;
    options.sphere_triangle_budget = 79;
    CHECK(triangle_count(load(file, options)) == 20);
    options.sphere_triangle_budget = 80;
    CHECK(triangle_count(load(file, options)) == 80);
    CHECK(triangle_count(load(file)) == 320);
    options.sphere_triangle_budget = 0;
    CHECK(triangle_count(load(file, options)) == 20);
}

TEST_CASE("XYZ: elements, numbered types, first frame", "[scenes][load]") {
    const Scene scene = read("test.xyz", "2\nwater, in part\nO 0 0 0\nH 0.96 0 0 17\n2\nnext\nO 9 9 9\nH 9 9 9\n");
    REQUIRE(atoms(scene) == 2);
    CHECK(color(scene, 0) == find_element("O")->color);
    CHECK(color(scene, 1) == find_element("H")->color);
    const Scene types = read("test.xyz", "2\n\n1 0 0 0\n2 1 0 0\n");
    CHECK_FALSE(color(types, 0) == color(types, 1));
    CHECK(color(read("test.xyz", "1\n\nXx 0 0 0\n"), 0) == unknown_element.color);
    CHECK(contains(failure("a.xyz", ""), "empty"));
    CHECK(contains(failure("a.xyz", "0\n\n"), "no atoms"));
    CHECK(contains(failure("a.xyz", "x\n\nO 0 0 0\n"), "line 1"));
    CHECK(contains(failure("a.xyz", "2\n\nO 0 0 0 xxxxxxxxxx\n"), "ends after 1 of 2"));
    CHECK(contains(failure("a.xyz", "2\n\nO 0 0 0\nH 0 0\n"), "line 4"));
    CHECK(contains(failure("a.xyz", "1\n\nO 0 inf 0\n"), "atom 0 is not finite"));
    CHECK(contains(failure("a.xyz", "18446744073709551615\n\nO 0 0 0\n"), "claims"));
}

TEST_CASE("LAMMPS dump: plain, unwrapped and scaled, tilted boxes", "[scenes][load]") {
    const std::string head =
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 10\n0 20\n-5 5\n";
    const Scene plain = read("a.dump", head + "ITEM: ATOMS id type x y z\n1 1 1 2 3\n2 2 4 5 4\n");
    REQUIRE(atoms(plain) == 2);
    CHECK(glm::length(center(plain, 0) - glm::vec3(1, 2, 3)) < 1e-4f);
    CHECK_FALSE(color(plain, 0) == color(plain, 1));
    const Scene scaled = read("a.lammpstrj", head + "ITEM: ATOMS id type xs ys zs\n1 1 .5 .5 .5\n2 1 0 0 0\n");
    CHECK(glm::length(center(scaled, 0) - glm::vec3(5, 10, 0)) < 1e-4f);
    // xy = 2, xz = -1, yz = 3: the box itself is 10 x 20 x 10 from the origin.
    const Scene tilted =
        read("a.dump",
             "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS xy xz yz pp pp pp\n-1 12 2\n0 "
             "23 -1\n0 10 3\nITEM: ATOMS element xs ys zs radius\nC 1 1 1 0.5\nN 0 0 0 0.25\n");
    CHECK(glm::length(center(tilted, 0) - glm::vec3(10 + 2 - 1, 20 + 3, 10)) < 1e-4f);
    CHECK(glm::length(center(tilted, 1)) < 1e-4f);
    CHECK(color(tilted, 0) == find_element("C")->color);
    CHECK(contains(failure("a.dump", ""), "empty"));
    CHECK(contains(failure("a.dump", head), "ends before its atoms"));
    CHECK(contains(failure("a.dump", head + "ITEM: ATOMS id type vx vy vz\n"), "no columns"));
    CHECK(
        contains(failure("a.dump", head + "ITEM: ATOMS id type x y z\n1 1 1.000 2.000 3.000\n"), "ends after 1 of 2"));
    CHECK(contains(failure("a.dump", head + "ITEM: ATOMS id type x y z\n1 1 1 2 3\n2 1 1 2\n"), "line 11"));
    CHECK(contains(failure("a.dump", "ITEM: NUMBER OF ATOMS\n99999999999\nITEM: ATOMS x y z\n1 2 3\n"), "claims"));
}

TEST_CASE("LAMMPS data: the style of atoms, said or guessed", "[scenes][load]") {
    const std::string head = "title\n\n2 atoms\n1 atom types\n\n0 1 xlo xhi\n\n";
    for (const char* section :
         {"Atoms # full\n\n1 7 1 -0.5 1 2 3\n2 7 2 0.5 4 5 6\n", "Atoms\n\n1 7 1 -0.5 1 2 3\n2 7 2 0.5 4 5 6\n",
          "Atoms # atomic\n\n1 1 1 2 3 0 0 0\n2 2 4 5 6 0 0 0\n",
          "Atoms\n\n1 1 -0.5 1 2 3\n2 2 0.5 4 5 6\n\nVelocities\n\n1 0 0 0\n",
          "Atoms # sphere\n\n1 1 1.0 1.0 1 2 3\n2 2 1.0 1.0 4 5 6\n"}) {
        const Scene scene = read("a.data", head + section);
        REQUIRE(atoms(scene) == 2);
        CHECK(glm::length(center(scene, 0) - glm::vec3(1, 2, 3)) < 1e-4f);
        CHECK_FALSE(color(scene, 0) == color(scene, 1));
    }
    CHECK(contains(failure("a.lmp", ""), "empty"));
    CHECK(contains(failure("a.lmp", head), "no section Atoms"));
    CHECK(contains(failure("a.lmp", head + "Atoms # atomic\n\n1 1 1 2 3000000\n"), "ends after 1 of 2"));
    CHECK(contains(failure("a.lmp", "t\nAtoms\n\n1 1 1 2 3\n"), "before their number"));
    CHECK(contains(failure("a.lmp", "t\n99999999999 atoms\nAtoms\n\n1 1 1 2 3\n"), "claims"));
}
