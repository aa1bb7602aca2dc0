#include "output/tile_key.h"

#include "core/hash.h"
#include "core/version.h"

#include <fmt/format.h>

namespace sightline {
namespace {

/// Values one after the other as text, such that different values give different texts.
struct KeyText {
    std::string text;

    template <class T>
    void add(const T& value) {
        if constexpr (requires { fields_of(value); }) {
            std::apply([&](const auto&... fields) { (add(fields), ...); }, fields_of(value));
        } else if constexpr (std::is_enum_v<T>) {
            add(static_cast<int>(value));
        } else {
            text += fmt::format("{}\n", value);
        }
    }
    void add(const std::string& value) { text += fmt::format("{}:{}\n", value.size(), value); }
    void add(const Vec3& v) { add(v.x), add(v.y), add(v.z); }
    void add(const Mat4& m) {
        for (const auto& row : m.x)
            for (const float value : row) add(value);
    }
    template <class T>
    void add(const std::optional<T>& value) {
        add(value.has_value());
        if (value) add(*value);
    }
    void add(const std::set<std::string>& values) {
        add(values.size());
        for (const std::string& value : values) add(value);
    }
};

}  // namespace

uint64_t load_options_key(const LoadOptions& options) {
    KeyText key;
    key.add(options);
    return hash_text(key.text);
}

uint64_t tile_key(const RenderCommand& command, const std::vector<SourceFile>& inputs,
                  const std::string& engine) {
    KeyText key;
    key.add(std::string(program_version));
    key.add(engine);
    for (const SourceFile& input : inputs) key.add(input.hash);
    key.add(command.load);
    key.add(command.light);
    key.add(command.engine);
    key.add(command.settings);
    return hash_text(key.text);
}

}  // namespace sightline
