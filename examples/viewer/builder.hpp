// Opens scenes and builds hierarchies on a thread of its own, one at a time, and says how far it is.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>

#include "stage.hpp"

namespace viewer {

struct Opened {
    std::shared_ptr<const Stage> stage;
};
struct Built {
    std::shared_ptr<const Stage> stage;
    std::size_t variant = 0;
    BuiltPtr built;
};
/// What could not be done, in one line.
struct Failed {
    std::string message;
    std::optional<std::size_t> variant{};
};
using BuilderNews = std::variant<Opened, Built, Failed>;

class Builder {
  public:
    /// `wake` is called on that thread whenever there is news.
    explicit Builder(std::function<void()> wake);
    /// Ends a build as soon as it asks whether to go on. To open a file is not ended.
    ~Builder();
    Builder(const Builder&) = delete;
    Builder& operator=(const Builder&) = delete;

    /// Ends what is being built. Whatever was asked for and has not begun is forgotten.
    void open(std::string where, std::size_t cache_mib);
    void build(std::shared_ptr<const Stage> stage, std::size_t variant);

    std::optional<BuilderNews> news();

    bool is_busy() const;
    std::string task() const;                     ///< empty where it is not busy
    double part() const { return part_.load(); }  ///< of the task that is done; below 0: nobody knows

  private:
    struct Task {
        std::string name;
        std::function<BuilderNews()> run;
        std::optional<std::size_t> variant{};
    };
    void begin(Task task);
    void work();

    std::function<void()> wake_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::optional<Task> next_;
    std::string task_;
    std::optional<BuilderNews> news_;
    std::atomic<bool> is_canceled_{false}, ends_{false};
    std::atomic<double> part_{-1};
    std::thread thread_;
};

}  // namespace viewer
