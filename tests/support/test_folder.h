#pragma once
#include <gtest/gtest.h>

#include <filesystem>

namespace sightline {

/// The running test's own folder, since tests run in parallel. Its first call creates it empty.
inline std::filesystem::path test_folder() {
    static std::filesystem::path last;
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    auto folder =
        std::filesystem::path(testing::TempDir()) / test->test_suite_name() / test->name();
    if (folder != last) {
        std::filesystem::remove_all(folder);
        std::filesystem::create_directories(folder);
        last = folder;
    }
    return folder;
}

}  // namespace sightline
