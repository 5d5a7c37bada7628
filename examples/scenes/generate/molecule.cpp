#include "scenes/generate/molecule.hpp"

#include <array>
#include <string_view>

#include "scenes/generate/point_grid.hpp"
#include "scenes/generate/random.hpp"
#include "scenes/load/atoms.hpp"
#include "scenes/load/element.hpp"

namespace farfield::scenes {
namespace {

using glm::vec3;

constexpr float bond_length = 1.45f;
constexpr float least_distance = 1.2f;

// Side chains as heavy atoms one after the other, as common in proteins as their place in the list is:
// alanine, valine or threonine, leucine, aspartate, lysine, glutamate, methionine, phenylalanine (unrolled),
// glycine.
constexpr std::array<std::string_view, 10> side_chains{"C",    "CCC",  "CCCC",    "CCO", "CCCCN",
                                                       "CCCO", "CCSC", "CCCCCCC", "CO",  ""};

/// A chain that wanders inside one globe after the other, as the domains of a folded protein.
class Folding {
  public:
    explicit Folding(std::uint64_t seed) : random_(seed), grid_(2.0f * least_distance) {
        constexpr float radius = 17.0f;
        globes_.push_back({vec3(0), radius});
        while (globes_.size() < 5) {
            const Globe& old = globes_[random_.below(globes_.size())];
            const vec3 center = old.center + random_.direction() * (1.2f * radius);
            bool apart = true;
            for (const Globe& globe : globes_) apart &= glm::length(center - globe.center) > 1.0f * radius;
            if (apart) globes_.push_back({center, radius * random_.between(0.85f, 1.15f)});
        }
    }

    std::vector<Atom> atoms(std::size_t count) {
        const std::size_t per_globe = count / globes_.size() + 1;
        bool placed = false;
        vec3 last{};
        while (atoms_.size() < count) {
            globe_ = globes_[std::min(atoms_.size() / per_globe, globes_.size() - 1)];
            if (!placed) last = fresh_start();
            placed = residue(last, count);
        }
        return std::move(atoms_);
    }

  private:
    struct Globe {
        vec3 center;
        float radius;
    };

    void put(const vec3& p, char symbol) {
        const Element& element = *find_element(std::string_view(&symbol, 1));
        atoms_.push_back({p, element.radius, element.color});
        grid_.add(p);
    }

    /// The best of some free places at bond length from `from`; false if there is none.
    bool step(const vec3& from, vec3& to) {
        float best = 1e30f;
        for (int i = 0; i < 24; ++i) {
            const vec3 p = from + random_.direction() * bond_length;
            if (grid_.any_within(p, least_distance)) continue;
            // Inwards, but not straight: the globe fills from its middle and its surface stays rough.
            const float out = glm::length(p - globe_.center) / globe_.radius;
            const float cost = 4.0f * out + random_.unit();
            if (cost < best) {
                best = cost;
                to = p;
            }
        }
        return best < 1e30f;
    }

    /// N, C-alpha with its side chain, C, O. `last` is the carbon it hangs on, then its own. False if the
    /// chain is stuck.
    bool residue(vec3& last, std::size_t count) {
        vec3 nitrogen{}, alpha{}, carbon{}, oxygen{};
        const auto full = [&] { return atoms_.size() >= count; };
        if (full() || !step(last, nitrogen)) return false;
        put(nitrogen, 'N');
        if (full() || !step(nitrogen, alpha)) return false;
        put(alpha, 'C');
        vec3 from = alpha;
        for (const char symbol : side_chains[random_.below(side_chains.size())]) {
            vec3 to{};
            if (full() || !step(from, to)) break;
            put(to, symbol);
            from = to;
        }
        if (full() || !step(alpha, carbon)) return false;
        put(carbon, 'C');
        if (!full() && step(carbon, oxygen)) put(oxygen, 'O');
        last = carbon;
        return true;
    }

    /// Where a new chain can begin: further and further out from the middle of the globe.
    vec3 fresh_start() {
        for (float reach = 0.0f;; reach += 0.02f) {
            const vec3 p = globe_.center + random_.direction() * reach;
            if (!grid_.any_within(p, 2.0f * least_distance)) return p;
        }
    }

    Random random_;
    PointGrid grid_;
    std::vector<Globe> globes_;
    Globe globe_{};
    std::vector<Atom> atoms_;
};

}  // namespace

Scene molecule(std::uint64_t seed) {
    const std::vector<Atom> atoms = Folding(seed).atoms(molecule_atoms);
    const UnitSphere sphere = latitude_longitude_sphere(20, 21);
    Scene scene{"molecule", std::vector<Group>(1)};
    scene.groups[0].triangles = spheres(atoms, sphere);
    return scene;
}

}  // namespace farfield::scenes
