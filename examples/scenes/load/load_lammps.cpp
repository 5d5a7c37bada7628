// Particles of LAMMPS (manual: "dump", "read_data", "Howto triclinic", "Howto type labels").
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "scenes/load/particles.hpp"

namespace farfield::scenes::detail {
namespace {

using Words = std::vector<std::string_view>;

constexpr std::size_t none = ~std::size_t{0};

/// A kind that is named rather than numbered has the color of its element, or else one by its name.
Rgba8 color_of_label(std::string_view label) {
    if (const Element* element = find_element(label)) return element->color;
    std::uint32_t hash = 2166136261u;  // FNV-1a
    for (const char c : label) hash = (hash ^ static_cast<unsigned char>(c)) * 16777619u;
    return color_of_kind(hash);
}

Rgba8 color_of_type(std::string_view type) {
    const std::optional<std::int64_t> kind = number<std::int64_t>(type);
    return kind ? color_of_kind(*kind) : color_of_label(type);
}

float radius_as(const Lines& lines, const Words& words, std::size_t i, float factor) {
    const float radius = factor * word_as<float>(lines, words, i, "a radius");
    if (!std::isfinite(radius) || radius < 0) lines.fail("a radius that is not finite or negative");
    return radius;
}

// ---------------------------------------------------------------- dump

/// The parallelepiped that scaled coordinates are relative to.
struct Cell {
    glm::dvec3 origin{0.0};
    std::array<glm::dvec3, 3> edges{};

    glm::dvec3 place(const glm::dvec3& p) const { return origin + p.x * edges[0] + p.y * edges[1] + p.z * edges[2]; }
};

/// Three kinds of box: "xlo xhi", with "xy xz yz" tilted, with "abc origin" by its edges.
Cell read_cell(Lines& lines, const Words& item) {
    const auto says = [&](std::string_view word) { return std::find(item.begin(), item.end(), word) != item.end(); };
    const bool general = says("abc"), tilted = says("xy");
    const std::size_t bounds = general ? 4 : tilted ? 3 : 2;
    std::array<std::array<double, 4>, 3> rows{};
    for (auto& row : rows) {
        std::string_view line;
        if (!lines.next(line)) throw std::runtime_error("ends within its box");
        const auto w = words(line);
        for (std::size_t i = 0; i < bounds; ++i) row[i] = word_as<double>(lines, w, i, "a bound");
    }
    Cell cell;
    if (general) {
        for (int i = 0; i < 3; ++i) {
            const auto& row = rows[static_cast<std::size_t>(i)];
            cell.edges[static_cast<std::size_t>(i)] = {row[0], row[1], row[2]};
            cell.origin[i] = row[3];
        }
        return cell;
    }
    const double xy = rows[0][2], xz = rows[1][2], yz = rows[2][2];
    // The dump has the bounds of the tilted box, not the box.
    rows[0][0] -= std::min({0.0, xy, xz, xy + xz});
    rows[0][1] -= std::max({0.0, xy, xz, xy + xz});
    rows[1][0] -= std::min(0.0, yz);
    rows[1][1] -= std::max(0.0, yz);
    cell.origin = {rows[0][0], rows[1][0], rows[2][0]};
    cell.edges = {glm::dvec3(rows[0][1] - rows[0][0], 0, 0), glm::dvec3(xy, rows[1][1] - rows[1][0], 0),
                  glm::dvec3(xz, yz, rows[2][1] - rows[2][0])};
    return cell;
}

/// Where the values of an atom stand in its line; `none` if they do not.
struct DumpColumns {
    std::array<std::size_t, 3> position{none, none, none};
    bool scaled = false;
    std::size_t type = none, label = none, element = none, radius = none, diameter = none;
};

DumpColumns dump_columns(const Lines& lines, const Words& names) {
    DumpColumns columns;
    const auto find = [&](std::string_view name) {
        const auto found = std::find(names.begin(), names.end(), name);
        return found == names.end() ? none : static_cast<std::size_t>(found - names.begin());
    };
    constexpr std::array<std::array<std::string_view, 3>, 4> kinds{
        {{"x", "y", "z"}, {"xu", "yu", "zu"}, {"xs", "ys", "zs"}, {"xsu", "ysu", "zsu"}}};
    for (std::size_t k = 0; k < kinds.size(); ++k) {
        const std::array<std::size_t, 3> found{find(kinds[k][0]), find(kinds[k][1]), find(kinds[k][2])};
        if (std::find(found.begin(), found.end(), none) != found.end()) continue;
        columns.position = found;
        columns.scaled = k >= 2;
        columns.type = find("type");
        columns.label = find("typelabel");
        columns.element = find("element");
        columns.radius = find("radius");
        columns.diameter = find("diameter");
        return columns;
    }
    lines.fail("no columns x y z, xu yu zu, xs ys zs or xsu ysu zsu");
}

void read_dump_atoms(Lines& lines, const DumpColumns& columns, const Cell& cell, std::uint64_t count,
                     Particles& particles) {
    check_room(count, 6, lines.rest().size() + 1, "atoms");
    particles.all.reserve(static_cast<std::size_t>(count));
    particles.radii_of_elements = false;
    particles.radii_missing = columns.radius == none && columns.diameter == none;
    for (std::uint64_t i = 0; i < count; ++i) {
        std::string_view line;
        if (!lines.next(line)) {
            throw std::runtime_error("ends after " + std::to_string(i) + " of " + std::to_string(count) + " atoms");
        }
        const auto w = words(line);
        glm::dvec3 p;
        for (int k = 0; k < 3; ++k) {
            p[k] = word_as<double>(lines, w, columns.position[static_cast<std::size_t>(k)], "a coordinate");
        }
        Particle particle{columns.scaled ? cell.place(p) : p, 0.0f, uncolored};
        const Element* element = columns.element < w.size() ? find_element(w[columns.element]) : nullptr;
        const std::size_t type = columns.label != none ? columns.label : columns.type;
        if (element) {
            particle.color = element->color;
        } else if (type != none) {
            if (type >= w.size()) lines.fail("no type");
            particle.color = color_of_type(w[type]);
        }
        if (columns.radius != none) {
            particle.radius = radius_as(lines, w, columns.radius, 1.0f);
        } else if (columns.diameter != none) {
            particle.radius = radius_as(lines, w, columns.diameter, 0.5f);
        }
        particles.all.push_back(particle);
    }
}

/// Frames that begin after the first; their atoms are not looked at.
void note_frames(Lines& lines, Particles& particles) {
    std::size_t frames = 1;
    std::string_view line;
    while (lines.next(line)) frames += line.substr(0, 14) == "ITEM: TIMESTEP";
    if (frames > 1) particles.notes.push_back("the first of " + std::to_string(frames) + " frames is drawn");
}

// ---------------------------------------------------------------- data

/// Where type, x and a diameter stand, by atom style; the manual's table in "read_data".
struct DataColumns {
    std::size_t type, x, diameter = none;
};

const std::map<std::string_view, DataColumns>& atom_styles() {
    static const std::map<std::string_view, DataColumns> styles{
        {"amoeba", {2, 4}},    {"angle", {2, 3}},         {"atomic", {1, 2}},    {"body", {1, 4}},
        {"bond", {2, 3}},      {"bpm/sphere", {2, 5, 3}}, {"charge", {1, 3}},    {"dielectric", {1, 3}},
        {"dipole", {1, 3}},    {"dpd", {1, 3}},           {"edpd", {1, 4}},      {"electron", {1, 5}},
        {"ellipsoid", {1, 4}}, {"full", {2, 4}},          {"hybrid", {1, 2}},    {"line", {2, 5}},
        {"mdpd", {1, 3}},      {"mesont", {2, 7}},        {"molecular", {2, 3}}, {"peri", {1, 4}},
        {"rheo", {1, 4}},      {"rheo/thermal", {1, 5}},  {"smd", {1, 10}},      {"sph", {1, 5}},
        {"sphere", {1, 4, 2}}, {"spin", {1, 2}},          {"tdpd", {1, 2}},      {"template", {1, 5}},
        {"tri", {2, 5}},       {"wavepacket", {1, 8}}};
    return styles;
}

/// Of the style in a comment after "Atoms": "full", "full/kk", "hybrid sphere bond".
DataColumns columns_of_style(const Lines& lines, std::string_view style) {
    std::string_view name = style.substr(0, style.find_first_of(" \t"));
    for (const std::string_view suffix : {"/kk", "/omp", "/gpu", "/intel", "/opt"}) {
        if (name.size() > suffix.size() && name.substr(name.size() - suffix.size()) == suffix) {
            name.remove_suffix(suffix.size());
        }
    }
    const auto found = atom_styles().find(name);
    if (found == atom_styles().end()) lines.fail("the atom style " + in_quotes(style) + " is not known");
    return found->second;
}

/// Without a style in a comment the number of values must tell, three image flags or not.
DataColumns guessed_columns(const Lines& lines, const Words& w) {
    const auto is_whole = [&](std::size_t i) { return number<std::int64_t>(w[i]).has_value(); };
    const std::size_t n = w.size();
    const bool flags = n > 7 && is_whole(n - 1) && is_whole(n - 2) && is_whole(n - 3);
    switch (flags ? n - 3 : n) {
        case 5:
            return atom_styles().at("atomic");
        case 6:
            return atom_styles().at(is_whole(2) ? "molecular" : "charge");
        case 7:
            return atom_styles().at("full");
        default:
            lines.fail("cannot tell the atom style; write it after the section's name, as in 'Atoms # full'");
    }
}

/// What is told of a type before the atoms.
struct Kind {
    std::string label{};
    double mass = 0;
    const Element* element = nullptr;
};

/// Types by number. Elements are named by labels or in the comments of masses; or they are found by their masses, if
/// every type has one that is an element's: in reduced units masses are small whole numbers, of which one at least is
/// none.
class Kinds {
  public:
    void label(std::int64_t type, std::string_view label) {
        kinds_[type].label = label;
        numbers_.try_emplace(std::string(label), type);
    }
    void mass(std::int64_t type, double mass, std::string_view comment) {
        kinds_[type].mass = mass;
        if (kinds_[type].label.empty()) kinds_[type].label = comment;
    }
    /// The number behind a label; none if it is neither a number nor a label.
    std::optional<std::int64_t> number_of(std::string_view type) const {
        if (const auto n = number<std::int64_t>(type)) return n;
        const auto found = numbers_.find(type);
        return found == numbers_.end() ? std::nullopt : std::optional(found->second);
    }
    /// True if each is an element.
    bool find_elements() {
        bool named = !kinds_.empty(), weighed = !kinds_.empty(), heavy = false;
        for (auto& [n, kind] : kinds_) {
            kind.element = find_element(kind.label);
            named &= kind.element != nullptr;
            weighed &= find_element_by_mass(kind.mass) != nullptr;
            heavy |= kind.mass > 4.5;
        }
        if (!named && weighed && heavy) {
            for (auto& [n, kind] : kinds_) kind.element = find_element_by_mass(kind.mass);
            named = true;
        }
        return named;
    }
    const Element* element(std::int64_t type) const {
        const auto found = kinds_.find(type);
        return found == kinds_.end() ? nullptr : found->second.element;
    }

  private:
    std::map<std::int64_t, Kind> kinds_;
    std::map<std::string, std::int64_t, std::less<>> numbers_;  ///< by label
};

}  // namespace

Loaded read_lammps_dump(std::string_view text, const LoadOptions& options) {
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
            cell = read_cell(lines, w);
        } else if (w[1] == "ATOMS") {
            if (!count) lines.fail("atoms before their number");
            const DumpColumns columns = dump_columns(lines, {w.begin() + 2, w.end()});
            if (columns.scaled && !cell) lines.fail("scaled coordinates without a box");
            Particles particles;
            read_dump_atoms(lines, columns, cell.value_or(Cell{}), *count, particles);
            note_frames(lines, particles);
            return drawn(std::move(particles), options);
        } else if (w[1] == "TIMESTEP" || w[1] == "UNITS" || w[1] == "TIME") {  // one line each
            if (!lines.next(line)) break;
        } else {
            lines.fail(in_quotes(line) + " is not known; a dump of atoms is wanted");
        }
    }
    throw std::runtime_error(text.empty() ? "is empty" : "ends before its atoms");
}

Loaded read_lammps_data(std::string_view text, const LoadOptions& options) {
    Lines lines(text);
    std::string_view line;
    std::optional<std::uint64_t> count;
    std::optional<DataColumns> columns;
    Kinds kinds;
    enum class Section { other, masses, labels, atoms } section = Section::other;
    bool by_element = false;
    Particles particles;
    particles.radii_of_elements = false;
    lines.next(line);  // a title, whatever it says
    while (lines.next(line)) {
        const std::size_t hash = line.find('#');
        const auto w = words(line.substr(0, hash));
        const std::string_view comment =
            hash == std::string_view::npos ? std::string_view{} : trimmed(line.substr(hash + 1));
        if (w.empty()) continue;
        // Sections begin with a word, their lines with a number or, since types have labels, with one of those.
        if (section != Section::atoms) {
            if (w.size() == 2 && w[1] == "atoms") count = word_as<std::uint64_t>(lines, w, 0, "the number of atoms");
            if (w.size() == 1 && w[0] == "Masses") {
                section = Section::masses;
            } else if (w.size() == 3 && w[0] == "Atom" && w[1] == "Type" && w[2] == "Labels") {
                section = Section::labels;
            } else if (w.size() == 1 && w[0] == "Atoms") {
                if (!count) lines.fail("atoms before their number");
                check_room(*count, 9, lines.rest().size() + 1, "atoms");
                if (!comment.empty()) columns = columns_of_style(lines, comment);
                by_element = kinds.find_elements();
                section = Section::atoms;
            } else if (section == Section::masses && w.size() == 2 && kinds.number_of(w[0]) && number<double>(w[1])) {
                kinds.mass(*kinds.number_of(w[0]), *number<double>(w[1]),
                           comment.substr(0, comment.find_first_of(" \t")));
            } else if (section == Section::labels && w.size() == 2 && number<std::int64_t>(w[0])) {
                kinds.label(*number<std::int64_t>(w[0]), w[1]);
            } else {
                section = Section::other;
            }
            continue;
        }
        if (particles.all.size() == *count) break;
        if (!columns) columns = guessed_columns(lines, w);
        const auto coordinate = [&](std::size_t i) {
            return word_as<double>(lines, w, columns->x + i, "a coordinate");
        };
        if (columns->type >= w.size()) lines.fail("no type");
        const std::optional<std::int64_t> type = kinds.number_of(w[columns->type]);
        if (!type) lines.fail(in_quotes(w[columns->type]) + " where a type should be");
        const Element* const element = by_element ? kinds.element(*type) : nullptr;
        Particle particle{
            {coordinate(0), coordinate(1), coordinate(2)}, 0.0f, element ? element->color : color_of_kind(*type)};
        if (columns->diameter != none) particle.radius = radius_as(lines, w, columns->diameter, 0.5f);
        // Points have a diameter of zero.
        if (columns->diameter == none && element) {
            particle.radius = element->radius;
            particles.radii_of_elements = true;
        }
        particles.radii_missing |= !(particle.radius > 0);
        particles.all.push_back(particle);
    }
    if (section != Section::atoms) throw std::runtime_error(text.empty() ? "is empty" : "has no section Atoms");
    if (particles.all.size() < *count) {
        throw std::runtime_error("ends after " + std::to_string(particles.all.size()) + " of " +
                                 std::to_string(*count) + " atoms");
    }
    return drawn(std::move(particles), options);
}

}  // namespace farfield::scenes::detail
