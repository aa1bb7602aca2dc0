#include "scene/gltf/schema.h"

#include "scene/gltf/rules.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <unordered_map>
#include <unordered_set>

namespace sightline {
namespace {

using nlohmann::json;

// A JSON path, formatted only for an error.
struct JsonPath {
    const JsonPath* parent = nullptr;
    std::string_view name = {};  // empty: an array's item
    size_t index = 0;

    std::string text() const {
        if (!parent) return "";
        std::string before = parent->text();
        if (name.empty()) return fmt::format("{}[{}]", before, index);
        return before.empty() ? std::string(name) : fmt::format("{}.{}", before, name);
    }
};

// A value that breaks a rule; caught where leaving something out restores order.
struct BadValue {
    std::string place, reason;
};

// What takes the place of an item that is left out, so that the indices of the others stay: it
// obeys the rules and shows nothing.
json placeholder(std::string_view kind) {
    static const std::unordered_map<std::string_view, const char*> texts = {
        {"bufferView", R"({"buffer": -1, "byteLength": 0})"},
        {"accessor", R"({"componentType": 5121, "count": 0, "type": "SCALAR"})"},
        {"light", R"({"type": "point"})"},
        {"shape", R"({"type": "sphere"})"},
        {"variant", R"({"name": ""})"},
        {"mesh", R"({"primitives": []})"},
        {"primitive", R"({"attributes": {}})"},
        {"mapping", R"({"material": 0, "variants": []})"},
        {"skin", R"({"joints": []})"},
        {"camera", R"({"type": "perspective"})"},
        {"animation", R"({"channels": [], "samplers": []})"},
        {"animation.sampler", R"({"input": -1, "output": -1})"},
        {"channel", R"({"sampler": 0, "target": {"path": ""}})"},
    };
    const auto found = texts.find(kind);
    return found == texts.end() ? json::object() : json::parse(found->second);
}

class StructureCheck {
  public:
    explicit StructureCheck(Document& document) : document_(document) {
        for (const GltfRule& rule : gltf_rules()) {
            std::span<const GltfRule>& rows = rules_of_[rule.owner];
            rows = {rows.empty() ? &rule : rows.data(), rows.size() + 1};
        }
    }

    // Throws BadValue if the object as a whole cannot be used; reports what can be left out.
    void check(json& object, std::string_view owner, const JsonPath& place) {
        require(object.is_object(), place, "is not an object");
        for (const GltfRule& rule : rules_of_[owner]) {
            const auto property = object.find(rule.name);
            const JsonPath at{&place, rule.name};
            if (property == object.end())
                require(rule.need != Need::required, at, "is missing");
            else if (rule.need != Need::optional)
                check_value(*property, rule, at);
            else if (!is_usable(rule.kind == ValueKind::objects ? Fault::property : rule.fault,
                                [&] { check_value(*property, rule, at); }))
                object.erase(property);
        }
    }

    // Whether an integer was written as 3.0.
    bool has_replaced() const { return has_replaced_; }

  private:
    [[noreturn]] void fail(const JsonPath& at, const std::string& reason) {
        const std::string text = at.text();
        throw BadValue{text.empty() ? "JSON" : text, reason};
    }

    void require(bool condition, const JsonPath& at, const char* reason) {
        if (!condition) fail(at, reason);
    }

    // Whether `check` finds nothing; otherwise its finding is reported.
    bool is_usable(Fault fault, const auto& check) {
        try {
            check();
            return true;
        } catch (const BadValue& bad) {
            document_.report(fault, bad.place, bad.reason);
            return false;
        }
    }

    void check_value(json& value, const GltfRule& rule, const JsonPath& at) {
        switch (rule.kind) {
            case ValueKind::boolean:
                return require(value.is_boolean(), at, "is not true or false");
            case ValueKind::number:
                return check_number(value, at);
            case ValueKind::string:
                return require(value.is_string(), at, "is not a string");
            case ValueKind::natural:
                return check_natural(value, uint64_t{1} << 53, at);
            case ValueKind::small:
                return check_natural(value, (uint64_t{1} << 31) - 1, at);
            case ValueKind::stride:
                return check_stride(value, at);
            case ValueKind::choice:
                return check_choice(value, rule.of, at);
            case ValueKind::index:
                return check_index(value, rule.of, at);
            case ValueKind::object:
                return check(value, rule.of, at);
            case ValueKind::dictionary:
                return check_dictionary(value, rule, at);
            default:
                require(value.is_array(), at, "is not an array");
                return check_array(value, rule, at);
        }
    }

    void check_array(json& value, const GltfRule& rule, const JsonPath& at) {
        switch (rule.kind) {
            case ValueKind::objects:
                return check_objects(value, rule, at);
            case ValueKind::color:
                fit_color(value, rule.size, at);
                [[fallthrough]];
            case ValueKind::numbers:
                if (rule.size != 0 && value.size() != rule.size)
                    fail(at, fmt::format("has {} numbers, not {}", value.size(), rule.size));
                for (size_t i = 0; i < value.size(); ++i)
                    check_number(value[i], JsonPath{&at, {}, i});
                return;
            case ValueKind::dictionaries:
                for (size_t i = 0; i < value.size(); ++i)
                    check_dictionary(value[i], rule, JsonPath{&at, {}, i});
                return;
            default:
                return check_list(value, rule, at);
        }
    }

    // Strings or indices. An optional list does without its wrong entries.
    void check_list(json& value, const GltfRule& rule, const JsonPath& at) {
        const auto check_entry = [&](size_t i) {
            const JsonPath entry{&at, {}, i};
            if (rule.kind == ValueKind::strings)
                require(value[i].is_string(), entry, "is not a string");
            else
                check_index(value[i], rule.of, entry);
        };
        json usable = json::array();
        for (size_t i = 0; i < value.size(); ++i) {
            if (rule.need != Need::optional)
                check_entry(i);
            else if (is_usable(Fault::list_entry, [&] { check_entry(i); }))
                usable.push_back(value[i]);
        }
        if (rule.need == Need::optional) value = std::move(usable);
    }

    void check_objects(json& value, const GltfRule& rule, const JsonPath& at) {
        for (size_t i = 0; i < value.size(); ++i) {
            const JsonPath item{&at, {}, i};
            if (is_usable(rule.fault, [&] { check(value[i], rule.of, item); })) continue;
            value[i] = placeholder(rule.of);
            if (rule.of == "camera") continue;  // it keeps its number, for --camera
            std::string pointer = fmt::format("/{}", at.text());
            std::ranges::replace(pointer, '.', '/');
            dropped_[pointer].insert(i);
        }
    }

    // Exporters confuse RGB and RGBA.
    void fit_color(json& value, size_t size, const JsonPath& at) {
        if (size == 4 && value.size() == 3)
            value.push_back(1);
        else if (size == 3 && value.size() == 4)
            value.erase(3);
        else
            return;
        document_.report(Fault::color_length, at.text());
    }

    void check_dictionary(json& value, const GltfRule& rule, const JsonPath& at) {
        require(value.is_object(), at, "is not an object");
        require(value.size() >= rule.size, at, "is empty");
        for (auto& [key, item] : value.items()) check_index(item, rule.of, JsonPath{&at, key});
    }

    // Numbers become floats, so they must not overflow one.
    void check_number(const json& value, const JsonPath& at) {
        require(value.is_number(), at, "is not a number");
        require(std::abs(value.get<double>()) <= double(std::numeric_limits<float>::max()), at,
                "is too large for a float");
    }

    void check_natural(json& value, uint64_t limit, const JsonPath& at) {
        if (value.is_number_float()) {
            const double real = value.get<double>();
            if (real >= 0 && real <= 0x1p53 && real == std::floor(real)) {
                value = static_cast<uint64_t>(real);
                has_replaced_ = true;
            }
        }
        require(value.is_number_unsigned(), at, "is not a non-negative integer");
        if (const auto number = value.get<uint64_t>(); number > limit)
            fail(at, fmt::format("{} is above {}", number, limit));
    }

    void check_stride(json& value, const JsonPath& at) {
        check_natural(value, 252, at);
        require(value.get<uint64_t>() % 4 == 0, at, "is not a multiple of 4");
    }

    void check_choice(json& value, std::string_view words, const JsonPath& at) {
        const bool numeric = words[0] >= '0' && words[0] <= '9';
        if (numeric)
            check_natural(value, (uint64_t{1} << 31) - 1, at);
        else
            require(value.is_string(), at, "is not a string");
        const std::string text = numeric ? value.dump() : value.get<std::string>();
        for (size_t begin = 0; begin < words.size();) {
            const size_t end = std::min(words.find(' ', begin), words.size());
            if (words.substr(begin, end - begin) == text) return;
            begin = end + 1;
        }
        fail(at, fmt::format("{} is not one of: {}", value.dump(), words));
    }

    void check_index(json& value, std::string_view array, const JsonPath& at) {
        check_natural(value, uint64_t{1} << 53, at);
        const size_t size = array_size(array);
        if (const auto number = value.get<uint64_t>(); number >= size) {
            fail(at, fmt::format("{} is out of range: there are {} {}", number, size,
                                 array.substr(array.rfind('/') + 1)));
        }
        if (dropped_.empty()) return;
        const auto dropped = dropped_.find(std::string(array));
        if (dropped != dropped_.end() && dropped->second.contains(value.get<uint64_t>()))
            fail(at, fmt::format("{}[{}] is left out", array.substr(array.rfind('/') + 1),
                                 value.get<uint64_t>()));
    }

    size_t array_size(std::string_view pointer) {
        const auto [found, is_new] = sizes_.try_emplace(pointer, 0);
        if (is_new) {
            const json::json_pointer at{std::string(pointer)};
            if (document_.json.contains(at) && document_.json[at].is_array())
                found->second = document_.json[at].size();
        }
        return found->second;
    }

    Document& document_;
    bool has_replaced_ = false;
    std::unordered_map<std::string_view, std::span<const GltfRule>> rules_of_;
    std::unordered_map<std::string_view, size_t> sizes_;
    std::unordered_map<std::string, std::unordered_set<uint64_t>> dropped_;  // by JSON pointer
};

}  // namespace

bool check_structure(Document& document) try {
    const uint64_t reports = document.reports;
    StructureCheck check(document);
    check.check(document.json, "", {});
    return document.reports == reports && !check.has_replaced();
} catch (const BadValue& bad) {
    document.fail(bad.place, bad.reason);
}

}  // namespace sightline
