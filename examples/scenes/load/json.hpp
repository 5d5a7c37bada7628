// Just enough of JSON (RFC 8259) to check a glTF file before it is trusted to an importer.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace farfield::scenes::detail {

struct Json {
    using Array = std::vector<Json>;
    using Object = std::map<std::string, Json, std::less<>>;
    std::variant<std::nullptr_t, bool, double, std::string, Array, Object> value{nullptr};

    const Array* array() const { return std::get_if<Array>(&value); }
    const Object* object() const { return std::get_if<Object>(&value); }
    const std::string* string() const { return std::get_if<std::string>(&value); }
    const double* number() const { return std::get_if<double>(&value); }

    /// Null unless this is an object with that member.
    const Json* find(std::string_view name) const {
        const Object* members = object();
        if (!members) return nullptr;
        const auto found = members->find(name);
        return found == members->end() ? nullptr : &found->second;
    }
    /// The array of that name; empty if there is none.
    const Array& list(std::string_view name) const {
        static const Array none;
        const Json* member = find(name);
        return member && member->array() ? *member->array() : none;
    }
};

/// Throws std::runtime_error naming the byte. More than 64 levels of nesting are refused. Of \u escapes only
/// those below 128 are kept; others become '?', for no name that is looked at has any.
Json parse_json(std::string_view text);

}  // namespace farfield::scenes::detail
