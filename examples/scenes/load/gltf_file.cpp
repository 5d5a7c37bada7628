#include "scenes/load/gltf_file.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "scenes/load/load_detail.hpp"

namespace farfield::scenes::detail {
namespace {

[[noreturn]] void fail(const std::string& where, const std::string& reason) {
    throw std::runtime_error(where + ": " + reason);
}

Json parsed(std::string_view text) {
    try {
        return Json::parse(text.begin(), text.end());
    } catch (const Json::parse_error& error) {
        throw std::runtime_error("JSON byte " + std::to_string(error.byte - std::min<std::size_t>(error.byte, 1)) +
                                 ": ends too early or is no JSON");
    } catch (const Json::exception&) {
        throw std::runtime_error("the JSON has a number that is too large");
    }
}

template <class T>
T little_endian(const void* bytes) {
    const auto* const b = static_cast<const unsigned char*>(bytes);
    std::make_unsigned_t<T> value = 0;
    for (std::size_t i = sizeof(T); i-- > 0;) {
        value = static_cast<std::make_unsigned_t<T>>((std::uint64_t{value} << 8) | b[i]);
    }
    return static_cast<T>(value);
}

float little_endian_float(const void* bytes) {
    const auto bits = little_endian<std::uint32_t>(bytes);
    float value = 0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
}

/// %20 and the like (RFC 3986, section 2.1).
std::string unescaped(std::string_view uri) {
    std::string result;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        unsigned code = 0;
        if (uri[i] == '%' && i + 2 < uri.size() &&
            std::from_chars(uri.data() + i + 1, uri.data() + i + 3, code, 16).ptr == uri.data() + i + 3) {
            result.push_back(static_cast<char>(code));
            i += 2;
        } else {
            result.push_back(uri[i]);
        }
    }
    return result;
}

/// RFC 4648, section 4; with or without padding.
std::string from_base64(std::string_view text, const std::string& where) {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<std::uint8_t, 256> value;
    value.fill(64);
    for (std::size_t i = 0; i < digits.size(); ++i) {
        value[static_cast<unsigned char>(digits[i])] = static_cast<std::uint8_t>(i);
    }
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    std::string result;
    result.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        const std::uint8_t digit = value[static_cast<unsigned char>(c)];
        if (digit == 64) fail(where, "a data URI with " + in_quotes({&c, 1}) + " in its base64");
        bits = (bits << 6 | digit) & 0xffffff;
        count += 6;
        if (count >= 8) {
            count -= 8;
            result.push_back(static_cast<char>(bits >> count & 0xff));
        }
    }
    return result;
}

/// RFC 2397: "data:image/png;base64,...".
std::string from_data_uri(std::string_view uri, const std::string& where) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos) fail(where, "a data URI without data");
    const std::string_view head = uri.substr(0, comma), data = uri.substr(comma + 1);
    if (head.size() < 7 || head.substr(head.size() - 7) != ";base64") return unescaped(data);
    return data.find('%') == std::string_view::npos ? from_base64(data, where) : from_base64(unescaped(data), where);
}

struct ComponentType {
    unsigned code;
    std::size_t bytes;
};
constexpr std::array<ComponentType, 6> component_types{
    {{5120, 1}, {5121, 1}, {5122, 2}, {5123, 2}, {5125, 4}, {5126, 4}}};

std::size_t bytes_of_component(std::uint64_t code, const std::string& where) {
    for (const ComponentType& type : component_types) {
        if (type.code == code) return type.bytes;
    }
    fail(where, "component type " + std::to_string(code) + " is not one of 5120 to 5123, 5125 and 5126");
}

std::size_t components_of(const Json& accessor, const std::string& where) {
    struct Type {
        std::string_view name;
        std::size_t components;
    };
    // Nothing here needs matrices of small integers, whose columns are padded (section 3.6.2.4).
    constexpr std::array<Type, 5> types{{{"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT4", 16}}};
    const Json* type = member(accessor, "type");
    if (!type || !type->is_string()) fail(where, "has no type");
    for (const Type& known : types) {
        if (known.name == type->get_ref<const std::string&>()) return known.components;
    }
    fail(where, "type " + in_quotes(type->get_ref<const std::string&>()) + " is not one that is needed here");
}

/// Where `count` elements begin that are `stride` bytes apart.
const unsigned char* elements(std::string_view view, std::uint64_t offset, std::uint64_t count, std::uint64_t size,
                              std::uint64_t stride, const std::string& where) {
    const std::uint64_t room = offset <= view.size() ? view.size() - offset : 0;
    if (count > 0 && (size > room || count - 1 > (room - size) / stride)) {
        throw std::runtime_error(where + " claims " + std::to_string(count) +
                                 " elements, more than its buffer view has");
    }
    return reinterpret_cast<const unsigned char*>(view.data()) + (count > 0 ? offset : 0);
}

std::string singular(std::string_view things) {
    if (things == "meshes") return "mesh";
    return std::string(things.substr(0, things.size() - 1));
}

}  // namespace

// ---------------------------------------------------------------- JSON

const Json* member(const Json& parent, const char* name) {
    if (!parent.is_object()) return nullptr;
    const auto found = parent.find(name);
    return found == parent.end() ? nullptr : &*found;
}

const Json& list(const Json& parent, const char* name, const std::string& where) {
    static const Json none = Json::array();
    const Json* found = member(parent, name);
    if (!found) return none;
    if (!found->is_array()) fail(where, std::string(name) + " is not a list");
    return *found;
}

const Json* extension(const Json& parent, const char* name) {
    const Json* extensions = member(parent, "extensions");
    return extensions ? member(*extensions, name) : nullptr;
}

double real(const Json& parent, const char* name, double otherwise, const std::string& where) {
    const Json* found = member(parent, name);
    if (!found) return otherwise;
    if (!found->is_number()) fail(where, std::string(name) + " is not a number");
    return found->get<double>();
}

std::uint64_t whole(const Json& parent, const char* name, std::uint64_t otherwise, const std::string& where) {
    const Json* found = member(parent, name);
    if (!found) return otherwise;
    const double n = found->is_number() ? found->get<double>() : -1.0;
    if (!(n >= 0) || n > 9e15 || n != std::floor(n)) fail(where, std::string(name) + " is not a count");
    return static_cast<std::uint64_t>(n);
}

template <std::size_t n>
std::array<double, n> reals(const Json& parent, const char* name, const std::array<double, n>& otherwise,
                            const std::string& where) {
    const Json& numbers = list(parent, name, where);
    if (numbers.empty()) return otherwise;
    std::array<double, n> result{};
    if (numbers.size() != n) fail(where, std::string(name) + " has not " + std::to_string(n) + " numbers");
    for (std::size_t i = 0; i < n; ++i) {
        if (!numbers[i].is_number()) fail(where, std::string(name) + " has something that is not a number");
        result[i] = numbers[i].get<double>();
    }
    return result;
}
template std::array<double, 2> reals(const Json&, const char*, const std::array<double, 2>&, const std::string&);
template std::array<double, 3> reals(const Json&, const char*, const std::array<double, 3>&, const std::string&);
template std::array<double, 4> reals(const Json&, const char*, const std::array<double, 4>&, const std::string&);
template std::array<double, 16> reals(const Json&, const char*, const std::array<double, 16>&, const std::string&);

// ---------------------------------------------------------------- accessors

std::uint64_t GltfAccessor::sparse_index(std::uint64_t i) const {
    switch (sparse_index_type_) {
        case 5121:
            return sparse_indices_[i];
        case 5123:
            return little_endian<std::uint16_t>(sparse_indices_ + 2 * i);
        default:
            return little_endian<std::uint32_t>(sparse_indices_ + 4 * i);
    }
}

const unsigned char* GltfAccessor::bytes_of(std::uint64_t element) const {
    std::uint64_t low = 0, high = sparse_count_;
    while (low < high) {
        const std::uint64_t middle = low + (high - low) / 2;
        const std::uint64_t index = sparse_index(middle);
        if (index == element) return sparse_values_ + middle * components_ * component_bytes_;
        if (index < element) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    return bytes_ ? bytes_ + element * stride_ : nullptr;
}

double GltfAccessor::at(const unsigned char* bytes) const {
    // Section 3.6.2.2: the least signed integer, too, is -1.
    const auto scaled = [&](double value, double largest) {
        return normalized_ ? std::max(value / largest, -1.0) : value;
    };
    switch (component_type_) {
        case 5120:
            return scaled(little_endian<std::int8_t>(bytes), 127.0);
        case 5121:
            return scaled(*bytes, 255.0);
        case 5122:
            return scaled(little_endian<std::int16_t>(bytes), 32767.0);
        case 5123:
            return scaled(little_endian<std::uint16_t>(bytes), 65535.0);
        case 5125:
            return scaled(little_endian<std::uint32_t>(bytes), 4294967295.0);
        default:
            return static_cast<double>(little_endian_float(bytes));
    }
}

double GltfAccessor::number(std::uint64_t element, std::size_t component) const {
    const unsigned char* bytes = bytes_of(element);
    return bytes ? at(bytes + component * component_bytes_) : 0.0;
}

std::uint32_t GltfAccessor::index(std::uint64_t element) const {
    return static_cast<std::uint32_t>(number(element, 0));
}

// ---------------------------------------------------------------- the file

GltfFile::GltfFile(const std::string& bytes, std::filesystem::path folder) : folder_(std::move(folder)) {
    open(bytes);
    const Json* asset = member(json_, "asset");
    const Json* version = asset ? member(*asset, "version") : nullptr;
    if (!version || !version->is_string()) throw std::runtime_error("is not glTF: no asset version");
    const auto& text = version->get_ref<const std::string&>();
    if (text.substr(0, 2) != "2.") throw std::runtime_error("is glTF " + in_quotes(text) + "; version 2 is read");
}

/// Section 4.4 has the container of .glb.
void GltfFile::open(const std::string& bytes) {
    bytes_read_ = bytes.size();
    if (bytes.compare(0, 4, "glTF") != 0) {
        if (trimmed(bytes).empty()) throw std::runtime_error("is empty");
        json_ = parsed(bytes);
        return;
    }
    if (bytes.size() < 20) throw std::runtime_error("ends within its header");
    const std::uint32_t version = little_endian<std::uint32_t>(bytes.data() + 4);
    if (version != 2) throw std::runtime_error("is glTF version " + std::to_string(version) + "; version 2 is read");
    const std::uint64_t length = little_endian<std::uint32_t>(bytes.data() + 8);
    if (length > bytes.size()) {
        throw std::runtime_error("claims " + std::to_string(length) + " bytes, but has " +
                                 std::to_string(bytes.size()));
    }
    bool first = true;
    for (std::uint64_t at = 12; at + 8 <= length;) {
        const std::uint64_t size = little_endian<std::uint32_t>(bytes.data() + at);
        const std::string_view kind = std::string_view(bytes).substr(at + 4, 4);
        if (size > length - at - 8) {
            throw std::runtime_error("byte " + std::to_string(at) + ": a chunk longer than the file");
        }
        const std::string_view content = std::string_view(bytes).substr(at + 8, size);
        if (first) {
            if (kind != "JSON") throw std::runtime_error("byte 12: the first chunk is not JSON");
            // Some writers pad with zeros where blanks are asked for.
            json_ = parsed(content.substr(0, content.find_last_not_of('\0') + 1));
        } else if (kind == std::string_view("BIN\0", 4) && !binary_) {
            binary_ = std::string(content);
        }
        first = false;
        at += 8 + size;
    }
    if (first) throw std::runtime_error("byte 12: no JSON chunk");
}

std::size_t GltfFile::count(const char* things) const {
    return list(json_, things, "the file").size();
}

GltfItem GltfFile::item(const Json& index, const char* things, const std::string& where) const {
    const Json& all = list(json_, things, "the file");
    const double n = index.is_number() ? index.get<double>() : -1.0;
    if (!(n >= 0) || n >= static_cast<double>(all.size()) || n != std::floor(n)) {
        throw std::runtime_error(where + " names a " + singular(things) + " that does not exist");
    }
    const std::size_t i = static_cast<std::size_t>(n);
    return {all[i], i, singular(things) + ' ' + std::to_string(i)};
}

std::optional<GltfItem> GltfFile::item(const Json& parent, const char* name, const char* things,
                                       const std::string& where) const {
    const Json* index = member(parent, name);
    if (!index) return std::nullopt;
    return item(*index, things, where);
}

std::string GltfFile::at_uri(const std::string& uri, const std::string& where) {
    if (uri.substr(0, 5) == "data:") return from_data_uri(uri, where);
    const std::size_t scheme = uri.find("://");
    if (scheme != std::string::npos) fail(where, in_quotes(uri) + " is not a file beside this one");
    std::string name = unescaped(uri);
    std::error_code ignored;
    // Not every writer escapes: the name as it stands, then.
    if (!std::filesystem::exists(folder_ / name, ignored) && std::filesystem::exists(folder_ / uri, ignored))
        name = uri;
    // A backslash is a separator only where the file was written.
    if (!std::filesystem::exists(folder_ / name, ignored)) std::replace(name.begin(), name.end(), '\\', '/');
    try {
        return read_file(folder_ / name);
    } catch (const std::runtime_error& error) {
        fail(where, in_quotes(name) + ": " + error.what());
    }
}

const std::string& GltfFile::buffer(const GltfItem& buffer) {
    const std::uint64_t claimed = whole(buffer.json, "byteLength", 0, buffer.name);
    const auto checked = [&](const std::string& bytes) -> const std::string& {
        if (claimed > bytes.size()) {
            throw std::runtime_error(buffer.name + " claims " + std::to_string(claimed) + " bytes, but has " +
                                     std::to_string(bytes.size()));
        }
        return bytes;
    };
    const auto [entry, is_new] = buffers_.try_emplace(buffer.index);
    if (!is_new) return checked(entry->second);
    const Json* uri = member(buffer.json, "uri");
    if (!uri && buffer.index == 0 && binary_) {
        entry->second = std::move(*binary_);
    } else if (!uri) {
        fail(buffer.name, extension(buffer.json, "EXT_meshopt_compression")
                              ? "is compressed (EXT_meshopt_compression), which is not supported"
                              : "has no data");
    } else {
        if (!uri->is_string()) fail(buffer.name, "uri is not a string");
        entry->second = at_uri(uri->get_ref<const std::string&>(), buffer.name);
        bytes_read_ += entry->second.size();
    }
    return checked(entry->second);
}

std::string_view GltfFile::view(const GltfItem& view) {
    const auto source = item(view.json, "buffer", "buffers", view.name);
    if (!source) fail(view.name, "has no buffer");
    // What the buffer's file has beyond its length is not the buffer's.
    const std::string_view bytes =
        std::string_view(buffer(*source)).substr(0, whole(source->json, "byteLength", 0, source->name));
    const std::uint64_t offset = whole(view.json, "byteOffset", 0, view.name);
    const std::uint64_t length = whole(view.json, "byteLength", 0, view.name);
    if (offset > bytes.size() || length > bytes.size() - offset) {
        throw std::runtime_error(view.name + " reaches beyond its buffer");
    }
    return bytes.substr(offset, length);
}

std::optional<GltfAccessor> GltfFile::accessor(const Json& parent, const char* name, const std::string& where) {
    const auto found = item(parent, name, "accessors", where);
    if (!found) return std::nullopt;
    return accessor(*found);
}

const GltfAccessor& GltfFile::accessor(const GltfItem& accessor) {
    const auto& [json, number, where] = accessor;
    const auto [entry, is_new] = accessors_.try_emplace(number);
    GltfAccessor& result = entry->second;
    if (!is_new) return result;
    const std::uint64_t type = whole(json, "componentType", 0, where);
    result.component_bytes_ = bytes_of_component(type, where);
    result.component_type_ = static_cast<unsigned>(type);
    result.components_ = components_of(json, where);
    result.count_ = whole(json, "count", 0, where);
    const Json* normalized = member(json, "normalized");
    result.normalized_ = normalized && normalized->is_boolean() && normalized->get<bool>();
    const std::uint64_t size = result.components_ * result.component_bytes_;
    if (const auto source = item(json, "bufferView", "bufferViews", where)) {
        result.stride_ = whole(source->json, "byteStride", size, source->name);
        if (result.stride_ < size) fail(where, "elements overlap: byteStride of its buffer view is below their size");
        result.bytes_ =
            elements(view(*source), whole(json, "byteOffset", 0, where), result.count_, size, result.stride_, where);
    }
    if (const Json* sparse = member(json, "sparse")) {
        const Json *indices = member(*sparse, "indices"), *values = member(*sparse, "values");
        result.sparse_count_ = whole(*sparse, "count", 0, where);
        const auto index_view = indices ? item(*indices, "bufferView", "bufferViews", where) : std::nullopt;
        const auto value_view = values ? item(*values, "bufferView", "bufferViews", where) : std::nullopt;
        if (!index_view || !value_view || result.sparse_count_ > result.count_) fail(where, "broken sparse data");
        const std::uint64_t index_type = whole(*indices, "componentType", 0, where);
        const std::size_t index_bytes = bytes_of_component(index_type, where);
        if (index_type != 5121 && index_type != 5123 && index_type != 5125) fail(where, "broken sparse data");
        result.sparse_index_type_ = static_cast<unsigned>(index_type);
        result.sparse_indices_ = elements(view(*index_view), whole(*indices, "byteOffset", 0, where),
                                          result.sparse_count_, index_bytes, index_bytes, where);
        result.sparse_values_ = elements(view(*value_view), whole(*values, "byteOffset", 0, where),
                                         result.sparse_count_, size, size, where);
        for (std::uint64_t i = 0; i < result.sparse_count_; ++i) {
            const std::uint64_t index = result.sparse_index(i);
            if (index >= result.count_ || (i > 0 && index <= result.sparse_index(i - 1))) {
                fail(where, "its sparse indices do not rise, or are out of range");
            }
        }
    }
    // All zeros are legal; but not more elements than all that was read has bytes.
    if (!result.bytes_ && result.count_ > bytes_read_) {
        throw std::runtime_error(where + " claims " + std::to_string(result.count_) + " elements without data");
    }
    return result;
}

std::string_view GltfFile::image(const GltfItem& image) {
    if (const auto source = item(image.json, "bufferView", "bufferViews", image.name)) return view(*source);
    const Json* uri = member(image.json, "uri");
    if (!uri || !uri->is_string()) fail(image.name, "has no data");
    const auto [entry, is_new] = images_.try_emplace(image.index);
    if (is_new) entry->second = at_uri(uri->get_ref<const std::string&>(), image.name);
    return entry->second;
}

}  // namespace farfield::scenes::detail
