// Each row of the table of faults, in both modes.
#include "output/render_asset.h"
#include "support/faulty_files.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sightline {
namespace {

// What only `info` looks at, and what depends on the options of a picture.
bool is_of_info(const FaultEntry& entry) { return entry.fault == Fault::unneeded_buffer; }
bool is_of_options(const FaultEntry& entry) { return entry.fault == Fault::first_animation; }

void expect_noted(const std::string& path, const FaultEntry& entry) {
    for (const bool strict : {false, true}) {
        const Scene scene = load_gltf(path, is_of_info(entry) ? all_faults(strict) : posed(strict));
        ASSERT_EQ(scene.warnings.size(), 1u);
        EXPECT_TRUE(scene.warnings[0].ends_with(entry.done)) << scene.warnings[0];
        EXPECT_TRUE(scene.faults.empty());
        EXPECT_EQ(scene.fault_count, 0u);
    }
}

void expect_drawn_with_fault(const std::string& path, const FaultEntry& entry) {
    const Scene scene = load_gltf(path, posed(false));
    ASSERT_FALSE(scene.faults.empty());
    EXPECT_EQ(scene.fault_count, scene.faults.size());
    const FoundFault& fault = scene.faults[0];
    EXPECT_EQ(fault.key, entry.key);
    EXPECT_TRUE(fault.text.ends_with(entry.done)) << fault.text;
    const std::string line = fault.place + ": " + fault.text;
    EXPECT_EQ(std::ranges::count(scene.warnings, line), 1) << line;
    EXPECT_FALSE(scene.instances.empty());
    EXPECT_TRUE(fails(path, path + ": " + fault.place, posed(true)));
}

// Gives a file the name of its fault, so that tools/fault_survey can ask other programs about it.
std::string renamed(const std::filesystem::path& path, const FaultEntry& entry) {
    const auto name = path.parent_path() / (std::string(entry.key) + path.extension().string());
    std::filesystem::rename(path, name);
    return name.string();
}

TEST(Faults, EachRowIsNotedMendedDroppedOrRefusedAsTheTableSays) {
    const auto inputs = all_inputs();
    for (const FaultEntry& entry : fault_table()) {
        SCOPED_TRACE(entry.key);
        if (entry.fault == Fault::nothing_to_draw) continue;
        const auto input = inputs.find(entry.fault);
        ASSERT_NE(input, inputs.end()) << "no input";
        const std::string path = renamed(input->second(), entry);
        if (entry.severity == Severity::noted) {
            expect_noted(path, entry);
        } else if (entry.severity == Severity::refused) {
            EXPECT_THROW(load_gltf(path, posed(false)), Error);
            EXPECT_TRUE(fails(path, ": ", posed(true)));
        } else {
            expect_drawn_with_fault(path, entry);
        }
    }
}

TEST(Faults, InfoFindsEachFaultWithoutOptionsAndRefusesItIfStrict) {
    const auto inputs = all_inputs();
    for (const auto& [fault, input] : inputs) {
        const FaultEntry& entry = entry_of(fault);
        SCOPED_TRACE(entry.key);
        if (entry.severity == Severity::refused || is_of_options(entry)) continue;
        const std::string path = input();
        const Scene scene = load_gltf(path, all_faults());
        EXPECT_TRUE(std::ranges::any_of(
            scene.warnings, [&](const std::string& line) { return line.ends_with(entry.done); }));
        if (entry.severity == Severity::noted) continue;
        ASSERT_FALSE(scene.faults.empty());
        EXPECT_EQ(scene.faults[0].key, entry.key);
        EXPECT_TRUE(fails(path, path + ": " + scene.faults[0].place, all_faults(true)));
    }
}

TEST(Faults, AFileOfWhichNothingIsLeftIsRefusedWithItsFirstFault) {
    GltfBuilder file;
    file.mesh_node(primitive_with(file, {{"indices", file.indices({0, 1, 9})}}));
    RenderCommand command;
    command.asset = file.save();
    EXPECT_EQ(load_gltf(command.asset).fault_count, 1u);
    try {
        render_asset(command);
        FAIL() << "it renders";
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()),
                  command.asset +
                      ": because of its faults, nothing is left to draw; the first of 1: "
                      "meshes[0].primitives[0].indices: index 9 at 2 is out of range: there are 3 "
                      "vertices: not drawn");
    }
}

TEST(Faults, AHostileFileIsRefusedOnceItHasTooManyFaults) {
    const Scene scene = load_gltf(triangle_and(
        [](GltfBuilder& file) { file.json["materials"] = std::vector<int>(65536, 0); }));
    EXPECT_EQ(scene.fault_count, 65536u);
    EXPECT_EQ(scene.faults.size(), 200u);
    EXPECT_EQ(scene.warnings.size(), 201u);
}

}  // namespace
}  // namespace sightline
