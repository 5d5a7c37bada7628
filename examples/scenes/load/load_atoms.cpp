// Molecules: PDB (wwPDB, "Atomic coordinate entry format 3.3", 2012), PDBx/mmCIF (wwPDB, "PDBx/mmCIF dictionary";
// syntax: Hall, Allen and Brown 1991, "The crystallographic information file"), and XYZ, plain as XMol has it and
// extended (ASE and libAtoms, "Extended XYZ").
#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "scenes/load/particles.hpp"

namespace farfield::scenes::detail {
namespace {

void note_models(std::size_t models, std::size_t atoms_left_out, Particles& particles) {
    if (atoms_left_out == 0) return;
    particles.notes.push_back("the first of " + std::to_string(models) +
                              " models is drawn; atoms of the others left out: " + std::to_string(atoms_left_out));
}

// ---------------------------------------------------------------- PDB

/// Columns counted from 1, both ends inclusive, as in the format's description; short lines have fewer.
std::string_view columns(std::string_view line, std::size_t first, std::size_t last) {
    return line.size() < first ? std::string_view{} : line.substr(first - 1, last - first + 1);
}

constexpr bool is_letter(char c) {
    return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

/// Amino acids, nucleotides and water: the first letter of an atom's name is its element, whatever the columns are.
bool is_common_residue(std::string_view name) {
    static const std::set<std::string_view> known{
        "ALA", "ARG", "ASN", "ASP", "CYS", "GLN", "GLU", "GLY", "HIS", "ILE", "LEU", "LYS", "MET", "PHE", "PRO",
        "SER", "THR", "TRP", "TYR", "VAL", "A",   "C",   "G",   "I",   "U",   "DA",  "DC",  "DG",  "DI",  "DT",
        "DU",  "HOH", "WAT", "HID", "HIE", "HIP", "HSD", "HSE", "HSP", "CYX", "ASH", "GLH", "LYN"};
    return known.count(name) > 0;
}

/// Whether the names of a file begin in column 13, as some programs write them, and not in 14 with elements of one
/// letter: told by a short name there that has one letter only in front, or is an amino acid's or a nucleotide's.
bool names_are_left_justified(std::string_view text) {
    Lines lines(text);
    std::string_view line;
    while (lines.next(line)) {
        const std::string_view record = columns(line, 1, 6), name = columns(line, 13, 16);
        if ((record != "ATOM  " && record != "HETATM") || name.empty() || !is_letter(name[0])) continue;
        if (name.size() < 2 || trimmed(name).size() == 4) continue;
        if (!is_letter(name[1]) || is_common_residue(trimmed(columns(line, 18, 20)))) return true;
    }
    return false;
}

/// From columns 77-78, or else from the name, whose element is right-justified in its first two columns: " CA " is an
/// alpha carbon, "CA  " is calcium, "HG21" is a hydrogen.
const Element& pdb_element(std::string_view line, bool left_justified) {
    if (const Element* element = find_element(trimmed(columns(line, 77, 78)))) return *element;
    const std::string_view name = columns(line, 13, 16);
    const auto first = std::find_if(name.begin(), name.end(), is_letter);
    if (first == name.end()) return unknown_element;
    const Element& of_first_letter = element_or_unknown({&*first, 1});
    const std::string_view residue = trimmed(columns(line, 18, 20));
    if (is_common_residue(residue)) return of_first_letter;
    if (left_justified) {
        // An ion bears the name of its residue; of the rest, elements of two letters that are no carbon, hydrogen or
        // nitrogen with a letter behind it.
        const std::string_view two = trimmed(name.substr(0, 2));
        constexpr std::array<std::string_view, 9> safe{"CL", "BR", "SI", "SE", "FE", "ZN", "MG", "MN", "CU"};
        const bool sure = trimmed(name) == residue || std::find(safe.begin(), safe.end(), two) != safe.end();
        const Element* element = sure ? find_element(two) : nullptr;
        return element ? *element : of_first_letter;
    }
    const bool hydrogen = trimmed(name).size() == 4 && (name[0] == 'H' || name[0] == 'h');
    if (!hydrogen && is_letter(name.front())) {
        if (const Element* element = find_element(trimmed(name.substr(0, 2)))) return *element;
    }
    return of_first_letter;
}

double pdb_coordinate(const Lines& lines, std::string_view line, std::size_t first) {
    const std::string_view field = trimmed(columns(line, first, first + 7));
    const std::optional<double> value = number<double>(field);
    if (!value)
        lines.fail(in_quotes(field) + " where a coordinate should be, columns " + std::to_string(first) + " to " +
                   std::to_string(first + 7));
    return *value;
}

// ---------------------------------------------------------------- mmCIF

/// The values of a CIF one after the other.
class CifTokens {
  public:
    explicit CifTokens(std::string_view text) : text_(text) {}

    /// Quoted ones are never names or keywords.
    struct Token {
        std::string_view text;
        bool quoted;
        bool is(std::string_view keyword) const {
            return !quoted && text.size() >= keyword.size() &&
                   std::equal(keyword.begin(), keyword.end(), text.begin(), [](char k, char t) {
                       return k == (t >= 'A' && t <= 'Z' ? static_cast<char>(t - 'A' + 'a') : t);
                   });
        }
    };

    bool next(Token& token) {
        for (;;) {
            while (at_ < text_.size() && is_space(text_[at_])) ++at_;
            if (at_ == text_.size()) return false;
            if (text_[at_] != '#') break;
            at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
        }
        const std::size_t begin = at_;
        const char c = text_[begin];
        if (c == ';' && (begin == 0 || text_[begin - 1] == '\n' || text_[begin - 1] == '\r')) {
            const std::size_t end = std::min(text_.find("\n;", begin), text_.size());
            at_ = std::min(end + 2, text_.size());
            token = {text_.substr(begin + 1, end - begin - 1), true};
            return true;
        }
        if (c == '\'' || c == '"') {
            // A quote within is none unless a blank follows it.
            for (std::size_t end = begin + 1; end < text_.size() && text_[end] != '\n'; ++end) {
                if (text_[end] != c || (end + 1 < text_.size() && !is_space(text_[end + 1]))) continue;
                at_ = end + 1;
                token = {text_.substr(begin + 1, end - begin - 1), true};
                return true;
            }
        }
        while (at_ < text_.size() && !is_space(text_[at_])) ++at_;
        token = {text_.substr(begin, at_ - begin), false};
        return true;
    }

    std::size_t line() const {
        const std::string_view before = text_.substr(0, at_);
        return 1 + static_cast<std::size_t>(std::count(before.begin(), before.end(), '\n'));
    }

  private:
    std::string_view text_;
    std::size_t at_ = 0;
};

/// The columns of the loop of atoms that are looked at.
struct CifColumns {
    static constexpr std::size_t none = ~std::size_t{0};
    std::array<std::size_t, 3> position{none, none, none};
    std::size_t element = none, alternate = none, model = none;
    std::array<std::size_t, 4> residue{none, none, none, none};
    std::size_t count = 0;

    void name(std::string_view column) {
        const std::size_t i = count++;
        if (column == "Cartn_x") position[0] = i;
        if (column == "Cartn_y") position[1] = i;
        if (column == "Cartn_z") position[2] = i;
        if (column == "type_symbol") element = i;
        if (column == "label_alt_id") alternate = i;
        if (column == "pdbx_PDB_model_num") model = i;
        if (column == "auth_asym_id") residue[0] = i;
        if (column == "auth_seq_id") residue[1] = i;
        if (column == "pdbx_PDB_ins_code") residue[2] = i;
        if (column == "label_seq_id") residue[3] = i;
    }
};

class CifAtoms {
  public:
    explicit CifAtoms(const CifColumns& columns) : columns_(columns) {}

    void add(const std::vector<std::string_view>& row, std::size_t line) {
        const auto value = [&](std::size_t column) {
            return column == CifColumns::none ? std::string_view{} : row[column];
        };
        const std::string model(value(columns_.model));
        models_.insert(model);
        if (first_model_.empty()) first_model_ = model;
        if (model != first_model_) {
            ++left_out_;
            return;
        }
        glm::dvec3 p;
        for (int i = 0; i < 3; ++i) {
            const std::string_view text = value(columns_.position[static_cast<std::size_t>(i)]);
            // "1.234(5)" has its uncertainty in the last digit.
            const std::optional<double> number = detail::number<double>(text.substr(0, text.find('(')));
            if (!number) {
                throw std::runtime_error("line " + std::to_string(line) + ": " + in_quotes(text) +
                                         " where a coordinate should be");
            }
            p[i] = *number;
        }
        const std::string_view alternate = value(columns_.alternate);
        if (!alternate.empty() && alternate != "." && alternate != "?") {
            std::string key;
            for (const std::size_t column : columns_.residue) key.append(value(column)).push_back(' ');
            const auto [first, is_new] = alternates_.try_emplace(std::move(key), alternate);
            if (first->second != alternate) return;
        }
        const Element& element = element_or_unknown(value(columns_.element));
        particles_.all.push_back({p, element.radius, element.color});
    }

    Particles taken() {
        note_models(models_.size(), left_out_, particles_);
        return std::move(particles_);
    }

  private:
    CifColumns columns_;
    Particles particles_;
    std::string first_model_;
    std::set<std::string> models_;
    std::map<std::string, std::string> alternates_;  ///< the first of each residue
    std::size_t left_out_ = 0;
};

// ---------------------------------------------------------------- XYZ

/// Where an atom's values stand in its line.
struct XyzColumns {
    static constexpr std::size_t none = ~std::size_t{0};
    std::size_t kind = 0, position = 1, radius = none, count = 4;
};

/// `Properties=species:S:1:pos:R:3:...` in the comment names the columns; without it they are a symbol and coordinates.
XyzColumns xyz_columns(const Lines& lines, std::string_view comment) {
    constexpr std::string_view key = "properties=";
    const auto same = [](char a, char b) {
        return a == b || (a >= 'a' && a <= 'z' && b == static_cast<char>(a - 'a' + 'A'));
    };
    const auto found = std::search(comment.begin(), comment.end(), key.begin(), key.end(),
                                   [&](char text, char k) { return same(k, text); });
    if (found == comment.end()) return {};
    std::string_view list = comment.substr(static_cast<std::size_t>(found - comment.begin()) + key.size());
    if (!list.empty() && (list[0] == '"' || list[0] == '\'')) {
        list = list.substr(1, list.find(list[0], 1) - 1);
    } else {
        list = list.substr(0, list.find_first_of(" \t"));
    }
    std::vector<std::string_view> parts;
    while (!list.empty()) {
        const std::size_t colon = std::min(list.find(':'), list.size());
        parts.push_back(list.substr(0, colon));
        list.remove_prefix(std::min(colon + 1, list.size()));
    }
    XyzColumns columns{XyzColumns::none, XyzColumns::none, XyzColumns::none, 0};
    for (std::size_t i = 0; i + 2 < parts.size(); i += 3) {
        const std::string_view name = parts[i];
        const auto wide = number<std::uint64_t>(parts[i + 2]);
        if (!wide || *wide > 1000) lines.fail("Properties: " + in_quotes(name) + " has not a number of columns");
        if ((name == "pos" || name == "positions") && *wide == 3) columns.position = columns.count;
        if (name == "species" || name == "element" || name == "symbol") columns.kind = columns.count;
        if (columns.kind == XyzColumns::none && (name == "Z" || name == "type")) columns.kind = columns.count;
        if (name == "radius") columns.radius = columns.count;
        columns.count += static_cast<std::size_t>(*wide);
    }
    if (columns.position == XyzColumns::none) lines.fail("Properties names no columns pos:R:3");
    return columns;
}

/// Frames after the first, whose atoms are not looked at.
void note_frames(Lines& lines, Particles& particles) {
    std::size_t frames = 1;
    std::string_view line;
    while (lines.next(line)) {
        const std::optional<std::uint64_t> count = number<std::uint64_t>(trimmed(line));
        if (!count) continue;
        ++frames;
        for (std::uint64_t i = 0; i <= *count && lines.next(line); ++i) {
        }
    }
    if (frames > 1) particles.notes.push_back("the first of " + std::to_string(frames) + " frames is drawn");
}

}  // namespace

Loaded read_pdb(std::string_view text, const LoadOptions& options) {
    Lines lines(text);
    std::string_view line;
    Particles particles;
    const bool left_justified = names_are_left_justified(text);
    std::size_t models = 1, left_out = 0;
    bool between_models = false;
    // The letter of the first alternate of each residue, by chain, number and insertion code.
    std::map<std::string, char, std::less<>> alternates;
    while (lines.next(line)) {
        const std::string_view record = columns(line, 1, 6);
        if ((record == "ENDMDL" || record == "MODEL ") && !particles.all.empty()) between_models = true;
        if (record != "ATOM  " && record != "HETATM") continue;
        models += between_models;
        between_models = false;
        if (models > 1) {
            ++left_out;
            continue;
        }
        if (line.size() < 54) lines.fail("an atom record cut short before column 54");
        const glm::dvec3 p(pdb_coordinate(lines, line, 31), pdb_coordinate(lines, line, 39),
                           pdb_coordinate(lines, line, 47));
        const char alternate = line[16];
        if (alternate != ' ') {
            const auto [first, is_new] = alternates.try_emplace(std::string(columns(line, 22, 27)), alternate);
            if (first->second != alternate) continue;
        }
        const Element& element = pdb_element(line, left_justified);
        particles.all.push_back({p, element.radius, element.color});
    }
    note_models(models, left_out, particles);
    return drawn(std::move(particles), options);
}

Loaded read_mmcif(std::string_view text, const LoadOptions& options) {
    constexpr std::string_view category = "_atom_site.";
    CifTokens tokens(text);
    CifTokens::Token token{};
    bool more = tokens.next(token);
    while (more) {
        if (!token.is("loop_")) {
            if (token.is("_atom_site_fract_x")) break;
            more = tokens.next(token);
            continue;
        }
        CifColumns columns;
        for (more = tokens.next(token); more && token.is(category); more = tokens.next(token)) {
            columns.name(token.text.substr(category.size()));
        }
        if (columns.count == 0) continue;
        for (const std::size_t column : columns.position) {
            if (column == CifColumns::none) throw std::runtime_error("its atoms have no _atom_site.Cartn_x, y and z");
        }
        CifAtoms atoms(columns);
        std::vector<std::string_view> row;
        const std::size_t first_line = tokens.line();
        std::size_t rows = 0;
        for (; more && (token.quoted || (!token.is("_") && !token.is("loop_") && !token.is("data_")));
             more = tokens.next(token)) {
            row.push_back(token.text);
            if (row.size() < columns.count) continue;
            atoms.add(row, first_line + rows++);
            row.clear();
        }
        if (!row.empty()) throw std::runtime_error("line " + std::to_string(tokens.line()) + ": ends within an atom");
        return drawn(atoms.taken(), options);
    }
    throw std::runtime_error(trimmed(text).empty() ? "is empty" : "has no loop of _atom_site.Cartn_x, y and z (mmCIF)");
}

Loaded read_xyz(std::string_view text, const LoadOptions& options) {
    Lines lines(text);
    std::string_view line;
    if (!lines.next(line)) throw std::runtime_error("is empty");
    const std::optional<std::uint64_t> count = number<std::uint64_t>(trimmed(line));
    if (!count) lines.fail(in_quotes(trimmed(line)) + " where the number of atoms should be");
    line = {};
    if (*count > 0 && !lines.next(line)) throw std::runtime_error("ends before its atoms");  // the comment
    const XyzColumns columns = xyz_columns(lines, line);
    check_room(*count, 2 * columns.count - 1, lines.rest().size() + 1, "atoms");
    Particles particles;
    particles.radii_of_elements = columns.radius == XyzColumns::none;
    for (std::uint64_t i = 0; i < *count; ++i) {
        if (!lines.next(line)) {
            throw std::runtime_error("ends after " + std::to_string(i) + " of " + std::to_string(*count) + " atoms");
        }
        const auto w = words(line);
        if (w.size() < columns.count) {
            lines.fail("fewer than " + std::to_string(columns.count) +
                       " values: a symbol, three coordinates and what "
                       "Properties names");
        }
        const auto coordinate = [&](std::size_t k) {
            return word_as<double>(lines, w, columns.position + k, "a coordinate");
        };
        Particle particle{{coordinate(0), coordinate(1), coordinate(2)}, unknown_element.radius, uncolored};
        if (columns.kind == XyzColumns::none) {
            particles.radii_missing = true;
        } else {
            const std::string_view kind = w[columns.kind];
            const std::optional<std::int64_t> type = number<std::int64_t>(kind);
            const Element& element = element_or_unknown(kind);
            particles.radii_missing |= type.has_value();
            particle.radius = element.radius;
            particle.color = type ? color_of_kind(*type) : element.color;
        }
        if (columns.radius != XyzColumns::none) {
            particle.radius = word_as<float>(lines, w, columns.radius, "a radius");
            if (!std::isfinite(particle.radius) || particle.radius < 0)
                lines.fail("a radius that is not finite or negative");
        }
        particles.all.push_back(particle);
    }
    if (columns.radius != XyzColumns::none) particles.radii_missing = false;
    note_frames(lines, particles);
    return drawn(std::move(particles), options);
}

}  // namespace farfield::scenes::detail
