// A glTF 2.0 file (Khronos, "glTF 2.0 Specification", 2021; sections are of it) as JSON and typed arrays. Nothing is
// trusted: whatever is looked at is checked first, and what nobody looks at may be as it likes. All throw
// std::runtime_error that names the thing and its index.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace farfield::scenes::detail {

using Json = nlohmann::json;

/// A thing of one of the file's lists, and its name in messages: "mesh 3".
struct GltfItem {
    const Json& json;
    std::size_t index;
    std::string name;
};

/// Null unless `parent` is an object with that member.
const Json* member(const Json& parent, const char* name);
/// The member as an array; empty if there is none.
const Json& list(const Json& parent, const char* name, const std::string& where);
/// The member of `parent`'s extension of that name.
const Json* extension(const Json& parent, const char* name);
/// The member as a whole number that is not negative.
std::uint64_t whole(const Json& parent, const char* name, std::uint64_t otherwise, const std::string& where);
double real(const Json& parent, const char* name, double otherwise, const std::string& where);

template <std::size_t n>
std::array<double, n> reals(const Json& parent, const char* name, const std::array<double, n>& otherwise,
                            const std::string& where);

/// Elements of one type, each of one to sixteen numbers (section 3.6.2). Valid as long as its file. Takes no memory, so
/// that any number of them may lie over one buffer.
class GltfAccessor {
  public:
    std::uint64_t count() const { return count_; }
    std::size_t components() const { return components_; }
    /// As indices are: whole numbers without a sign.
    bool is_index() const {
        return components_ == 1 && !normalized_ &&
               (component_type_ == 5121 || component_type_ == 5123 || component_type_ == 5125);
    }
    /// Normalized integers in [0, 1] or [-1, 1]; element < count.
    double number(std::uint64_t element, std::size_t component) const;
    /// Of one that is_index.
    std::uint32_t index(std::uint64_t element) const;

  private:
    friend class GltfFile;

    /// Which element the i-th of the sparse values stands for; they rise (section 3.6.2.3).
    std::uint64_t sparse_index(std::uint64_t i) const;
    const unsigned char* bytes_of(std::uint64_t element) const;
    double at(const unsigned char* bytes) const;

    std::uint64_t count_ = 0, stride_ = 0, sparse_count_ = 0;
    std::size_t components_ = 1, component_bytes_ = 4;
    unsigned component_type_ = 5126, sparse_index_type_ = 5125;
    bool normalized_ = false;
    /// Null: all zeros.
    const unsigned char *bytes_ = nullptr, *sparse_indices_ = nullptr, *sparse_values_ = nullptr;
};

/// Reads .gltf and .glb; buffers and images when they are asked for, which may lie in files beside it.
class GltfFile {
  public:
    GltfFile(const std::string& bytes, std::filesystem::path folder);

    const Json& json() const { return json_; }
    std::size_t count(const char* things) const;
    /// The thing that `parent`'s member names in the list `things`; none if there is no such member.
    std::optional<GltfItem> item(const Json& parent, const char* name, const char* things,
                                 const std::string& where) const;
    GltfItem item(const Json& index, const char* things, const std::string& where) const;

    /// The accessor that `parent`'s member names; none if there is no such member.
    std::optional<GltfAccessor> accessor(const Json& parent, const char* name, const std::string& where);
    /// The bytes of a PNG or JPEG file.
    std::string_view image(const GltfItem& image);

  private:
    const GltfAccessor& accessor(const GltfItem& accessor);
    std::string_view view(const GltfItem& view);
    const std::string& buffer(const GltfItem& buffer);
    std::string at_uri(const std::string& uri, const std::string& where);
    void open(const std::string& bytes);

    std::filesystem::path folder_;
    Json json_;
    std::optional<std::string> binary_;  ///< the second chunk of a .glb
    std::map<std::size_t, std::string> buffers_, images_;
    std::map<std::size_t, GltfAccessor> accessors_;
    std::uint64_t bytes_read_ = 0;
};

}  // namespace farfield::scenes::detail
