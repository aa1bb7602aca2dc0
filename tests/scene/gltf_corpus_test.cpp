// Every file of the corpus: valid ones load, broken ones load or fail with one line.
#include "core/error.h"
#include "scene/gltf/load.h"

#include <gtest/gtest.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace sightline {
namespace {

namespace fs = std::filesystem;

const fs::path corpus = fs::path(SIGHTLINE_SOURCE_DIR) / ".." / "shared" / "corpus";

struct Entry {
    std::string file, features;
};

// The lines of INDEX.tsv whose file is in `folder`.
std::vector<Entry> entries(const std::string& folder) {
    std::vector<Entry> list;
    std::ifstream index(corpus / "INDEX.tsv");
    for (std::string line; std::getline(index, line);) {
        std::vector<std::string> columns;
        std::istringstream cells(line);
        for (std::string cell; std::getline(cells, cell, '\t');) columns.push_back(cell);
        const std::string ending = fs::path(columns[0]).extension();
        if (!columns[0].starts_with(folder) || (ending != ".gltf" && ending != ".glb")) continue;
        list.push_back({columns[0], columns.size() > 5 ? columns[5] : ""});
    }
    return list;
}

TEST(GltfCorpus, EveryValidAssetLoads) {
    const auto list = entries("valid/");
    if (list.empty()) GTEST_SKIP() << "no corpus beside the checkout";
    for (const Entry& entry : list) {
        SCOPED_TRACE(entry.file);
        try {
            const Scene scene = load_gltf(corpus / entry.file);
            EXPECT_FALSE(scene.instances.empty());
            EXPECT_FALSE(scene.bounds.isEmpty());
            for (const std::string& warning : scene.warnings) {
                EXPECT_EQ(warning.find('\n'), std::string::npos);
                if (std::getenv("SIGHTLINE_SHOW")) std::printf("%s\n", warning.c_str());
            }
        } catch (const Error& error) {
            ADD_FAILURE() << error.what();
        }
    }
}

TEST(GltfCorpus, EveryBrokenAssetLoadsOrFailsWithOneLineWithin5Seconds) {
    const auto list = entries("invalid/");
    if (list.empty()) GTEST_SKIP() << "no corpus beside the checkout";
    for (const Entry& entry : list) {
        SCOPED_TRACE(entry.file);
        const std::clock_t start = std::clock();  // of the processor: the machine may be busy
        try {
            const Scene scene = load_gltf(corpus / entry.file);
            if (std::getenv("SIGHTLINE_SHOW")) std::printf("loads: %s\n", entry.file.c_str());
        } catch (const Error& error) {
            const std::string line = error.what();
            EXPECT_EQ(line.find('\n'), std::string::npos) << line;
            EXPECT_NE(line.find(fs::path(entry.file).filename()), std::string::npos) << line;
            if (std::getenv("SIGHTLINE_SHOW")) std::printf("%s\n", line.c_str());
        }
        EXPECT_LT(std::clock() - start, 5 * CLOCKS_PER_SEC);
    }
}

}  // namespace
}  // namespace sightline
