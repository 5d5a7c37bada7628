// Chemical elements as molecules are drawn: a radius and a color.
#pragma once

#include <array>
#include <string_view>

#include "farfield/geometry/rgba8.hpp"

namespace farfield::scenes {

struct Element {
    std::string_view symbol;  // as written: "C", "Cl"
    float radius;             // van der Waals, in angstroms
    Rgba8 color;
};

/// Colors: Jmol's table, which extends those of Corey, Pauling and Koltun. Radii: Bondi, "Van der Waals
/// volumes and radii", J. Phys. Chem. 68, 1964; main-group elements missing there, and hydrogen, from Mantina
/// et al., "Consistent van der Waals radii for the whole main group", J. Phys. Chem. A 113, 2009. Where
/// neither has a value (most transition metals), 2.0.
inline constexpr std::array<Element, 52> elements{{
    {"H", 1.10f, {255, 255, 255}},  {"He", 1.40f, {217, 255, 255}}, {"Li", 1.82f, {204, 128, 255}},
    {"Be", 1.53f, {194, 255, 0}},   {"B", 1.92f, {255, 181, 181}},  {"C", 1.70f, {144, 144, 144}},
    {"N", 1.55f, {48, 80, 248}},    {"O", 1.52f, {255, 13, 13}},    {"F", 1.47f, {144, 224, 80}},
    {"Ne", 1.54f, {179, 227, 245}}, {"Na", 2.27f, {171, 92, 242}},  {"Mg", 1.73f, {138, 255, 0}},
    {"Al", 1.84f, {191, 166, 166}}, {"Si", 2.10f, {240, 200, 160}}, {"P", 1.80f, {255, 128, 0}},
    {"S", 1.80f, {255, 255, 48}},   {"Cl", 1.75f, {31, 240, 31}},   {"Ar", 1.88f, {128, 209, 227}},
    {"K", 2.75f, {143, 64, 212}},   {"Ca", 2.31f, {61, 255, 0}},    {"Ti", 2.00f, {191, 194, 199}},
    {"V", 2.00f, {166, 166, 171}},  {"Cr", 2.00f, {138, 153, 199}}, {"Mn", 2.00f, {156, 122, 199}},
    {"Fe", 2.00f, {224, 102, 51}},  {"Co", 2.00f, {240, 144, 160}}, {"Ni", 1.63f, {80, 208, 80}},
    {"Cu", 1.40f, {200, 128, 51}},  {"Zn", 1.39f, {125, 128, 176}}, {"As", 1.85f, {189, 128, 227}},
    {"Se", 1.90f, {255, 161, 0}},   {"Br", 1.85f, {166, 41, 41}},   {"Kr", 2.02f, {92, 184, 209}},
    {"Rb", 3.03f, {112, 46, 176}},  {"Sr", 2.49f, {0, 255, 0}},     {"Mo", 2.00f, {84, 181, 181}},
    {"Ag", 1.72f, {192, 192, 192}}, {"Cd", 1.58f, {255, 217, 143}}, {"Sn", 2.17f, {102, 128, 128}},
    {"Te", 2.06f, {212, 122, 0}},   {"I", 1.98f, {148, 0, 148}},    {"Xe", 2.16f, {66, 158, 176}},
    {"Cs", 3.43f, {87, 23, 143}},   {"Ba", 2.68f, {0, 201, 0}},     {"Gd", 2.00f, {69, 255, 199}},
    {"W", 2.00f, {33, 148, 214}},   {"Pt", 1.75f, {208, 208, 224}}, {"Au", 1.66f, {255, 209, 35}},
    {"Hg", 1.55f, {184, 184, 208}}, {"Pb", 2.02f, {87, 89, 97}},    {"U", 1.86f, {0, 143, 255}},
    {"D", 1.10f, {255, 255, 192}},
}};

/// For what has no known element: Jmol's pink.
inline constexpr Element unknown_element{"?", 1.70f, {255, 20, 147}};

/// Ignores case. Null if there is no such element in the table.
const Element* find_element(std::string_view symbol);

/// The element whose standard atomic weight this is, rounded as people round it: to 1 in 1000, or to 0.01 if that is
/// more. Null if there is none; united atoms such as CH2 are none.
const Element* find_element_by_mass(double daltons);

}  // namespace farfield::scenes
