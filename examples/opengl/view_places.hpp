// Where the coordinates of views lie in the outermost hierarchy's, as the GPU knows it: the rows of all instances
// follow from one view's there, so that a camera that moves sends one.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <unordered_map>
#include <vector>

#include "farfield/view/local_view.hpp"
#include "opengl/chunk_store.hpp"
#include "opengl/view_row.hpp"

namespace farfield::opengl {

/// A similarity. Its place is two numbers of single precision a coordinate: the difference to an eye that is given in
/// single precision is then rounded as that to a place in double precision would be, but for the last bit.
struct PlacedRow {
    glm::vec4 x, y, z;  ///< axes, in the outermost coordinates; w: scale, bits of LocalView::seed, unused
    glm::vec4 place, rest;
};
static_assert(sizeof(PlacedRow) == 80);

/// What is needed of a LocalView.
struct ViewPlace {
    glm::mat3 turned{1.0f};
    glm::dvec3 place{0.0};
    float scale = 1;
    std::uint32_t seed = 0;

    ViewPlace() = default;
    explicit ViewPlace(const LocalView& v) : turned(v.turned), place(v.place), scale(v.scale), seed(v.seed) {}
    bool is_outermost() const { return turned == glm::mat3(1.0f) && place == glm::dvec3(0.0) && scale == 1; }
};

/// `origin` is that of the vertices, in the view's coordinates.
inline PlacedRow placed_row(const ViewPlace& view, glm::vec3 origin) {
    const glm::mat3& axes = view.turned;
    const glm::dvec3 place = view.place - glm::dmat3(axes) * glm::dvec3(origin) * double(view.scale);
    const glm::vec3 first(place);
    PlacedRow row{glm::vec4(axes[0], view.scale), glm::vec4(axes[1], 0), glm::vec4(axes[2], 0), glm::vec4(first, 0),
                  glm::vec4(glm::vec3(place - glm::dvec3(first)), 0)};
    std::memcpy(&row.y.w, &view.seed, sizeof view.seed);
    return row;
}

/// Numbers of views that stay what they are from frame to frame.
class ViewPlaces {
  public:
    std::vector<PlacedRow> places;    ///< by number
    std::vector<std::uint32_t> used;  ///< a bit for each that the frame uses

    void begin() {
        if (places.size() > 4096 && places.size() > 8 * count_) {
            places.clear();
            numbers_.clear();
        }
        used.assign((places.size() + 31) / 32, 0);
        count_ = 0;
    }
    std::uint32_t number_of(const PlacedRow& row) {
        const auto [found, is_new] = numbers_.try_emplace(hash_of(0, row), std::uint32_t(places.size()));
        const std::uint32_t number = found->second;
        if (is_new) {
            places.push_back(row);
            used.resize((places.size() + 31) / 32);
        }
        std::uint32_t& word = used[number / 32];
        const std::uint32_t bit = 1u << number % 32;
        count_ += (word & bit) == 0;
        word |= bit;
        return number;
    }

  private:
    std::unordered_map<std::uint64_t, std::uint32_t> numbers_;
    std::size_t count_ = 0;  ///< that the frame uses
};

}  // namespace farfield::opengl
