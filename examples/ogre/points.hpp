// Stand-ins as points that cover parts of pixels, blended back to front over what else is drawn.
#pragma once

#include <span>
#include <vector>

#include "farfield/drawables.hpp"
#include "piece.hpp"

namespace far_ogre {

/// Whatever is opaque hides them, whoever drew it; they hide nothing. All in one piece.
class Points {
  public:
    Points();

    void clear() { points_.clear(); }
    /// Nearer ones first. The matrix takes them to the eye.
    void add(std::span<const farfield::Splat> splats, const glm::dmat4& to_eye);
    /// Null: there is none.
    Ogre::Renderable* piece();

  private:
    struct Point {
        glm::vec3 place;
        glm::vec2 size;
        float opacity;
        farfield::Rgba8 color;
    };
    std::vector<Point> points_;
    Ogre::VertexData vertices_;
    Piece piece_;
};

}  // namespace far_ogre
