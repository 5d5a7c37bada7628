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

TEST_CASE("PDB: elements of names that begin in the first column", "[scenes][load]") {
    // Neither residue nor name alone tells: CD of a glutamate is no cadmium, CA of an ion is calcium.
    const auto line = [](const std::string& record, const std::string& name, const std::string& residue) {
        return record + "    1 " + name + " " + residue + " A   1       0.000   0.000   0.000  1.00  0.00\n";
    };
    const auto symbol = [&](const std::string& text, std::size_t atom) {
        const Rgba8 c = color(read("test.pdb", text), atom);
        for (const Element& element : elements) {
            if (element.color == c) return std::string(element.symbol);
        }
        return std::string("?");
    };
    const std::string left = line("ATOM  ", "N   ", "ALA");
    struct Case {
        const char *name, *residue, *symbol;
    };
    for (const Case& c :
         {Case{"CA  ", "ALA", "C"}, Case{"CD  ", "GLU", "C"}, Case{"NE  ", "ARG", "N"}, Case{"HG  ", "SER", "H"},
          Case{"ND1 ", "HIS", "N"}, Case{"HE  ", "ARG", "H"}, Case{"CE  ", "LYS", "C"}, Case{"HB1 ", "ALA", "H"},
          Case{"SD  ", "MET", "S"}, Case{"P   ", " DA", "P"}, Case{"CA  ", " CA", "Ca"}, Case{"ZN  ", " ZN", "Zn"},
          Case{"CL1 ", "LIG", "Cl"}, Case{"CD1 ", "LIG", "C"}, Case{"FE  ", "HEM", "Fe"}, Case{"NA  ", "HEM", "N"},
          Case{"NA  ", " NA", "Na"}}) {
        CAPTURE(c.name, c.residue);
        CHECK(symbol(left + line("HETATM", c.name, c.residue), 1) == c.symbol);
    }
    // In a file that keeps to the columns they decide, but for residues that have no such elements.
    const std::string right = line("ATOM  ", " N  ", "ALA");
    for (const Case& c : {Case{"CD  ", "LIG", "Cd"}, Case{" CD ", "LIG", "C"}, Case{"HG  ", "LIG", "Hg"},
                          Case{"SE  ", "MSE", "Se"}, Case{"1HG2", "THR", "H"}, Case{"CA  ", " CA", "Ca"}}) {
        CAPTURE(c.name, c.residue);
        CHECK(symbol(right + line("HETATM", c.name, c.residue), 1) == c.symbol);
    }
}

TEST_CASE("models and frames that are not drawn are counted", "[scenes][load]") {
    const Scene models = read("a.pdb", "MODEL        1\n" + nitrogen + "ENDMDL\nMODEL        2\n" + nitrogen + calcium +
                                           "ENDMDL\nMODEL        3\n" + calcium + "ENDMDL\n");
    CHECK(atoms(models) == 1);
    CHECK(models.notes == std::vector<std::string>{"the first of 3 models is drawn; atoms of the others left out: 3"});
    CHECK(read("a.pdb", nitrogen + calcium).notes.empty());
    CHECK(read("a.xyz", "1\n\nO 0 0 0\n1\n\nO 1 1 1\n\n1\n\nO 2 2 2\n").notes ==
          std::vector<std::string>{"the first of 3 frames is drawn"});
    CHECK(read("a.xyz", "1\n\nO 0 0 0\n\n\n").notes.empty());
    const std::string frame =
        "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS x y z\n0 0 "
        "0\n";
    CHECK(read("a.dump", frame).notes.empty());
    CHECK(read("a.dump", frame + frame).notes == std::vector<std::string>{"the first of 2 frames is drawn"});
}

TEST_CASE("mmCIF: the loop of atoms by the names of its columns", "[scenes][load]") {
    const std::string head =
        "data_TEST\n#\n_entry.id TEST\n_struct.title\n;a title; loop_\n_atom_site.id\n;\n"
        "_other.text 'it isn't loop_'\nloop_\n_symmetry.id\n_symmetry.op\n1 'x, y, z'\n2 \"-x, y\"\n#\n";
    const std::string names =
        "loop_\n_atom_site.group_PDB\n_atom_site.Cartn_z\n_atom_site.type_symbol\n_atom_site.Cartn_x\n"
        "_atom_site.label_alt_id\n_atom_site.Cartn_y\n_atom_site.auth_atom_id\n"
        "_atom_site.auth_asym_id\n_atom_site.auth_seq_id\n_atom_site.pdbx_PDB_model_num\n";
    const Scene scene = read("test.cif", head + names +
                                             "ATOM 3.0 C 1.0 . 2.0 CA A 1 1\nATOM 6.0 CA 4.0 A 5.0 \"O5'\" A 2 1\n"
                                             "ATOM 6.5 CA 4.0 B 5.0 \"O5'\" A 2 1\nHETATM 9.0 O\n7.0(2) ? 8.0 O B 3 1\n"
                                             "ATOM 3.0 C 1.0 . 2.0 CA A 1 2\n#\nloop_\n_more.id\n1\n");
    REQUIRE(atoms(scene) == 3);
    CHECK(glm::length(center(scene, 0) - glm::vec3(1, 2, 3)) < 1e-4f);
    CHECK(glm::length(center(scene, 1) - glm::vec3(4, 5, 6)) < 1e-4f);
    CHECK(glm::length(center(scene, 2) - glm::vec3(7, 8, 9)) < 1e-4f);
    CHECK(color(scene, 0) == find_element("C")->color);
    CHECK(color(scene, 1) == find_element("Ca")->color);
    CHECK(scene.notes == std::vector<std::string>{"the first of 2 models is drawn; atoms of the others left out: 1"});
    CHECK(contains(failure("a.cif", ""), "empty"));
    CHECK(contains(failure("a.cif", head), "no loop of _atom_site"));
    CHECK(contains(failure("a.cif", "data_x\nloop_\n_atom_site_label\n_atom_site_fract_x\nC 0.5\n"),
                   "no loop of _atom_site"));
    CHECK(contains(failure("a.cif", "data_x\nloop_\n_atom_site.id\n_atom_site.Cartn_x\n1 0.5\n"), "Cartn_x, y and z"));
    CHECK(contains(failure("a.cif", head + names + "ATOM 3.0 C 1.0 .\n"), "ends within an atom"));
    CHECK(contains(failure("a.cif", head + names + "ATOM 3.0 C one . 2.0 CA A 1 1\n"), "'one' where a coordinate"));
    CHECK(contains(failure("a.cif", head + names + "ATOM 3.0 C 1e999 . 2.0 CA A 1 1\n"), "not finite"));
}

TEST_CASE("XYZ: columns that Properties names", "[scenes][load]") {
    const std::string rows = "O 0.01 -0.02 0.0 5.0 6.0 7.0\nH 0 0 0 5.9 6.0 7.0\n";
    for (const char* comment : {"Properties=species:S:1:forces:R:3:pos:R:3",
                                "Lattice=\"9 0 0 0 9 0 0 0 9\" properties=species:S:1:forces:R:3:pos:R:3 pbc=\"T T T\"",
                                "Properties=\"species:S:1:forces:R:3:pos:R:3\" energy=1"}) {
        const Scene scene = read("a.xyz", "2\n" + std::string(comment) + "\n" + rows);
        REQUIRE(atoms(scene) == 2);
        CHECK(glm::length(center(scene, 0) - glm::vec3(5, 6, 7)) < 1e-4f);
        CHECK(color(scene, 1) == find_element("H")->color);
    }
    // The symbol last, and a radius.
    const Scene last = read("a.xyz", "1\nProperties=pos:R:3:radius:R:1:species:S:1\n1 2 3 0.25 N\n");
    CHECK(color(last, 0) == find_element("N")->color);
    CHECK(bounds(last).size().x < 0.51f);
    CHECK(contains(failure("a.xyz", "1\nProperties=species:S:1:forces:R:3\nO 1 2 3\n"), "pos:R:3"));
    CHECK(contains(failure("a.xyz", "1\nProperties=species:S:1:pos:R:3:tag:I:1\nO 1.00 2.00 3.00\n"),
                   "fewer than 5 values"));
    CHECK(contains(failure("a.xyz", "1\nProperties=species:S:x:pos:R:3\nO 1 2 3\n"), "not a number of columns"));
}

TEST_CASE("LAMMPS dump: boxes by their edges, type labels, diameters", "[scenes][load]") {
    const std::string head = "ITEM: TIMESTEP\n0\nITEM: UNITS\nlj\nITEM: TIME\n0\nITEM: NUMBER OF ATOMS\n2\n";
    // a = (0, 10, 0), b = (-5, 0, 0), c = (1, 1, 2), from (100, 200, 300).
    const Scene general =
        read("a.dump", head +
                           "ITEM: BOX BOUNDS abc origin pp pp pp\n0 10 0 100\n-5 0 0 200\n1 1 2 300\n"
                           "ITEM: ATOMS id typelabel xs ys zs diameter\n1 N 0.5 0.2 1 0.5\n2 Q 0 0 0 1\n");
    const glm::vec3 origin(general.origin);
    CHECK(glm::length(origin + center(general, 0) - glm::vec3(100 - 1 + 1, 200 + 5 + 1, 302)) < 1e-3f);
    CHECK(glm::length(origin + center(general, 1) - glm::vec3(100, 200, 300)) < 1e-3f);
    CHECK(color(general, 0) == find_element("N")->color);
    const Scene labels = read(
        "a.dump",
        head + "ITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id type xsu ysu zsu\n1 O 1 2 3\n2 bead 0 0 0\n");
    CHECK(color(labels, 0) == find_element("O")->color);
    CHECK_FALSE(color(labels, 1) == color(labels, 0));
    CHECK(contains(failure("a.dump",
                           "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\n"
                           "ITEM: ENTRIES c_1 c_2\n1 2\n"),
                   "a dump of atoms is wanted"));
}

TEST_CASE("LAMMPS data: every atom style that the manual names", "[scenes][load]") {
    const std::string head = "title\n\n1 atoms\n1 atom types\n\n0 1 xlo xhi\n\n";
    struct Style {
        const char *name, *before;
    };
    for (const Style& style : {Style{"angle", "1 7 1"},
                               Style{"atomic", "1 1"},
                               Style{"body", "1 1 0 2.5"},
                               Style{"bond", "1 7 1"},
                               Style{"bpm/sphere", "1 7 1 1.0 9.0"},
                               Style{"charge", "1 1 9.0"},
                               Style{"dielectric", "1 1 9.0"},
                               Style{"dipole", "1 1 9.0"},
                               Style{"dpd", "1 1 9.0"},
                               Style{"edpd", "1 1 9.0 9.0"},
                               Style{"electron", "1 1 9.0 1 9.0"},
                               Style{"ellipsoid", "1 1 0 9.0"},
                               Style{"full", "1 7 1 9.0"},
                               Style{"hybrid sphere bond", "1 1"},
                               Style{"line", "1 7 1 0 9.0"},
                               Style{"mdpd", "1 1 9.0"},
                               Style{"molecular", "1 7 1"},
                               Style{"molecular/kk", "1 7 1"},
                               Style{"peri", "1 1 9.0 9.0"},
                               Style{"smd", "1 1 7 9.0 9.0 9.0 9.0 8.0 8.0 8.0"},
                               Style{"sph", "1 1 9.0 9.0 9.0"},
                               Style{"sphere", "1 1 1.0 9.0"},
                               Style{"spin", "1 1"},
                               Style{"tdpd", "1 1"},
                               Style{"template", "1 1 7 1 1"},
                               Style{"tri", "1 7 1 0 9.0"},
                               Style{"wavepacket", "1 1 9.0 1 9.0 1 9.0 9.0"}}) {
        CAPTURE(style.name);
        const Scene scene =
            read("a.data", head + "Atoms  # " + style.name + "\n\n" + style.before + " 1.0 2.0 3.0 0.5 0.5 0.5\n");
        CHECK(glm::length(center(scene, 0) - glm::vec3(1, 2, 3)) < 1e-4f);
    }
    CHECK(
        contains(failure("a.data", head + "Atoms # acme\n\n1 1 1.0 2.0 3.0\n"), "the atom style 'acme' is not known"));
    // Nine values are no bond with image flags unless flags are whole.
    CHECK(
        contains(failure("a.data", head + "Atoms\n\n1 1 1.0 2.0 3.0 0.0 0.0 1.0 2.2\n"), "cannot tell the atom style"));
    // Diameters are said; a diameter of zero is a point's.
    const Scene spheres = read("a.data", head + "Atoms # sphere\n\n1 1 0.5 1.0 1 2 3\n");
    CHECK(bounds(spheres).largest_side() <= 0.5f);
    CHECK(bounds(read("a.data", head + "Atoms # sphere\n\n1 1 0.0 1.0 1 2 3\n")).largest_side() > 0.0f);
}

TEST_CASE("LAMMPS data: elements by masses and by labels", "[scenes][load]") {
    const auto colors = [](const std::string& masses, const std::string& types = "1 2") {
        const std::size_t blank = types.find(' ');
        const Scene scene =
            read("a.data", "t\n\n2 atoms\n2 atom types\n\n" + masses + "\nAtoms # atomic\n\n1 " +
                               types.substr(0, blank) + " 0 0 0\n2 " + types.substr(blank + 1) + " 3 0 0\n");
        return std::pair(color(scene, 0), color(scene, 1));
    };
    const auto of = [](const char* a, const char* b) {
        return std::pair(find_element(a)->color, find_element(b)->color);
    };
    CHECK(colors("Masses\n\n1 12.0107\n2 15.9994\n") == of("C", "O"));
    CHECK(colors("Masses\n\n1 12.0 # CT carbon\n2 1.0 # HC\n") == of("C", "H"));
    CHECK(colors("Masses\n\n1 1.5 # Na\n2 1.5 # Cl\n") == of("Na", "Cl"));
    CHECK(colors("Atom Type Labels\n\n1 Si\n2 O\n\nMasses\n\nSi 28.0855\nO 15.9994\n", "Si O") == of("Si", "O"));
    // In reduced units, and of united atoms, numbers are all there is.
    const auto kinds = colors("Masses\n\n1 1.0\n2 1.0\n");
    CHECK(colors("Masses\n\n1 1.0\n2 4.0\n") == kinds);
    CHECK(colors("Masses\n\n1 14.027\n2 15.035\n") == kinds);
    CHECK(colors("") == kinds);
    CHECK(contains(failure("a.data", "t\n\n1 atoms\n\nAtoms # atomic\n\n1 X 0 0 0\n"), "'X' where a type should be"));
}

TEST_CASE("one atom far away, or another unit, changes neither spheres nor the work", "[scenes][load]") {
    // A cube of 8,000 atoms 1.5 apart; types instead of elements, or elements.
    const auto crystal = [](const std::string& kind, double unit, const std::string& more, int extra) {
        std::string text = std::to_string(8000 + extra) + "\n\n";
        for (int i = 0; i < 8000; ++i) {
            for (const int k : {-1, i % 20, i / 20 % 20, i / 400}) {
                text += k < 0 ? kind
                              : " " + std::to_string(k * 1.5) + "e" +
                                    std::to_string(static_cast<int>(std::lround(std::log10(unit))));
            }
            text += "\n";
        }
        return read("a.xyz", text + more);
    };
    const auto size = [](const Scene& scene) {
        Box box = Box::empty();
        for (std::size_t t = 0; t < 20; ++t) box.add(scene.groups[0].triangles[t].bounds());
        return box.largest_side();
    };
    for (const std::string kind : {"1", "C"}) {
        const float plain = size(crystal(kind, 1, "", 0));
        for (const double unit : {0.1, 1e-10}) {
            CHECK(size(crystal(kind, unit, "", 0)) == Approx(plain * unit));
        }
        const Scene escaped = crystal(kind, 1, kind + " 1e6 0 0\n", 1);
        CHECK(size(escaped) == Approx(plain).epsilon(kind == "1" ? 1.0 : 1e-6));
    }
    // One boulder among grains, and all at one place.
    std::string grains = "20001\nProperties=pos:R:3:radius:R:1\n0 0 -1e7 1e7\n";
    for (int i = 0; i < 20000; ++i) grains += std::to_string(i % 100) + " " + std::to_string(i / 100) + " 0 0.4\n";
    CHECK(atoms(read("a.xyz", grains)) == 20001);
    std::string heap = "20000\n\n";
    for (int i = 0; i < 20000; ++i) heap += "C 1 2 3\n";
    CHECK(atoms(read("a.xyz", heap)) == 20000);
}

TEST_CASE("small files of atoms that hide faults give what they say", "[scenes][load]") {
    const std::filesystem::path folder = shared_data();
    if (folder.empty()) return;
    LoadOptions options = unlit();
    options.sphere_triangle_budget = 20;
    const auto of = [&](const char* file) { return load(folder / "reports" / file, options); };
    CHECK(glm::length(center(of("lammps-spin.data"), 2) - glm::vec3(1, 7, 3)) < 1e-4f);
    CHECK(glm::length(center(of("extxyz-pos_last.xyz"), 1) - glm::vec3(5.9f, 5, 5)) < 1e-4f);
    const Scene left = of("pdb-left.pdb");
    REQUIRE(atoms(left) == 13);
    const std::string expected = "NCCOCHHCNHCHN";
    for (std::size_t i = 0; i < 13; ++i) {
        CAPTURE(i);
        CHECK(color(left, i) == find_element(expected.substr(i, 1))->color);
    }
}
