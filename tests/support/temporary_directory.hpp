// A directory of a test's own.
#pragma once

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <system_error>

namespace farfield::test {

/// Removed with all that is in it.
class TemporaryDirectory {
  public:
    TemporaryDirectory() {
        std::random_device random;  // of a name only
        do {
            path_ = std::filesystem::temp_directory_path() / ("farfield-" + std::to_string(random()));
        } while (!std::filesystem::create_directory(path_));
    }
    ~TemporaryDirectory() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TemporaryDirectory(const TemporaryDirectory&) = delete;
    TemporaryDirectory& operator=(const TemporaryDirectory&) = delete;

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const char* name) const { return path_ / name; }
    std::ptrdiff_t files() const { return std::distance(std::filesystem::directory_iterator(path_), {}); }

    std::filesystem::path write(const std::string& name, std::string_view content) const {
        std::ofstream(path_ / name, std::ios::binary).write(content.data(), std::streamsize(content.size()));
        return path_ / name;
    }

  private:
    std::filesystem::path path_;
};

}  // namespace farfield::test
