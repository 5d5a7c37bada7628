#include "scene.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <osg/AutoTransform>
#include <osg/Billboard>
#include <osg/Camera>
#include <osg/LOD>
#include <osg/Sequence>
#include <osg/Switch>
#include <osg/Transform>
#include <osg/TriangleIndexFunctor>
#include <stdexcept>
#include <string>

#include "farfield/build.hpp"
#include "farfield/executor.hpp"

namespace far_osg {
namespace {

struct Corners {
    std::vector<std::array<std::uint32_t, 3>> triangles{};
    void operator()(unsigned a, unsigned b, unsigned c) { triangles.push_back({a, b, c}); }
};

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw std::invalid_argument("far_osg: " + path + ": " + why);
}

/// The library refuses what single precision cannot hold, and knows no nodes.
template <class Build>
Hierarchy built(const std::string& path, Build&& build) {
    try {
        return build();
    } catch (const std::invalid_argument& error) {
        refuse(path, error.what());
    }
}

bool is_finite(const Mesh& mesh, std::uint32_t vertex) {
    const glm::dvec3 v = mesh.vertex(vertex);
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool is_affine(const osg::Matrixd& m) {
    for (int row = 0; row < 4; ++row) {
        for (int column = 0; column < 4; ++column) {
            if (!std::isfinite(m(row, column))) return false;
        }
    }
    return m(0, 3) == 0 && m(1, 3) == 0 && m(2, 3) == 0 && m(3, 3) == 1;
}

}  // namespace

/// Goes down the graph, with all that nodes hand down.
class Scene::Reader {
  public:
    explicit Reader(Scene& scene) : scene_(scene) {}

    Body& body(osg::Node& node, const States& states) {
        Body*& known = scene_.body_of_[{&node, states}];
        if (known == nullptr) {
            known = &scene_.bodies_.emplace_back();
            Body& body = *known;  // the map may grow
            path_.push_back(&node);
            body.path = path();
            path_.pop_back();
            read(node, osg::Matrixd(), states, body);
            body.hierarchy = built(body.path, [&] {
                return farfield::build_in_place<Hierarchy>(body.triangles, {.executor = executor_});
            });
            return body;
        }
        return *known;
    }

    /// How often what has several parents is placed below a node. To be asked first: it ends where reading would not.
    std::uint64_t placements(osg::Node& node) {
        osg::Group* group = node.asGroup();
        if (group == nullptr || node.getNodeMask() == 0) return 0;
        const auto known = placements_.find(&node);
        if (known != placements_.end()) return known->second;
        path_.push_back(&node);
        std::uint64_t sum = 0;
        for_each_child(*group, [&](osg::Node& child) {
            if (std::find(path_.begin(), path_.end(), &child) != path_.end()) refuse("it lies below its own child");
            sum += placements(child) + (child.getNumParents() > 1);
            if (sum > most_placements)
                refuse("what lies below it is placed more than " + std::to_string(most_placements) + " times");
        });
        path_.pop_back();
        if (node.getNumParents() > 1) placements_[&node] = sum;
        return sum;
    }

  private:
    std::string path() const {
        std::string path;
        for (const osg::Node* node : path_) {
            path += std::string(path.empty() ? "" : " > ") + node->libraryName() + "::" + node->className();
            if (!node->getName().empty()) path += " '" + node->getName() + "'";
        }
        return path;
    }
    [[noreturn]] void refuse(const std::string& why) const { far_osg::refuse(path(), why); }

    template <class F>
    static void for_each_child(osg::Group& group, F&& f) {
        const osg::Switch* chosen = group.asSwitch();
        for (unsigned i = 0; i < group.getNumChildren(); ++i) {
            if (chosen == nullptr || chosen->getValue(i)) f(*group.getChild(i));
        }
    }

    void read(osg::Node& node, osg::Matrixd to_body, States states, Body& body) {
        if (node.getNodeMask() == 0) return;
        path_.push_back(&node);
        if (osg::StateSet* state = node.getStateSet()) {
            check(*state);
            states.push_back(state);
        }
        if (dynamic_cast<osg::LOD*>(&node))
            refuse("the eye's distance chooses among its children; give the finest one");
        if (dynamic_cast<osg::Sequence*>(&node)) refuse("time chooses among its children");
        if (dynamic_cast<osg::AutoTransform*>(&node) || dynamic_cast<osg::Billboard*>(&node))
            refuse("it turns to the eye, and stand-ins do not");
        if (node.asDrawable() != nullptr) {
            const osg::Geometry* geometry = node.asGeometry();
            if (geometry == nullptr) refuse("it is drawn, but no osg::Geometry, whose triangles could be read");
            add(*geometry, to_body, states, body);
        } else if (osg::Group* group = node.asGroup()) {
            if (osg::Transform* transform = node.asTransform()) {
                if (dynamic_cast<osg::Camera*>(&node) || transform->getReferenceFrame() != osg::Transform::RELATIVE_RF)
                    refuse("it is not placed relative to its parent");
                osg::Matrixd own;
                transform->computeLocalToWorldMatrix(own, nullptr);
                if (!is_affine(own)) refuse("its matrix is not affine and finite");
                to_body = own * to_body;
            }
            for_each_child(*group, [&](osg::Node& child) {
                if (child.getNumParents() > 1) {
                    body.parts.push_back({&this->body(child, states), to_body});
                } else {
                    read(child, to_body, states, body);
                }
            });
        }
        path_.pop_back();
    }

    void check(const osg::StateSet& state) const {
        if (!state.getTextureAttributeList().empty()) refuse("it has a texture, which stand-ins would lack");
        if (state.getAttribute(osg::StateAttribute::PROGRAM)) refuse("a shader gives its colors, which stand-ins lack");
        if (state.getMode(GL_BLEND) & osg::StateAttribute::ON) refuse("it is blended, which needs an order of its own");
        if (state.getMode(GL_LIGHTING) & osg::StateAttribute::ON)
            refuse("it is lit, and stand-ins are not: bake the light into its colors");
    }

    void add(const osg::Geometry& geometry, const osg::Matrixd& to_body, const States& states, Body& body) {
        const osg::Array *vertices = geometry.getVertexArray(), *colors = geometry.getColorArray();
        const unsigned count = vertices == nullptr ? 0 : vertices->getNumElements();
        Corners corners;
        for (const auto& set : geometry.getPrimitiveSetList()) {
            if (set->getMode() < GL_TRIANGLES || set->getMode() > GL_POLYGON)
                refuse("its primitives are not all triangles, quadrangles or polygons");
            if (set->getNumInstances() > 0) refuse("its primitives are instanced by a shader");
            // Without indices none is drawn twice: what claims to have billions is not even counted out.
            if (set->getDrawElements() == nullptr && set->getNumIndices() > count)
                refuse("it draws " + std::to_string(set->getNumIndices()) + " of " + std::to_string(count) +
                       " vertices");
            osg::TriangleIndexFunctor<Corners> of_set;
            set->accept(of_set);
            corners.triangles.insert(corners.triangles.end(), of_set.triangles.begin(), of_set.triangles.end());
        }
        if (corners.triangles.empty()) return;
        if (vertices == nullptr || vertices->getType() != osg::Array::Vec3ArrayType)
            refuse("its vertices must be an osg::Vec3Array");
        if (colors != nullptr && colors->getNumElements() != 0) {
            if (colors->getType() != osg::Array::Vec4ArrayType && colors->getType() != osg::Array::Vec4ubArrayType)
                refuse("its colors must be an osg::Vec4Array or an osg::Vec4ubArray");
            if (colors->getBinding() != osg::Array::BIND_OVERALL &&
                (colors->getBinding() != osg::Array::BIND_PER_VERTEX || colors->getNumElements() < count))
                refuse("its colors must be one for all or one for each vertex");
        }
        Mesh& mesh = body.meshes.emplace_back();
        mesh.geometry = &geometry;
        mesh.to_body = to_body;
        mesh.states = states;
        mesh.number = std::uint32_t(body.meshes.size() - 1);
        for (const auto& corner : corners.triangles) {
            for (const std::uint32_t i : corner) {
                if (i >= count)
                    refuse("an index is " + std::to_string(i) + ", of " + std::to_string(count) + " vertices");
                if (!is_finite(mesh, i)) refuse("vertex " + std::to_string(i) + " is not finite");
            }
            body.triangles.push_back({&mesh, corner});
        }
    }

    Scene& scene_;
    farfield::AnyExecutor executor_{farfield::ThreadExecutor()};
    std::vector<const osg::Node*> path_;
    std::map<const osg::Node*, std::uint64_t> placements_;  ///< below what has several parents
};

Scene::Scene(osg::Node& root) : root_(&root) {
    Reader reader(*this);
    reader.placements(root);
    Body& all = reader.body(root, {});
    place(all, osg::Matrixd());
    hierarchy_ = built(all.path, [&] { return farfield::build<Hierarchy>(placements_); });
}

void Scene::place(Body& body, const osg::Matrixd& to_world) {
    for (const auto& [part, to_body] : body.parts) place(*part, to_body * to_world);
    if (body.triangles.empty()) return;
    try {
        // osg's rows times vectors are glm's columns: the same numbers in memory.
        placements_.push_back({&body.hierarchy, body.triangles, farfield::Similarity(glm::make_mat4(to_world.ptr()))});
    } catch (const std::invalid_argument&) {
        Body& stretched = bodies_.emplace_back();
        for (const Mesh& mesh : body.meshes) {
            stretched.meshes.push_back(mesh);
            stretched.meshes.back().to_body = mesh.to_body * to_world;
        }
        stretched.triangles = body.triangles;
        for (MeshTriangle& t : stretched.triangles) {
            t.mesh = &stretched.meshes[t.mesh->number];
            for (const std::uint32_t i : t.corners) {
                if (!is_finite(*t.mesh, i)) refuse(body.path, "where it is placed a vertex is not finite");
            }
        }
        stretched.hierarchy =
            built(body.path, [&] { return farfield::build_in_place<Hierarchy>(stretched.triangles); });
        placements_.push_back({&stretched.hierarchy, stretched.triangles, farfield::Similarity()});
    }
}

osg::BoundingBox Scene::bounds() const {
    const farfield::Box box = hierarchy_.bounds();
    if (box.is_empty()) return {};
    const glm::dvec3 origin = hierarchy_.origin();
    const glm::vec3 lower(glm::dvec3(box.lower) + origin), upper(glm::dvec3(box.upper) + origin);
    return {lower.x, lower.y, lower.z, upper.x, upper.y, upper.z};
}

std::size_t Scene::triangles() const {
    std::size_t sum = 0;
    for (const Body& body : bodies_) sum += body.triangles.size();
    return sum;
}

}  // namespace far_osg
