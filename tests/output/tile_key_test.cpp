#include "output/tile_key.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

RenderCommand command_with_values() {
    RenderCommand command;
    command.load.time = 1.0f;
    command.light.background = Background::environment;
    command.settings.aovs = {"depth"};
    return command;
}

void change(bool& value) { value = !value; }
void change(std::string& value) { value += "x"; }
void change(Vec3& value) { value.z += 1; }
void change(Mat4& value) { value[3][2] += 1; }
void change(std::set<std::string>& values) { values.insert("normal"); }
template <class T>
void change(std::optional<T>& value) {
    value.reset();
}
template <class T>
requires std::is_enum_v<T>
void change(T& value) { value = static_cast<T>(1 - static_cast<int>(value)); }
template <class T>
requires std::is_arithmetic_v<T>
void change(T& value) { value = value > 1 ? T{0} : static_cast<T>(value + 1); }

/// Calls `visit` with every field of `value` that has no fields itself.
template <class T, class Visit>
void for_each_leaf(T& value, const Visit& visit) {
    if constexpr (requires { fields_of(value); }) {
        std::apply([&](auto&... fields) { (for_each_leaf(fields, visit), ...); }, fields_of(value));
    } else {
        visit(value);
    }
}

/// How many fields of `part`, which belongs to `command`, do not change the key.
template <class T>
int count_ignored(const RenderCommand& command, T& part, int& fields) {
    const uint64_t before = tile_key(command, {}, "engine");
    int ignored = 0;
    for_each_leaf(part, [&](auto& field) {
        const auto original = field;
        change(field);
        ignored += tile_key(command, {}, "engine") == before;
        field = original;
        ++fields;
    });
    EXPECT_EQ(tile_key(command, {}, "engine"), before);
    return ignored;
}

TEST(TileKey, EveryFieldOfTheSettingsChangesIt) {
    RenderCommand command = command_with_values();
    int fields = 0;
    EXPECT_EQ(count_ignored(command, command.settings, fields), 0);
    EXPECT_EQ(fields, 36);
}

TEST(TileKey, EveryFieldOfTheLoadLightAndEngineOptionsChangesIt) {
    RenderCommand command = command_with_values();
    int fields = 0;
    EXPECT_EQ(count_ignored(command, command.load, fields), 0);
    EXPECT_EQ(count_ignored(command, command.light, fields), 0);
    EXPECT_EQ(count_ignored(command, command.engine, fields), 0);
    EXPECT_EQ(fields, 23);
}

TEST(TileKey, AnOptionalValueDiffersFromAnAbsentOneAndFromAnother) {
    RenderCommand command = command_with_values();
    const uint64_t one = tile_key(command, {}, "");
    command.load.time = 2.0f;
    EXPECT_NE(tile_key(command, {}, ""), one);
    command.load.time = 0.0f;
    const uint64_t zero = tile_key(command, {}, "");
    command.load.time.reset();
    EXPECT_NE(tile_key(command, {}, ""), zero);
}

TEST(TileKey, TheContentsOfTheInputsAndTheEngineChangeItButTheirPathsDoNot) {
    const RenderCommand command = command_with_values();
    const uint64_t key = tile_key(command, {{"a.gltf", 1}}, "engine");
    EXPECT_NE(tile_key(command, {{"a.gltf", 2}}, "engine"), key);
    EXPECT_NE(tile_key(command, {{"a.gltf", 1}}, "other"), key);
    EXPECT_EQ(tile_key(command, {{"b.gltf", 1}}, "engine"), key);
}

TEST(TileKey, WhatIsWrittenAndHowTheProgramRunsDoNotChangeIt) {
    RenderCommand command = command_with_values();
    const uint64_t key = tile_key(command, {}, "engine");
    command.output.tone_map = ToneMap::aces;
    command.output.pictures = {"b.exr"};
    command.run.threads = 3;
    EXPECT_EQ(tile_key(command, {}, "engine"), key);
}

TEST(TileKey, WordsThatRunTogetherAreKeptApart) {
    RenderCommand a = command_with_values(), b = a;
    a.load.scene = "one\n", a.load.variant = "two";
    b.load.scene = "one", b.load.variant = "\ntwo";
    EXPECT_NE(tile_key(a, {}, ""), tile_key(b, {}, ""));
}

}  // namespace
}  // namespace sightline
