#include "farfield/paging/page_slots.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "catch.hpp"
#include "support/random.hpp"

using namespace farfield;
using namespace farfield::test;
using farfield::detail::PageSlots;
using farfield::detail::PageVisits;

namespace {

/// Slots, and users whose frames are made by hand.
struct Table {
    PageSlots slots;
    std::vector<std::unique_ptr<PageVisits>> users;
    std::vector<PageVisits*> all;

    Table(std::uint32_t pages, std::uint32_t slot_count, std::size_t user_count = 1) : slots(pages, slot_count) {
        for (std::size_t i = 0; i < user_count; ++i) {
            users.push_back(std::make_unique<PageVisits>(slot_count));
            all.push_back(users.back().get());
        }
    }
    /// Whether there was room.
    bool load(std::uint32_t page, float weight, const PageVisits* own = nullptr, PageVisits* wanted_by = nullptr) {
        const std::uint32_t slot = slots.take(weight, all, own);
        if (slot != PageSlots::none) slots.publish(page, slot, weight, false, wanted_by);
        return slot != PageSlots::none;
    }
    /// A frame that finds pages.
    std::uint32_t frame(const std::vector<std::uint32_t>& pages, float weight = 1, std::size_t user = 0) {
        const std::uint32_t f = slots.begin(*users[user]);
        for (const std::uint32_t p : pages) slots.find(p, *users[user], weight);
        PageSlots::end(*users[user]);
        return f;
    }
    void frames(int count) {
        for (int i = 0; i < count; ++i) frame({});
    }
    std::vector<std::uint32_t> resident() const {
        std::vector<std::uint32_t> pages;
        for (std::uint32_t p = 0; p < slots.page_count(); ++p) {
            if (slots.is_resident(p)) pages.push_back(p);
        }
        return pages;
    }
};
using Pages = std::vector<std::uint32_t>;

}  // namespace

TEST_CASE("Pages fill the slots that are free, and then the least recently used one goes") {
    Table t(10, 3);
    for (const std::uint32_t p : {4u, 2u, 7u}) CHECK(t.load(p, 1));
    CHECK(t.resident() == Pages{2, 4, 7});
    CHECK(t.slots.resident() == 3);
    t.frame({4, 2, 7});
    t.frame({4, 7});
    t.frame({4, 7});
    CHECK(t.load(9, 1));
    CHECK(t.resident() == Pages{4, 7, 9});
    CHECK(t.slots.evictions() == 1);
    CHECK(t.slots.resident() == 3);
}

TEST_CASE("What the last frame used stays, but for what counts more than twice as much") {
    Table t(10, 2);
    t.load(1, 1);
    t.load(2, 1);
    t.slots.begin(*t.users[0]);
    t.slots.find(1, *t.users[0], 4);
    t.slots.find(2, *t.users[0], 3);
    PageSlots::end(*t.users[0]);
    CHECK_FALSE(t.load(3, 1));
    CHECK_FALSE(t.load(3, 5.9f));
    CHECK(t.load(3, 6.5f));
    CHECK(t.resident() == Pages{1, 3});
}

TEST_CASE("What a frame has not come to yet stays while it runs, if the frame before used it") {
    Table t(10, 3);
    for (const std::uint32_t p : {0u, 1u, 2u}) CHECK(t.load(p, 4));
    t.frame({0, 1, 2}, 4);
    t.slots.begin(*t.users[0]);
    t.slots.find(0, *t.users[0], 4);
    CHECK_FALSE(t.load(5, 7));  // less than twice as much
    t.slots.find(1, *t.users[0], 4);
    t.slots.find(2, *t.users[0], 4);
    PageSlots::end(*t.users[0]);
    CHECK(t.resident() == Pages{0, 1, 2});
    CHECK(t.slots.evictions() == 0);
    CHECK(t.load(5, 9));
}

TEST_CASE("The largest weight that a frame finds a page with counts") {
    Table t(10, 1);
    t.load(1, 1);
    t.slots.begin(*t.users[0]);
    t.slots.find(1, *t.users[0], 8);
    t.slots.find(1, *t.users[0], 2);
    PageSlots::end(*t.users[0]);
    CHECK_FALSE(t.load(2, 15));
    CHECK(t.load(2, 17));
}

TEST_CASE("The weight of a page is what the frame that runs has found it with") {
    Table t(10, 2, 2);
    const std::uint32_t stays = t.slots.take(1, t.all, nullptr);
    t.slots.publish(0, stays, 1, true);
    t.load(1, 1);
    t.slots.begin(*t.users[0]);
    t.slots.begin(*t.users[1]);
    const std::uint32_t slot = t.slots.find(1, *t.users[0], 4);
    t.slots.find(1, *t.users[0], 3);
    t.slots.find(1, *t.users[1], 1);
    CHECK(PageSlots::weight_of(slot, *t.users[0]) == 4);
    CHECK(PageSlots::weight_of(slot, *t.users[1]) == 1);
    CHECK(PageSlots::weight_of(stays, *t.users[0]) == std::numeric_limits<float>::infinity());
    PageSlots::end(*t.users[0]);
    t.slots.begin(*t.users[0]);
    t.slots.find(1, *t.users[0], 2);
    CHECK(PageSlots::weight_of(slot, *t.users[0]) == 2);
}

TEST_CASE("What one of several looks at in passing stays for another to whom it counts") {
    Table t(10, 2, 2);
    t.load(1, 1);
    t.load(2, 1);
    t.frame({1}, 8, 0);
    t.frame({2}, 4, 1);
    t.slots.begin(*t.users[1]);
    t.slots.find(1, *t.users[1], 1);
    t.slots.find(2, *t.users[1], 4);
    PageSlots::end(*t.users[1]);
    CHECK(t.load(3, 10));  // 2 goes
    CHECK(t.resident() == Pages{1, 3});
}

TEST_CASE("Who forgets has looked at nothing") {
    Table t(10, 2, 2);
    t.load(1, 1);
    t.load(2, 1);
    t.frame({1, 2}, 1, 0);
    t.frame({2}, 1, 0);
    t.frame({1}, 0x1p60f, 1);
    PageSlots::forget(*t.users[1]);
    CHECK(t.load(3, 1));
    CHECK(t.resident() == Pages{2, 3});
}

TEST_CASE("No page that goes cuts off what counts, whoever walks and however") {
    constexpr std::uint32_t pages = 60, slot_count = 12;
    constexpr std::size_t walkers = 3;
    struct Found {
        std::uint32_t page, parent;
        float weight;
    };
    std::size_t checked = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Table t(pages, slot_count, walkers);
        Random random(seed);
        t.slots.publish(0, t.slots.take(1, t.all, nullptr), 1, true);
        // What lies in a page is reached from one or two before it.
        std::vector<std::array<std::uint32_t, 2>> parents(pages);
        for (std::uint32_t p = 1; p < pages; ++p) parents[p] = {random.below(p), random.below(p)};
        std::vector<std::vector<Found>> found(walkers);  // by their last frames
        std::vector<std::uint32_t> went(pages), held_until(pages);
        const auto check = [&](std::uint32_t gone) {
            for (std::uint32_t page = 1; page < pages; ++page) {
                if (!t.slots.is_resident(page) || held_until[page] > t.slots.frames()) continue;
                // By what does it count, and is that there?
                float most = 0;
                bool is_reached = true, was_cut_off = false;
                for (const auto& of_walker : found) {
                    for (const Found& f : of_walker) {
                        if (f.page != page || f.weight < most) continue;
                        const bool is_there = t.slots.is_resident(f.parent);
                        is_reached = (f.weight == most && is_reached) || is_there;
                        was_cut_off = was_cut_off || (!is_there && f.parent != gone);  // while it was held
                        most = f.weight;
                    }
                }
                if (most == 0 || was_cut_off) continue;
                ++checked;
                REQUIRE(is_reached);
            }
        };
        for (int step = 0; step < 600; ++step) {
            const std::size_t who = step < 3 ? std::size_t(step) : random.below(walkers);
            PageVisits& own = *t.users[who];
            t.slots.begin(own);
            found[who].clear();
            std::vector<Found> wanted;
            std::vector<std::pair<std::uint32_t, std::uint32_t>> seen{{0, t.slots.find(0, own, 0x1p20f)}};
            for (std::size_t i = 0; i < seen.size() && i < 30; ++i) {
                const auto [parent, slot] = seen[i];
                for (std::uint32_t p = parent + 1; p < pages; ++p) {
                    if ((parents[p][0] != parent && parents[p][1] != parent) || random.below(3) == 0) continue;
                    const float weight = std::min(random.between(1, 100), PageSlots::weight_of(slot, own));
                    const std::uint32_t at = t.slots.find(p, own, weight);
                    if (at == PageSlots::none) {
                        wanted.push_back({p, parent, weight});
                    } else {
                        found[who].push_back({p, parent, weight});
                        seen.emplace_back(p, at);
                    }
                }
            }
            PageSlots::end(own);
            for (const auto& [page, parent, weight] : wanted) {
                if (t.slots.is_resident(page)) continue;
                const Pages before = t.resident();
                const bool is_there = t.load(page, weight, nullptr, &own);
                for (const std::uint32_t gone : before) {
                    if (t.slots.is_resident(gone)) continue;
                    for (auto& of_walker : found) {
                        std::erase_if(of_walker, [&](const Found& f) { return f.page == gone; });
                    }
                    check(gone);
                    went[gone] = t.slots.frames();
                }
                const bool again = went[page] != 0 && t.slots.frames() - went[page] < 60;
                if (!is_there) continue;
                held_until[page] = again ? t.slots.frames() + 60 : 0;
                found[who].push_back({page, parent, weight});  // as if
            }
        }
        CHECK(t.slots.evictions() > 100);
    }
    CHECK(checked > 5000);
}

TEST_CASE("What is not needed yet replaces only what was not needed for sixteen frames") {
    Table t(10, 2);
    t.load(1, 1);
    t.load(2, 1);
    t.frame({1, 2});
    for (int i = 0; i < 16; ++i) {
        CHECK_FALSE(t.load(3, 0.5f));
        t.frame({1});
    }
    t.frame({1});
    CHECK(t.load(3, 0.5f));
    CHECK(t.resident() == Pages{1, 3});
}

TEST_CASE("Of pages that were last used together, the one that comes last in the file goes") {
    Table t(10, 3);
    for (const std::uint32_t p : {3u, 8u, 5u}) t.load(p, 1);
    t.frame({3, 8, 5});
    t.frame({});
    CHECK(t.load(1, 1));
    CHECK(t.resident() == Pages{1, 3, 5});
}

TEST_CASE("A page that stays stays, and one that came back within sixty frames stays as long") {
    Table t(10, 2);
    t.slots.publish(0, t.slots.take(1, t.all, nullptr), 1, true);
    t.load(1, 1);
    t.frame({1});
    t.frames(5);
    CHECK(t.load(2, 1));  // 1 goes
    t.frames(5);
    CHECK(t.load(1, 1));  // and comes back
    CHECK(t.slots.reloads() == 1);
    for (int i = 0; i < 59; ++i) {
        t.frames(1);
        CHECK_FALSE(t.load(2, std::numeric_limits<float>::infinity()));
    }
    t.frames(1);
    CHECK(t.load(2, 1));
    CHECK(t.slots.is_resident(0));
    // Which is again a page that went more than sixty frames ago, and is not held.
    CHECK(t.slots.reloads() == 1);
    t.frames(1);
    CHECK(t.load(3, 1));
}

TEST_CASE("A slot is not used again while a frame runs that began before its page went") {
    Table t(10, 2, 3);
    t.load(1, 1);
    t.load(2, 1);
    t.frame({2}, 1, 1);
    t.slots.begin(*t.users[0]);
    const std::uint32_t slot = t.slots.find(1, *t.users[0], 0.1f);
    t.slots.find(2, *t.users[0], 9);
    CHECK_FALSE(t.load(3, 1));  // 1 goes, and its memory is not free
    CHECK_FALSE(t.slots.is_resident(1));
    t.slots.begin(*t.users[1]);
    CHECK(t.slots.find(1, *t.users[1], 1) == PageSlots::none);
    t.slots.find(2, *t.users[1], 9);
    CHECK_FALSE(t.load(3, 1));
    PageSlots::end(*t.users[0]);
    // The other began after it went, and cannot have it.
    CHECK(t.load(3, 1));
    CHECK(t.slots.find(3, *t.users[1], 1) == slot);
    PageSlots::end(*t.users[1]);
}

TEST_CASE("A frame that waits takes what it has not found itself, and nothing that it has") {
    Table t(20, 3, 2);
    for (const std::uint32_t p : {1u, 2u, 3u}) t.load(p, 1);
    t.frame({1, 2, 3});
    t.slots.begin(*t.users[0]);
    const std::uint32_t mine = t.slots.find(1, *t.users[0], 0.1f);
    CHECK(t.load(4, 1, t.users[0].get()));
    CHECK(t.load(5, 1, t.users[0].get()));
    CHECK(t.resident() == Pages{1, 4, 5});
    t.slots.find(4, *t.users[0], 8);
    t.slots.find(5, *t.users[0], 8);
    // The one that it has found, and counts least, goes off the table, and yet its memory is left alone.
    CHECK_FALSE(t.load(6, 4, t.users[0].get()));
    CHECK(t.slots.find(1, *t.users[0], 0.1f) == PageSlots::none);
    PageSlots::end(*t.users[0]);
    CHECK(t.load(6, 4));
    t.slots.begin(*t.users[1]);
    CHECK(t.slots.find(6, *t.users[1], 1) == mine);
    PageSlots::end(*t.users[1]);
}

TEST_CASE("However long a frame lasts, not all pages go in the meantime") {
    Table t(200, 64, 2);
    for (std::uint32_t p = 0; p < 64; ++p) t.load(p, 1);
    t.slots.begin(*t.users[0]);
    t.slots.find(0, *t.users[0], 1);
    for (int i = 0; i < 10; ++i) t.frame({}, 1, 1);
    for (std::uint32_t p = 64; p < 164; ++p) CHECK_FALSE(t.load(p, 100));
    CHECK(t.slots.resident() >= 48);
    PageSlots::end(*t.users[0]);
    for (std::uint32_t p = 64; p < 72; ++p) CHECK(t.load(p, 100));
}

TEST_CASE("Users that have drawn nothing for long keep nothing") {
    Table t(10, 2, 2);
    t.load(1, 1);
    t.load(2, 1);
    t.frame({1}, 8, 1);
    t.frame({2}, 8, 0);
    CHECK_FALSE(t.load(3, 1));
    for (int i = 0; i < 60; ++i) t.frame({2}, 8, 0);
    CHECK(t.load(3, 1));
    CHECK(t.resident() == Pages{2, 3});
}

TEST_CASE("A random walk keeps to what pages and slots may do") {
    constexpr std::uint32_t pages = 40, slot_count = 9;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        Table t(pages, slot_count, 3);
        Random random(seed);
        struct Model {
            std::uint32_t slot = PageSlots::none;
            std::vector<std::uint32_t> loads{};  ///< frames
        };
        std::vector<Model> model(pages);
        std::vector<std::uint32_t> running(3);                                      // frames
        std::vector<std::vector<std::pair<std::uint32_t, std::uint32_t>>> seen(3);  // pages and slots that they found
        std::uint64_t evicted = 0, loaded = 0;
        for (int step = 0; step < 3000; ++step) {
            const std::size_t user = random.below(3);
            const std::uint64_t what = random.below(10);
            if (running[user] == 0) {
                running[user] = t.slots.begin(*t.users[user]);
            } else if (what == 0) {
                PageSlots::end(*t.users[user]);
                running[user] = 0;
                seen[user].clear();
            } else if (what < 6) {
                const auto page = std::uint32_t(random.below(pages));
                const std::uint32_t slot = t.slots.find(page, *t.users[user], float(random.below(16)));
                REQUIRE(slot == model[page].slot);
                if (slot != PageSlots::none) seen[user].emplace_back(page, slot);
            } else {
                const auto page = std::uint32_t(random.below(pages));
                if (t.slots.is_resident(page)) continue;
                const bool waits = what == 9;
                const auto weight = float(random.below(64)) / 2;
                const std::uint32_t slot = t.slots.take(weight, t.all, waits ? t.users[user].get() : nullptr);
                std::uint32_t gone = 0;
                for (std::uint32_t p = 0; p < pages; ++p) {
                    if (model[p].slot == PageSlots::none || t.slots.is_resident(p)) continue;
                    model[p].slot = PageSlots::none;
                    ++gone;
                }
                REQUIRE(gone <= 1);
                evicted += gone;
                if (slot == PageSlots::none) continue;
                for (const Model& m : model) REQUIRE(m.slot != slot);
                for (const auto& of_user : seen) {
                    for (const auto& [p, s] : of_user) REQUIRE(s != slot);
                }
                if (random.below(8) == 0) {  // it could not be read
                    t.slots.give_back(slot);
                    continue;
                }
                t.slots.publish(page, slot, weight, false);
                model[page].slot = slot;
                auto& loads = model[page].loads;
                loads.push_back(t.slots.frames());
                // Again within sixty frames, but once.
                if (loads.size() >= 3) REQUIRE(loads.back() - loads[loads.size() - 3] >= 60);
                ++loaded;
            }
            const auto resident = std::size_t(
                std::count_if(model.begin(), model.end(), [](const Model& m) { return m.slot != PageSlots::none; }));
            REQUIRE(t.slots.resident() == resident);
            REQUIRE(t.slots.evictions() == evicted);
        }
        CHECK(loaded > 20);
        CHECK(evicted > 10);
    }
}

TEST_CASE("Whatever threads do, a frame finds in a slot the page that it looked up") {
    constexpr std::uint32_t pages = 64, slot_count = 12;
    constexpr std::size_t readers = 3, numbers = 16;
    Table t(pages, slot_count, readers);
    std::vector<std::array<std::uint32_t, numbers>> memory(slot_count);  // no atomics: ThreadSanitizer looks too
    std::mutex one_at_a_time;
    std::atomic<int> wrong{0};
    std::atomic<std::uint64_t> found{0};
    const auto load = [&](std::uint32_t page, float weight, const PageVisits* own) {
        std::uint32_t slot = PageSlots::none;
        {
            const std::lock_guard lock(one_at_a_time);
            if (t.slots.is_resident(page)) return;
            slot = t.slots.take(weight, t.all, own);
        }
        if (slot == PageSlots::none) return;
        memory[slot].fill(page);
        const std::lock_guard lock(one_at_a_time);
        if (t.slots.is_resident(page)) {
            t.slots.give_back(slot);
        } else {
            t.slots.publish(page, slot, weight, false);
        }
    };
    std::vector<std::thread> threads;
    std::atomic<std::size_t> left{readers};
    for (std::size_t r = 0; r < readers; ++r) {
        threads.emplace_back([&, r] {
            Random random(r + 1);
            PageVisits& own = *t.users[r];
            for (int i = 0; i < 400; ++i) {
                t.slots.begin(own);
                std::array<std::pair<std::uint32_t, std::uint32_t>, 24> seen;
                std::size_t count = 0;
                for (int look = 0; look < 24; ++look) {
                    const auto page = std::uint32_t(random.below(pages));
                    const auto weight = float(1 + random.below(100));
                    // One of them waits for pages.
                    if (r == 0 && look % 4 == 0) load(page, weight, &own);
                    const std::uint32_t slot = t.slots.find(page, own, weight);
                    if (slot != PageSlots::none) seen[count++] = {page, slot};
                    for (std::size_t s = 0; s < count; ++s) {
                        for (const std::uint32_t n : memory[seen[s].second]) wrong += n != seen[s].first;
                    }
                }
                found += count;
                PageSlots::end(own);
                if (i % 16 == 0) std::this_thread::yield();
            }
            --left;
        });
    }
    threads.emplace_back([&] {
        Random random(99);
        while (left != 0) load(std::uint32_t(random.below(pages)), float(1 + random.below(400)), nullptr);
    });
    for (std::thread& thread : threads) thread.join();
    CHECK(wrong == 0);
    CHECK(found > 100);
    CHECK(t.slots.evictions() > 0);
}
