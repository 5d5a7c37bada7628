// What all users of a cache want, and which of it is read next.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "farfield/paging/page_slots.hpp"
#include "farfield/paging/wanted_pages.hpp"

namespace farfield::detail {

/// What a cache knows of one that looks at pages.
struct KnownUser {
    explicit KnownUser(std::uint32_t slot_count) : visits(slot_count) {}
    PageVisits visits;
    std::vector<WantedPage> wanted{};  ///< by its last frame, most wanted first
    std::size_t next = 0;              ///< before it all are there
};

/// Called by one thread at a time. Users are borrowed.
class PageDemand {
  public:
    void add(KnownUser& user) {
        users_.push_back(&user);
        visits_.push_back(&user.visits);
    }
    void remove(KnownUser& user) {
        std::erase(users_, &user);
        std::erase(visits_, &user.visits);
    }
    /// Of all users.
    const std::vector<PageVisits*>& visits() const { return visits_; }
    std::size_t count() const {
        std::size_t count = 0;
        for (const KnownUser* u : users_) count += u->wanted.size();
        return count;
    }
    template <class Condition>
    bool any(Condition&& is_true) const {
        return std::any_of(users_.begin(), users_.end(), [&](const KnownUser* u) {
            return std::any_of(u->wanted.begin(), u->wanted.end(),
                               [&](const WantedPage& w) { return is_true(w.page); });
        });
    }

    bool has(const PageVisits* visits) const {
        return std::find(visits_.begin(), visits_.end(), visits) != visits_.end();
    }

    /// Who wants most what may be loaded: that is now its next one. Null if there is nothing.
    template <class IsThere, class MayLoad>
    KnownUser* next(IsThere&& is_there, MayLoad&& may_load) {
        KnownUser* most = nullptr;
        for (KnownUser* u : users_) {
            std::size_t at = u->next;
            while (at < u->wanted.size() && is_there(u->wanted[at].page)) ++at;
            u->next = at;
            while (at < u->wanted.size() && !may_load(u->wanted[at].page)) ++at;
            if (at == u->wanted.size()) continue;
            std::swap(u->wanted[u->next], u->wanted[at]);
            if (most == nullptr || u->wanted[u->next].weight > most->wanted[most->next].weight) most = u;
        }
        return most;
    }

  private:
    std::vector<KnownUser*> users_{};
    std::vector<PageVisits*> visits_{};
};

}  // namespace farfield::detail
