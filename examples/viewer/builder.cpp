#include "builder.hpp"

#include <exception>
#include <new>
#include <utility>

#include "farfield/build/build_progress.hpp"

namespace viewer {

Builder::Builder(std::function<void()> wake) : wake_(std::move(wake)), thread_([this] { work(); }) {}

Builder::~Builder() {
    {
        const std::lock_guard lock(mutex_);
        ends_ = true;
        is_canceled_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void Builder::begin(Task task) {
    {
        const std::lock_guard lock(mutex_);
        next_ = std::move(task);
        is_canceled_ = true;
    }
    changed_.notify_all();
}

void Builder::open(std::string where, std::size_t cache_mib) {
    begin({"opening " + where, [where, cache_mib]() -> BuilderNews { return Opened{open_stage(where, cache_mib)}; }});
}

void Builder::build(std::shared_ptr<const Stage> stage, std::size_t variant) {
    const std::string name = "building " + stage->variants[variant].name;
    begin({name,
           [this, stage = std::move(stage), variant]() -> BuilderNews {
               const auto progress = [this](double part) {
                   part_ = part;
                   wake_();
                   return !is_canceled_;
               };
               return Built{stage, variant, stage->variants[variant].build(progress)};
           },
           variant});
}

std::optional<BuilderNews> Builder::news() {
    const std::lock_guard lock(mutex_);
    return std::exchange(news_, std::nullopt);
}

bool Builder::is_busy() const {
    const std::lock_guard lock(mutex_);
    return next_ || !task_.empty() || news_;
}

std::string Builder::task() const {
    const std::lock_guard lock(mutex_);
    return next_ ? next_->name : task_;
}

void Builder::work() {
    for (;;) {
        Task task;
        {
            std::unique_lock lock(mutex_);
            // News are not overwritten: each is the answer to a question.
            changed_.wait(lock, [this] { return ends_ || next_; });
            if (ends_) return;
            task = *std::exchange(next_, std::nullopt);
            task_ = task.name;
            part_ = -1;
            is_canceled_ = false;
        }
        std::optional<BuilderNews> news;
        try {
            news = task.run();
        } catch (const farfield::BuildCanceled&) {
        } catch (const std::bad_alloc&) {
            news = Failed{task.name + ": there is not enough memory", task.variant};
        } catch (const std::exception& error) {
            news = Failed{error.what(), task.variant};
        }
        {
            const std::lock_guard lock(mutex_);
            task_.clear();
            // What nobody waits for any more is no news.
            if (news && !next_) news_ = std::move(news);
        }
        wake_();
    }
}

}  // namespace viewer
