// What a build outside of memory learns of a scene before it moves anything: the bounds of all, and the number of
// primitives in each cell of its first levels. The stream is read once for each, since cells begin with bounds.
#pragma once

#include "farfield/settings.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "farfield/build.hpp"
#include "farfield/build/build_node.hpp"
#include "farfield/build/build_progress.hpp"
#include "farfield/build/read_primitives.hpp"
#include "farfield/build_pages/disk_room.hpp"
#include "farfield/build_pages/page_build.hpp"
#include "farfield/build_pages/stream_batches.hpp"
#include "farfield/build_pages/top_tree.hpp"
#include "farfield/composition.hpp"
#include "farfield/fail.hpp"
#include "farfield/geometry/cell.hpp"
#include "farfield/hierarchy/fingerprint.hpp"
#include "farfield/hierarchy/node.hpp"
#include "farfield/paging/page_format.hpp"
#include "farfield/storage/checksum.hpp"

namespace farfield {
namespace detail {

template <class Build>
class SceneSurvey {
    using H = typename Build::hierarchy_type;
    using P = typename Build::primitive_type;
    using Sampler = typename Build::sampler_type;
    using Partition_ = typename H::partition_type;
    using A = typename H::approximation_type;
    using Bounds = decltype(primitive_traits<P>::bounds(std::declval<const P&>()));

  public:
    explicit SceneSurvey(Build& build) : build_(build) {}

    /// Fills in the facts of the plan, but for its work, and the identity.
    template <class Stream>
    void read_bounds(Stream& stream) {
        struct Found {
            Bounds bounds = Bounds::empty();
            Fingerprint fingerprint;
            std::uint64_t contents = 0;
        };
        std::array<Found, stream_batches_at_once> found;
        Fingerprint fingerprint;
        Bounds whole = Bounds::empty();
        std::uint64_t contents = 0;
        const std::uint64_t count = in_batches<P>(
            stream, build_.control,
            [&](std::span<const P> batch, std::uint64_t first, std::size_t slot) {
                Found f;  // here, not there: slots of two threads share lines of their caches
                for (const P& p : batch) {
                    const auto index = std::size_t(first + std::uint64_t(&p - batch.data()));
                    const auto b = checked_bounds(p, index);
                    f.bounds.add(b);
                    f.fingerprint.add(Fingerprint::part(index, b));
                }
                f.contents = Xxh64::of(std::as_bytes(batch));
                found[slot] = f;
            },
            [&](std::span<const P> batch, std::uint64_t first, std::size_t slot) {
                whole.add(found[slot].bounds);
                fingerprint.add(found[slot].fingerprint.sum());
                contents = mixed(contents, found[slot].contents);
                report(BuildPhase::reading, first + batch.size(), 0);
            });
        check_primitive_count(std::size_t(count));
        build_.plan.facts = {};
        build_.plan.facts.primitive_count = build_.plan.facts.report.primitives = build_.plan.facts.report.items =
            count;
        build_.plan.facts.fingerprint = fingerprint.of(std::size_t(count));
        build_.plan.facts.origin = origin_of<P>(whole, build_.options.build.world);
        // Rounding keeps the order of numbers: these are the bounds of all local bounds.
        if (count != 0) {
            if constexpr (has_double_bounds<P>) {
                add_bounds(build_.plan.facts.bounds,
                           {glm::vec3(whole.lower - build_.plan.facts.origin),
                            glm::vec3(whole.upper - build_.plan.facts.origin)},
                           std::size_t(count - 1));
            } else {
                add_bounds(build_.plan.facts.bounds, whole, std::size_t(count - 1));
            }
        }
        build_.plan.facts.root =
            build_.options.build.partition.root(bounds_of_root(build_.plan.facts, build_.options.build.world));
        tell_light<A>(build_.options.build.sampler, build_.plan.facts);
        build_.plan.identity = mixed(identity(), contents);
    }
    /// The primitives' work goes into the plan's facts.
    template <class Stream>
    CellCounts<Partition_> count_cells(Stream& stream) {
        CellCounts<Partition_> counts(build_.options.build.partition, build_.plan.facts.root, Build::counted_levels);
        using Place = typename CellCounts<Partition_>::Place;
        struct Found {
            std::vector<std::pair<Place, std::uint32_t>> runs;  ///< of items in one place
            Work work;
            MostCells cells;
        };
        std::vector<Found> found(stream_batches_at_once);
        MostCells most_cells;
        const float half = counts.root().half.x;
        WorkSum work_of_all;
        const std::uint64_t count = in_batches<P>(
            stream, build_.control,
            [&](std::span<const P> batch, std::uint64_t first, std::size_t slot) {
                Found f{std::move(found[slot].runs), {}, {}};
                f.runs.clear();
                auto path = counts.path();
                for (std::size_t i = 0; i < batch.size(); ++i) {
                    const auto [item, work] = read_item(batch[i], std::size_t(first) + i,
                                                        build_.options.build.cost_model, build_.plan.facts.origin);
                    const Place place = counts.place_of(item, path);
                    if (f.runs.empty() || f.runs.back().first != place) f.runs.emplace_back(place, 0u);
                    ++f.runs.back().second;
                    f.work += work;
                    f.cells.add(item.bounds.largest_side(), half, item.cost);
                }
                found[slot] = std::move(f);
            },
            [&](std::span<const P> batch, std::uint64_t first, std::size_t slot) {
                for (const auto& [place, items] : found[slot].runs) counts.add(place, items);
                work_of_all.add(found[slot].work);
                most_cells.add(found[slot].cells);
                report(BuildPhase::counting, first + batch.size(), build_.plan.facts.primitive_count);
            });
        check_stream(count);
        build_.plan.facts.work = work_of_all.total();
        counts.sum_up();
        const auto& b = build_.options.build;
        typename Partition_::node_data data{};
        const bool always = b.partition.choose(counts.root(), {}, data) == Split::always;
        const float least = always ? 0 : least_cost_to_split(b.approximation, b.cost_model, 1);
        const unsigned deepest = deepest_level(counts);
        contents_ = {count, most_cells.cells(deepest, least), most_cells.cells_each(deepest, least),
                     counts.in_long_runs(max_items_unculled)};
        return counts;
    }
    /// What pages of the scene will hold. Once cells have been counted.
    const ContentsOfPages& contents() const { return contents_; }
    /// Throws std::invalid_argument if the stream gave more or fewer primitives than at first.
    void check_stream(std::uint64_t count) const {
        if (count == build_.plan.facts.primitive_count) return;
        fail<std::invalid_argument>("farfield::build_pages: the stream gave " +
                                    std::to_string(build_.plan.facts.primitive_count) +
                                    " primitives at first, and now " + std::to_string(count));
    }

  private:
    void report(BuildPhase phase, std::uint64_t done, std::uint64_t all) const {
        if (done / Build::reported_each == (done - 1) / Build::reported_each) return;
        build_.control.report(phase, std::size_t(done), std::size_t(all));
    }
    /// That the partition allows, near the middle of the scene, where single precision reaches deepest.
    static unsigned deepest_level(const CellCounts<Partition_>& counts) {
        unsigned level = 0;
        for (Cell cell = counts.root(); level < 64 && counts.is_split(cell); ++level) {
            cell = counts.partition().child(cell, {}, level == 0 ? 7 : 0);
        }
        return level;
    }
    std::uint64_t identity() const {
        std::uint64_t hash = mixed(build_.plan.facts.fingerprint, build_.plan.facts.primitive_count);
        for (const std::uint32_t tag : page_records<H, P>()) hash = mixed(hash, tag);
        for (const auto& bytes : {bytes_of(build_.options.build.partition),
                                  bytes_of<stored_approximation_of<A>>(build_.options.build.approximation),
                                  bytes_of(build_.options.build.cost_model)}) {
            hash = mixed(hash, Xxh64::of(bytes));
        }
        if constexpr (MadeOfNumbers<Sampler>) hash = mixed(hash, Xxh64::of(bytes_of(build_.options.build.sampler)));
        hash = mixed(hash, Xxh64::of(build_.notes));
        return mixed(mixed(hash, build_.plan.most_items), build_.options.page_bytes);
    }

    Build& build_;
    ContentsOfPages contents_;
};

}  // namespace detail

}  // namespace farfield
