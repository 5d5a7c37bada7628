// Tells whether any part of a polygon's bounding box, or of a box's silhouette, may be seen (Greene 1996, sections 4.3
// and 5.2). Compiled once for each instruction set: see coverage_tiler.inl.

struct StartCell {
    int level, x, y;
};

/// "We first determine whether its bounding box is visible. If this procedure fails to prove that the polygon is
/// hidden, we then tile it into the smallest enclosing cell" (section 4.3). Here it is the smallest cells of which two
/// by two enclose it, so that lying on a large cell's border costs nothing. There are none if it is hidden or its box
/// holds no sample.
template <class Target>
class StartCells {
  public:
    /// `is_small` says that triage is not worth its cost.
    StartCells(const Target& target, const TileBox& box, const CellDepths<Target>& depths, bool is_small)
        : pyramid_(target.pyramid), box_(box), depths_(depths), is_small_(is_small) {
        if (box.x0 > box.x1 || box.y0 > box.y1) return;
        int level = 1;
        while ((box.x1 >> 3 * (level + 1)) - (box.x0 >> 3 * (level + 1)) > 1 ||
               (box.y1 >> 3 * (level + 1)) - (box.y0 >> 3 * (level + 1)) > 1) {
            ++level;
        }
        level = std::min(level, pyramid_.top_level());
        while (true) {
            count_ = 0;
            int wanted = level;
            const int shift = 3 * (level + 1);
            for (int y = box.y0 >> shift; y <= box.y1 >> shift; ++y) {
                for (int x = box.x0 >> shift; x <= box.x1 >> shift; ++x) wanted = std::max(wanted, choose(level, x, y));
            }
            if (wanted == level) return;
            level = wanted;
        }
    }

    bool empty() const { return count_ == 0; }
    const StartCell* begin() const { return cells_.data(); }
    const StartCell* end() const { return cells_.data() + count_; }

  private:
    /// Returns the level to begin at, which may be another.
    int choose(int level, int x, int y) {
        const std::size_t cell = pyramid_.index(level, x, y);
        if (const CoveredAbove above = depths_.covered_above(level, x, y); above.level != 0) {
            return above.is_hidden ? level : above.level;
        }
        const std::uint64_t wanted = box_.subcells(level, x, y);
        std::uint64_t hidden = wanted & pyramid_[cell].covered;
        if (hidden != 0) {
            hidden &=
                is_small_ && level == 1 ? depths_.few_behind(hidden, cell, x, y) : depths_.behind(cell, level, x, y);
        }
        if (hidden != wanted) cells_[std::size_t(count_++)] = {level, x, y};
        return level;
    }

    const CoveragePyramid& pyramid_;
    const TileBox& box_;
    const CellDepths<Target>& depths_;
    const bool is_small_;
    int count_ = 0;
    std::array<StartCell, 4> cells_;
};

/// "Returning TRUE whenever a polygon's mask indicates that it covers a vacant subcell or a vacant grid point"
/// (section 5.2). A subcell that is covered, but not by something nearer throughout, counts as seen.
template <class Target>
class CoverageQuery {
    using Edges = typename TileEdges<Target>::Edges;
    using Triage = typename TileEdges<Target>::Triage;

  public:
    CoverageQuery(Target& target, const Silhouette& box, int grown_by)
        : target_(target),
          pyramid_(target.pyramid),
          edges_(target, box.outline, grown_by),
          depths_(target, box.fronts.planes.data(), box.fronts.count) {}

    bool is_seen(int grown_by) {
        const StartCells<Target> start(target_, edges_.box, depths_, false);
        if (start.empty()) return false;
        edges_.prepare(grown_by);
        edges_.tabulate();
        return std::any_of(start.begin(), start.end(), [&](const StartCell& s) {
            return sees_cell(s.level, s.x, s.y, edges_.at(s.level, s.x, s.y));
        });
    }

  private:
    bool sees_cell(int level, int x, int y, const Edges& in) {
        target_.work.asks(level, x, y);
        Triage t;
        if (!edges_.triage(level, x, y, in, t)) return false;
        const std::size_t at = pyramid_.index(level, x, y);
        const TriageMask cell = pyramid_[at];
        const std::uint64_t behind = pyramid_.is_untouched(at) ? all_subcells : depths_.behind(at, level, x, y);
        const std::uint64_t possible = t.possible & ~(cell.covered & behind);
        if (possible == 0) return false;
        // Subcells that are covered, but not by something nearer throughout, have to be looked into.
        if ((possible & t.covered & ~cell.covered) != 0) return true;
        if (level == 1 && (possible & cell.covered) != 0) return true;
        const std::uint64_t* masks = level == 1 ? pyramid_.samples_of_block(at) : nullptr;
        for (std::uint64_t left = possible; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            const int child_x = 8 * x + int(k % 8), child_y = 8 * y + int(k / 8);
            if (level > 1) {
                const Edges edges = edges_.inside(t, k, level);
                if (sees_child(at, k, level - 1, child_x, child_y, edges)) return true;
                continue;
            }
            target_.work.asks(0, child_x, child_y);
            const bool counts = (~cell.vacant & behind & bit_of(k)) != 0;
            const std::uint64_t covered = counts ? masks[k] : pyramid_.samples_outside(child_x, child_y);
            if ((edges_.samples_inside(t, x, y, k) & ~covered) != 0) return true;
        }
        return false;
    }

    bool sees_child(std::size_t parent, unsigned k, int level, int x, int y, const Edges& in) {
        if constexpr (Target::is_lazy) {
            if (depths_.is_whole(parent, k)) return sees_before(depths_.cover_of(parent, k), level, x, y, in);
        }
        return sees_cell(level, x, y, in);
    }

    /// Searches a cell that one surface covers entirely, down to masks: a part of one counts as seen.
    bool sees_before(const DepthPlane& one, int level, int x, int y, const Edges& in) {
        target_.work.asks(level, x, y);
        Triage t;
        if (!edges_.triage(level, x, y, in, t)) return false;
        const std::uint64_t possible = t.possible & ~depths_.behind_surface(one, level, x, y);
        if (level == 1) return possible != 0;
        for (std::uint64_t left = possible; left != 0; left &= left - 1) {
            const auto k = unsigned(std::countr_zero(left));
            if (sees_before(one, level - 1, 8 * x + int(k % 8), 8 * y + int(k / 8), edges_.inside(t, k, level)))
                return true;
        }
        return false;
    }

    Target& target_;
    CoveragePyramid& pyramid_;
    TileEdges<Target> edges_;
    CellDepths<Target> depths_;
};
