// Shared by the loaders; not for users. The readers here throw std::runtime_error without the file's name,
// which `load` puts before it.
#pragma once

#include <charconv>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/load/load.hpp"
#include "scenes/load/mesh.hpp"

namespace farfield::scenes::detail {

inline constexpr Rgba8 uncolored{204, 204, 204, 255};

/// Unpacked, if it is packed by gzip.
std::string read_file(const std::filesystem::path& file);

/// Vertices are checked to be finite by the readers themselves, who know their index. Those that take a folder open
/// files that lie in it.
Loaded read_off(std::string_view bytes, const std::filesystem::path& folder);
Loaded read_ply(std::string_view bytes, const LoadOptions& options = {});
Loaded read_obj(std::string_view text, const std::filesystem::path& folder);
Loaded read_height_field(std::string_view text);
/// More than one number between separators, as the lines of a height field are.
bool is_row_of_numbers(std::string_view line);
/// Buffers and images may lie in files in `folder`.
Loaded read_gltf(const std::string& bytes, const std::filesystem::path& folder, const LoadOptions& options);
Loaded read_pdb(std::string_view text, const LoadOptions& options);
Loaded read_mmcif(std::string_view text, const LoadOptions& options);
Loaded read_xyz(std::string_view text, const LoadOptions& options);
Loaded read_lammps_dump(std::string_view text, const LoadOptions& options);
Loaded read_lammps_data(std::string_view text, const LoadOptions& options);

/// Multiplies the colors by the light that falls on the triangle; keeps alpha.
void bake_light(VertexColoredTriangle& triangle, glm::vec3 up = {0, 1, 0});

/// One of many well-separated colors for a number that stands for a kind.
Rgba8 color_of_kind(std::int64_t kind);

inline std::string in_quotes(std::string_view text) {
    std::string result = "'";
    result.append(text.substr(0, 40));
    return result.append(text.size() > 40 ? "...'" : "'");
}

/// Of a decimal number too large or too small for its type, which of the two.
bool is_below_one(std::string_view decimal);

/// The whole of `text` as a number, "inf" and "nan" too; independent of the locale.
template <class T>
std::optional<T> number(std::string_view text) {
    if (!text.empty() && text.front() == '+') text.remove_prefix(1);
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    // Too large or too small for T: as good as infinite, and zero has lost nothing that matters.
    if constexpr (std::is_floating_point_v<T>) {
        if (error == std::errc::result_out_of_range && end == text.data() + text.size()) {
            return is_below_one(text) ? T(0) : std::numeric_limits<T>::infinity() * (text.front() == '-' ? -1 : 1);
        }
    }
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

constexpr bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == '\f' || c == '\v';
}

inline std::string_view trimmed(std::string_view text) {
    while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
    while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
    return text;
}

/// The words of one line, after what `result` has already.
inline void split(std::string_view line, std::vector<std::string_view>& result) {
    std::size_t i = 0;
    while (i < line.size()) {
        while (i < line.size() && is_space(line[i])) ++i;
        const std::size_t begin = i;
        while (i < line.size() && !is_space(line[i])) ++i;
        if (i > begin) result.push_back(line.substr(begin, i - begin));
    }
}

inline std::vector<std::string_view> words(std::string_view line) {
    std::vector<std::string_view> result;
    split(line, result);
    return result;
}

/// The values of one line, after what `result` has already: between semicolons, commas, or tabs and spaces, the first
/// of these that it has. With a separator that is no space two in a row have nothing between them.
void split_values(std::string_view line, std::vector<std::string_view>& result);

/// Lines one after the other, without their ends; any of LF, CR LF, CR.
class Lines {
  public:
    explicit Lines(std::string_view text) : rest_(text) {}

    bool next(std::string_view& line) {
        if (rest_.empty()) return false;
        const std::size_t end = rest_.find_first_of("\r\n");
        line = rest_.substr(0, end);
        if (end == std::string_view::npos) {
            rest_ = {};
        } else {
            rest_.remove_prefix(rest_.substr(end, 2) == "\r\n" ? end + 2 : end + 1);
        }
        ++number_;
        return true;
    }

    std::string_view rest() const { return rest_; }
    /// Of the line last given, from 1.
    std::size_t number() const { return number_; }
    [[noreturn]] void fail(const std::string& reason) const {
        throw std::runtime_error("line " + std::to_string(number_) + ": " + reason);
    }

  private:
    std::string_view rest_;
    std::size_t number_ = 0;
};

/// As it is; throws "vertex 7 is not finite".
inline const glm::dvec3& finite(const glm::dvec3& point, std::string_view kind, std::size_t index) {
    if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) {
        throw std::runtime_error(std::string(kind) + ' ' + std::to_string(index) + " is not finite");
    }
    return point;
}

/// Throws if a file of `bytes` cannot hold `count` things of at least `least_bytes` each.
inline void check_room(std::uint64_t count, std::uint64_t least_bytes, std::uint64_t bytes, std::string_view things) {
    if (least_bytes > 0 && count > bytes / least_bytes) {
        throw std::runtime_error("claims " + std::to_string(count) + ' ' + std::string(things) + ", but only " +
                                 std::to_string(bytes) + " bytes are left for them");
    }
}

}  // namespace farfield::scenes::detail
