// Room on the disk for a build outside of memory: what it takes at most is known before anything is moved, from how
// many primitives there are, and how large each is.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <system_error>

#include "farfield/hierarchy/node.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/storage/mapped_file.hpp"

namespace farfield::detail {

/// How many cells primitives may be divided into. A primitive goes no farther down than cells that are as large as it
/// is, and a cell is split where what goes on costs more than what stands for the children: a level has no more cells
/// than the cost of what reaches it pays for. Clusters of a few primitives, far apart, come near that.
class MostCells {
  public:
    /// `half`: of the root cell's side.
    void add(float side, float half, float cost) {
        int halvings = most_levels;
        if (side > 0) halvings = side <= half ? std::min(std::ilogb(half / side), most_levels - 1) + 1 : 0;
        const auto level = std::size_t(halvings);
        ++count_[level];
        cost_[level] += double(cost);
        most_cost_ = std::max(most_cost_, cost);
    }
    void add(const MostCells& other) {
        for (std::size_t level = 0; level < count_.size(); ++level) {
            count_[level] += other.count_[level];
            cost_[level] += other.cost_[level];
        }
        most_cost_ = std::max(most_cost_, other.most_cost_);
    }
    /// `deepest`: the last level that there may be. `least`: what a child costs at least; 0 where cells are split
    /// whatever it costs.
    double cells(unsigned deepest, float least) const {
        double cells = 1, count = 0, cost = 0;
        for (std::size_t level = count_.size() - 1; level > 0; --level) {
            count += double(count_[level]);
            cost += cost_[level];
            if (level > deepest) continue;
            const double paid = least > 0 ? std::min(count, cost / double(least)) : count;
            cells += std::min(paid, std::ldexp(1.0, 3 * int(level)));
        }
        return cells;
    }
    /// The same for one primitive, of any share.
    double cells_each(unsigned deepest, float least) const {
        std::size_t level = count_.size() - 1;
        while (level > 0 && count_[level] == 0) --level;
        return double(std::min<std::size_t>(level, deepest)) *
               (least > 0 ? std::min(1.0, double(most_cost_) / double(least)) : 1.0);
    }

  private:
    static constexpr int most_levels = 64;
    std::array<std::uint64_t, most_levels + 1> count_{};  ///< by the last level that primitives may reach
    std::array<double, most_levels + 1> cost_{};
    float most_cost_ = 0;
};

/// What is known of a scene, or a share of it, of which pages are to be made.
struct ContentsOfPages {
    std::uint64_t primitives = 0;
    double cells = 0;                ///< at most
    double cells_each = 0;           ///< for a primitive, at most
    std::uint64_t in_long_runs = 0;  ///< primitives of cells that keep more than max_items_unculled for themselves
};

/// Bytes of pages at most. A page ends where the next unit does not fit: a short one leaves little room, and one that
/// is longer than all others less than it takes itself.
template <class H, class P>
double bytes_of_pages(const ContentsOfPages& contents, std::uint32_t page_bytes) {
    using Records = PageRecords<H, P>;
    constexpr double records = 2.0 * (sizeof(Node) + Records::node_data_bytes) + Records::stand_in_bytes,
                     before_contents = double(sizeof(PageHeader)) + records + double(sizeof(P)),
                     unit = 2.0 * max_items_unculled * sizeof(P) + 8 * records;
    const double room = std::max(double(page_bytes) - before_contents, 0.25 * double(page_bytes)),
                 used = std::max(room - unit, room / 2);
    const double in_long_runs = double(contents.in_long_runs) * sizeof(P),
                 others = double(contents.primitives) * sizeof(P) - in_long_runs + contents.cells * records;
    return double(page_bytes) * ((others + 2 * in_long_runs) / used + 1);
}

/// Throws std::runtime_error that names the file to be if there is no room for it: on its disk, as far as the system
/// says, or in `most_bytes`.
inline void check_disk_room(const std::filesystem::path& path, std::uint64_t needed, std::uint64_t most_bytes) {
    const auto refuse = [&](const char* has, std::uint64_t bytes, const char* after) {
        // Rounded so that what is refused never looks as if it fitted.
        refuse_file("build_pages", path,
                    "needs about " + std::to_string((needed >> 20) + 1) + " MiB of the disk, and " + has + " " +
                        std::to_string(bytes >> 20) + after);
    };
    if (needed > most_bytes) refuse("may take", most_bytes, " (most_disk_bytes)");
    std::error_code error;
    const std::filesystem::path folder = path.parent_path();
    const std::filesystem::space_info space = std::filesystem::space(folder.empty() ? "." : folder, error);
    if (!error && needed > space.available) refuse("there are", space.available, " left");
}

}  // namespace farfield::detail
