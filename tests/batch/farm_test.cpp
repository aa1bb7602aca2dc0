#include "batch/farm.h"

#include <gtest/gtest.h>

#include <numeric>

namespace sightline {
namespace {

double sum_of(const std::vector<double>& seconds, const TaskRange& group) {
    const auto begin = seconds.begin() + static_cast<std::ptrdiff_t>(group.first);
    return std::accumulate(begin, begin + static_cast<std::ptrdiff_t>(group.count), 0.0);
}

TEST(FarmGroups, ContainEveryTaskOnceInOrder) {
    const std::vector<double> seconds = {5, 1, 0, 200, 3, 3, 3, 0.5, 90, 2};
    for (const double target : {0.1, 1.0, 10.0, 1000.0})
        for (const size_t max_groups : {size_t{1}, size_t{3}, size_t{100}}) {
            size_t next = 0;
            const auto groups = make_groups(seconds, target, max_groups);
            EXPECT_LE(groups.size(), max_groups);
            for (const TaskRange& group : groups) {
                EXPECT_EQ(group.first, next);
                EXPECT_GT(group.count, 0u);
                next += group.count;
            }
            EXPECT_EQ(next, seconds.size());
        }
}

TEST(FarmGroups, AreEqualForEqualTasks) {
    const auto groups = make_groups(std::vector<double>(60, 2.0), 10, 1000);
    ASSERT_EQ(groups.size(), 12u);
    for (const TaskRange& group : groups) EXPECT_EQ(group.count, 5u);
}

TEST(FarmGroups, ExceedTheirShareByAtMostOneTask) {
    std::vector<double> seconds;
    for (int i = 0; i < 5000; ++i) seconds.push_back(1 + i * 7919 % 40);
    const double total = std::accumulate(seconds.begin(), seconds.end(), 0.0);
    for (const size_t max_groups : {size_t{10}, size_t{300}, size_t{100'000}}) {
        const auto groups = make_groups(seconds, 100, max_groups);
        const double share = std::max(100.0, total / static_cast<double>(max_groups));
        for (const TaskRange& group : groups) EXPECT_LE(sum_of(seconds, group), share + 40);
    }
}

TEST(FarmGroups, DoNotExistWithoutTasks) {
    EXPECT_TRUE(make_groups({}, 100, 10).empty());
    EXPECT_EQ(make_groups({0, 0}, 100, 10).size(), 1u);
}

}  // namespace
}  // namespace sightline
