// Who runs the independent steps of a build: one thread or many. The only header that starts any.
#pragma once

#include "farfield/settings.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <functional>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

#include "farfield/fail.hpp"

namespace farfield {

/// Runs f(0) ... f(count - 1) one after the other.
struct SerialExecutor {
    template <class F>
    void operator()(std::size_t count, F&& f) const {
        for (std::size_t i = 0; i < count; ++i) f(i);
    }
};

/// Any executor: it is called with a count and a function, and returns when the function has been called with each
/// number below the count, at once and in any order. An empty one is a SerialExecutor.
using AnyExecutor = std::function<void(std::size_t, const std::function<void(std::size_t)>&)>;

/// Runs f(0) ... f(count - 1) on threads that live as long as the call; the caller's is one of them. Results are those
/// of SerialExecutor as long as calls of f do not depend on each other.
class ThreadExecutor {
  public:
    /// 0: as many as the machine runs at once.
    explicit ThreadExecutor(unsigned threads = 0)
        : threads_(threads != 0 ? threads : std::max(1u, std::thread::hardware_concurrency())) {}

    unsigned threads() const { return threads_; }

    /// If calls of f throw, rethrows what the one of the smallest index threw, after all threads have ended; later
    /// indices may then have been left out. Threads that the system refuses are done without.
    template <class F>
    void operator()(std::size_t count, F&& f) const {
        if (threads_ == 1 || count < 2) {
            for (std::size_t i = 0; i < count; ++i) f(i);
            return;
        }
        // Several chunks a thread even out calls that differ in length; few enough to keep the counter quiet.
        const std::size_t chunk = std::max<std::size_t>(1, count / (std::size_t(threads_) * 16));
        std::atomic<std::size_t> next{0}, end{count};
        std::mutex mutex;
        std::exception_ptr error;
        const auto work = [&] {
            while (true) {
                const std::size_t first = next.fetch_add(chunk, std::memory_order_relaxed);
                // What lies below `end` is never left out, so the smallest index that throws is always found.
                for (std::size_t i = first; i < first + chunk; ++i) {
                    if (i >= end.load(std::memory_order_relaxed)) return;
                    detail::guarded([&] { f(i); },
                                    [&] {
                                        const std::lock_guard lock(mutex);
                                        if (i >= end.load(std::memory_order_relaxed)) return;
                                        end.store(i, std::memory_order_relaxed);
                                        error = std::current_exception();
                                    });
                }
            }
        };
        {
            Joined helpers;
            const std::size_t wanted = std::min<std::size_t>(threads_, (count + chunk - 1) / chunk);
            helpers.threads.reserve(wanted);
            detail::guarded<std::system_error>(
                [&] {
                    while (helpers.threads.size() + 1 < wanted) helpers.threads.emplace_back(work);
                },
                [] {});
            work();
        }
        if (error) std::rethrow_exception(error);
    }

  private:
    struct Joined {
        std::vector<std::thread> threads;
        Joined() = default;
        Joined(const Joined&) = delete;
        Joined& operator=(const Joined&) = delete;
        ~Joined() {
            for (std::thread& t : threads) t.join();
        }
    };

    unsigned threads_;
};

}  // namespace farfield
