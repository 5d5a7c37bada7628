// Molecules and particles as spheres: PDB (wwPDB, "Atomic coordinate entry format 3.3", 2012), XYZ (as XMol
// has it), and the dump and data files of LAMMPS (manual: "dump", "read_data", "Howto triclinic").
#include <algorithm>
#include <array>
#include <map>

#include "scenes/load/atoms.hpp"
#include "scenes/load/element.hpp"
#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {
namespace {

Triangles drawn(const std::vector<Atom>& atoms, const LoadOptions& options) {
    if (atoms.empty()) return {};
    int levels = 2;
    while (levels > 0 && atoms.size() * (std::uint64_t{20} << (2 * levels)) > options.sphere_triangle_budget) {
        --levels;
    }
    Triangles triangles = spheres(atoms, icosphere(levels));
    if (!options.bake_light) {
        const std::size_t each = triangles.size() / atoms.size();
        for (std::size_t t = 0; t < triangles.size(); ++t) triangles[t].rgba.fill(atoms[t / each].color);
    }
    return triangles;
}

/// Particles without a radius: half the edge of the cube that each would have to itself.
void set_radii(std::vector<Atom>& atoms) {
    Box box = Box::empty();
    for (const Atom& atom : atoms) box.add(atom.center);
    if (box.is_empty()) return;
    const float least = 0.01f * box.largest_side();
    const glm::vec3 size = glm::max(box.size(), glm::vec3(least));
    // The cube root of each side first: the product of three may be too large.
    const float edge =
        std::cbrt(size.x) * std::cbrt(size.y) * std::cbrt(size.z) / std::cbrt(static_cast<float>(atoms.size()));
    for (Atom& atom : atoms) atom.radius = edge > 0 ? 0.5f * edge : 1.0f;
}

const Element& element_or_unknown(std::string_view symbol) {
    const Element* element = find_element(symbol);
    return element ? *element : unknown_element;
}

// ---------------------------------------------------------------- PDB

/// Columns counted from 1, both ends inclusive, as in the format's description; short lines have fewer.
std::string_view columns(std::string_view line, std::size_t first, std::size_t last) {
    return line.size() < first ? std::string_view{} : line.substr(first - 1, last - first + 1);
}

/// From columns 77-78, or else from the name, whose element is right-justified in its first two columns: " CA
/// " is an alpha carbon, "CA  " is calcium, "HG21" is a hydrogen.
const Element& pdb_element(std::string_view line) {
    if (const Element* element = find_element(trimmed(columns(line, 77, 78)))) return *element;
    const std::string_view name = columns(line, 13, 16);
    const auto letter = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); };
    const bool hydrogen = trimmed(name).size() == 4 && (name[0] == 'H' || name[0] == 'h');
    if (!hydrogen && letter(name.front())) {
        if (const Element* element = find_element(trimmed(name.substr(0, 2)))) return *element;
    }
    const auto first = std::find_if(name.begin(), name.end(), letter);
    return first == name.end() ? unknown_element : element_or_unknown({&*first, 1});
}

double pdb_coordinate(const Lines& lines, std::string_view line, std::size_t first) {
    const std::string_view field = trimmed(columns(line, first, first + 7));
    const std::optional<double> value = number<double>(field);
    if (!value)
        lines.fail(in_quotes(field) + " where a coordinate should be, columns " + std::to_string(first) + " to " +
                   std::to_string(first + 7));
    return *value;
}

// ---------------------------------------------------------------- LAMMPS

/// The parallelepiped that scaled coordinates are relative to.
struct Cell {
    std::array<double, 3> low{}, size{};
    double xy = 0, xz = 0, yz = 0;

    std::array<double, 3> place(double a, double b, double c) const {
        return {low[0] + a * size[0] + b * xy + c * xz, low[1] + b * size[1] + c * yz, low[2] + c * size[2]};
    }
};

template <class T>
T word_as(const Lines& lines, const std::vector<std::string_view>& words, std::size_t i, std::string_view wanted) {
    if (i >= words.size()) lines.fail("no " + std::string(wanted));
    const std::optional<T> value = number<T>(words[i]);
    if (!value) lines.fail(in_quotes(words[i]) + " where " + std::string(wanted) + " should be");
    return *value;
}

Cell read_cell(Lines& lines, bool triclinic) {
    std::array<std::array<double, 3>, 3> rows{};
    for (auto& row : rows) {
        std::string_view line;
        if (!lines.next(line)) throw std::runtime_error("ends within its box");
        const auto w = words(line);
        for (std::size_t i = 0; i < (triclinic ? 3u : 2u); ++i) row[i] = word_as<double>(lines, w, i, "a bound");
    }
    Cell cell;
    cell.xy = rows[0][2];
    cell.xz = rows[1][2];
    cell.yz = rows[2][2];
    // The dump has the bounds of the tilted box, not the box.
    rows[0][0] -= std::min({0.0, cell.xy, cell.xz, cell.xy + cell.xz});
    rows[0][1] -= std::max({0.0, cell.xy, cell.xz, cell.xy + cell.xz});
    rows[1][0] -= std::min(0.0, cell.yz);
    rows[1][1] -= std::max(0.0, cell.yz);
    for (std::size_t i = 0; i < 3; ++i) {
        cell.low[i] = rows[i][0];
        cell.size[i] = rows[i][1] - rows[i][0];
    }
    return cell;
}

/// Where the values of an atom stand in its line; `none` if they do not.
struct DumpColumns {
    static constexpr std::size_t none = ~std::size_t{0};
    std::array<std::size_t, 3> position{none, none, none};
    bool scaled = false;
    std::size_t type = none, element = none, radius = none;
};

DumpColumns dump_columns(const Lines& lines, const std::vector<std::string_view>& names) {
    DumpColumns columns;
    const auto find = [&](std::string_view name) {
        const auto found = std::find(names.begin(), names.end(), name);
        return found == names.end() ? DumpColumns::none : static_cast<std::size_t>(found - names.begin());
    };
    constexpr std::array<std::array<std::string_view, 3>, 4> kinds{
        {{"x", "y", "z"}, {"xu", "yu", "zu"}, {"xs", "ys", "zs"}, {"xsu", "ysu", "zsu"}}};
    for (std::size_t k = 0; k < kinds.size(); ++k) {
        const std::array<std::size_t, 3> found{find(kinds[k][0]), find(kinds[k][1]), find(kinds[k][2])};
        if (std::find(found.begin(), found.end(), DumpColumns::none) != found.end()) continue;
        columns.position = found;
        columns.scaled = k >= 2;
        columns.type = find("type");
        columns.element = find("element");
        columns.radius = find("radius");
        return columns;
    }
    lines.fail("no columns x y z, xu yu zu, xs ys zs or xsu ysu zsu");
}

struct Particles {
    std::vector<Atom> atoms;
    bool radii_missing = false;
};

void read_dump_atoms(Lines& lines, const DumpColumns& columns, const Cell& cell, std::uint64_t count,
                     Particles& particles) {
    check_room(count, 6, lines.rest().size() + 1, "atoms");
    particles.atoms.reserve(static_cast<std::size_t>(count));
    for (std::uint64_t i = 0; i < count; ++i) {
        std::string_view line;
        if (!lines.next(line)) {
            throw std::runtime_error("ends after " + std::to_string(i) + " of " + std::to_string(count) + " atoms");
        }
        const auto w = words(line);
        std::array<double, 3> p{};
        for (std::size_t k = 0; k < 3; ++k) p[k] = word_as<double>(lines, w, columns.position[k], "a coordinate");
        if (columns.scaled) p = cell.place(p[0], p[1], p[2]);
        Atom atom{finite(p[0], p[1], p[2], "atom", static_cast<std::size_t>(i)), 0.0f, uncolored};
        const Element* element = nullptr;
        if (columns.element < w.size()) element = find_element(w[columns.element]);
        if (element) {
            atom.color = element->color;
        } else if (columns.type != DumpColumns::none) {
            atom.color = color_of_kind(word_as<std::int64_t>(lines, w, columns.type, "a type"));
        }
        if (columns.radius != DumpColumns::none) {
            atom.radius = word_as<float>(lines, w, columns.radius, "a radius");
            if (!std::isfinite(atom.radius) || atom.radius < 0) lines.fail("a radius that is not finite or negative");
        } else {
            particles.radii_missing = true;
        }
        particles.atoms.push_back(atom);
    }
}

/// Where type and x stand, by atom style; the manual's table in "read_data".
struct DataColumns {
    std::size_t type, x;
};

std::optional<DataColumns> columns_of_style(std::string_view style) {
    static const std::map<std::string_view, DataColumns> styles{
        {"atomic", {1, 2}}, {"charge", {1, 3}},   {"molecular", {2, 3}}, {"bond", {2, 3}},
        {"angle", {2, 3}},  {"full", {2, 4}},     {"sphere", {1, 4}},    {"ellipsoid", {1, 4}},
        {"dpd", {1, 3}},    {"electron", {1, 5}}, {"line", {2, 5}},      {"tri", {2, 5}}};
    const auto found = styles.find(style);
    return found == styles.end() ? std::nullopt : std::optional(found->second);
}

/// Without a style in a comment the number of values must tell, three image flags or not.
DataColumns guessed_columns(const Lines& lines, const std::vector<std::string_view>& w) {
    switch (w.size()) {
        case 5:
        case 8:
            return *columns_of_style("atomic");
        case 6:
        case 9:
            return *columns_of_style(number<std::int64_t>(w[2]) ? "molecular" : "charge");
        case 7:
        case 10:
            return *columns_of_style("full");
        default:
            lines.fail("cannot tell the atom style; write it after the section's name, as in 'Atoms # full'");
    }
}

}  // namespace

Triangles read_pdb(std::string_view text, const LoadOptions& options) {
    Lines lines(text);
    std::string_view line;
    std::vector<Atom> atoms;
    // The letter of the first alternate of each residue, by chain, number and insertion code.
    std::map<std::string, char, std::less<>> alternates;
    while (lines.next(line)) {
        const std::string_view record = columns(line, 1, 6);
        if (record == "ENDMDL" && !atoms.empty()) break;
        if (record != "ATOM  " && record != "HETATM") continue;
        if (line.size() < 54) lines.fail("an atom record cut short before column 54");
        const double x = pdb_coordinate(lines, line, 31), y = pdb_coordinate(lines, line, 39),
                     z = pdb_coordinate(lines, line, 47);
        const char alternate = line[16];
        if (alternate != ' ') {
            const auto [first, is_new] = alternates.try_emplace(std::string(columns(line, 22, 27)), alternate);
            if (first->second != alternate) continue;
        }
        const Element& element = pdb_element(line);
        atoms.push_back({finite(x, y, z, "line " + std::to_string(lines.number()) + ": atom", atoms.size()),
                         element.radius, element.color});
    }
    return drawn(atoms, options);
}

Triangles read_xyz(std::string_view text, const LoadOptions& options) {
    Lines lines(text);
    std::string_view line;
    if (!lines.next(line)) throw std::runtime_error("is empty");
    const std::optional<std::uint64_t> count = number<std::uint64_t>(trimmed(line));
    if (!count) lines.fail(in_quotes(trimmed(line)) + " where the number of atoms should be");
    if (*count > 0 && !lines.next(line)) throw std::runtime_error("ends before its atoms");  // the comment
    check_room(*count, 7, lines.rest().size() + 1, "atoms");
    Particles particles;
    for (std::uint64_t i = 0; i < *count; ++i) {
        if (!lines.next(line)) {
            throw std::runtime_error("ends after " + std::to_string(i) + " of " + std::to_string(*count) + " atoms");
        }
        const auto w = words(line);
        if (w.size() < 4) lines.fail("fewer than a symbol and three coordinates");
        const glm::vec3 center =
            finite(word_as<double>(lines, w, 1, "a coordinate"), word_as<double>(lines, w, 2, "a coordinate"),
                   word_as<double>(lines, w, 3, "a coordinate"), "atom", static_cast<std::size_t>(i));
        const std::optional<std::int64_t> type = number<std::int64_t>(w[0]);
        const Element& element = element_or_unknown(w[0]);
        particles.radii_missing |= type.has_value();
        particles.atoms.push_back({center, element.radius, type ? color_of_kind(*type) : element.color});
    }
    if (particles.radii_missing) set_radii(particles.atoms);
    return drawn(particles.atoms, options);
}

Triangles read_lammps_dump(std::string_view text, const LoadOptions& options) {
    Lines lines(text);
    std::string_view line;
    std::optional<std::uint64_t> count;
    std::optional<Cell> cell;
    while (lines.next(line)) {
        const auto w = words(line);
        if (w.empty()) continue;
        if (w.size() < 2 || w[0] != "ITEM:") lines.fail(in_quotes(line) + " where an ITEM should be");
        if (w[1] == "NUMBER") {
            if (!lines.next(line)) break;
            count = word_as<std::uint64_t>(lines, words(line), 0, "the number of atoms");
        } else if (w[1] == "BOX") {
            const bool triclinic = std::find(w.begin(), w.end(), "xy") != w.end();
            cell = read_cell(lines, triclinic);
        } else if (w[1] == "ATOMS") {
            if (!count) lines.fail("atoms before their number");
            const DumpColumns columns = dump_columns(lines, {w.begin() + 2, w.end()});
            if (columns.scaled && !cell) lines.fail("scaled coordinates without a box");
            Particles particles;
            read_dump_atoms(lines, columns, cell.value_or(Cell{}), *count, particles);
            if (particles.radii_missing) set_radii(particles.atoms);
            return drawn(particles.atoms, options);
        } else if (!lines.next(line)) {  // TIMESTEP, UNITS, TIME: one line each
            break;
        }
    }
    throw std::runtime_error(text.empty() ? "is empty" : "ends before its atoms");
}

Triangles read_lammps_data(std::string_view text, const LoadOptions& options) {
    Lines lines(text);
    std::string_view line;
    std::optional<std::uint64_t> count;
    std::optional<DataColumns> columns;
    bool in_atoms = false;
    std::vector<Atom> atoms;
    lines.next(line);  // a title, whatever it says
    while (lines.next(line)) {
        const std::size_t hash = line.find('#');
        const auto w = words(line.substr(0, hash));
        if (w.empty()) continue;
        if (!in_atoms) {
            if (w.size() == 2 && w[1] == "atoms") count = word_as<std::uint64_t>(lines, w, 0, "the number of atoms");
            if (w.size() != 1 || w[0] != "Atoms") continue;
            if (!count) lines.fail("atoms before their number");
            check_room(*count, 9, lines.rest().size() + 1, "atoms");
            if (hash != std::string_view::npos) columns = columns_of_style(trimmed(line.substr(hash + 1)));
            in_atoms = true;
            continue;
        }
        if (atoms.size() == *count) break;
        if (!columns) columns = guessed_columns(lines, w);
        const auto coordinate = [&](std::size_t i) {
            return word_as<double>(lines, w, columns->x + i, "a coordinate");
        };
        const auto type = word_as<std::int64_t>(lines, w, columns->type, "a type");
        atoms.push_back(
            {finite(coordinate(0), coordinate(1), coordinate(2), "atom", atoms.size()), 0.0f, color_of_kind(type)});
    }
    if (!in_atoms) throw std::runtime_error(text.empty() ? "is empty" : "has no section Atoms");
    if (atoms.size() < *count) {
        throw std::runtime_error("ends after " + std::to_string(atoms.size()) + " of " + std::to_string(*count) +
                                 " atoms");
    }
    set_radii(atoms);
    return drawn(atoms, options);
}

}  // namespace farfield::scenes::detail
