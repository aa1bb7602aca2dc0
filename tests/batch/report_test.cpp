#include "batch/report.h"

#include <gtest/gtest.h>

#include <vector>

namespace sightline {
namespace {

Outcome outcome(TaskVerdict verdict, const std::vector<std::string>& kinds) {
    Outcome result;
    result.verdict = verdict;
    for (const std::string& kind : kinds) result.faults.push_back({kind, "images[0]", "is gone"});
    result.fault_count = kinds.size();
    return result;
}

TEST(BatchReport, SaysNothingOfPicturesWithoutFaults) {
    EXPECT_EQ(describe_warnings({}), "");
    EXPECT_EQ(describe_warnings(std::vector{outcome(TaskVerdict::ok, {})}), "");
}

TEST(BatchReport, NamesTheThreeKindsOfFaultThatMostPicturesHave) {
    const auto faulty = TaskVerdict::drawn_with_faults;
    const std::vector<Outcome> outcomes = {outcome(faulty, {"skin", "skin", "skin", "camera"}),
                                           outcome(faulty, {"channel", "light"}),
                                           outcome(faulty, {"channel", "light"}),
                                           outcome(faulty, {"channel"}),
                                           outcome(TaskVerdict::empty, {"skin"}),
                                           outcome(TaskVerdict::ok, {})};
    EXPECT_EQ(describe_warnings(outcomes),
              "5 drawn with faults: channel in 3, light in 2, skin in 2 and 1 more kind\n");
}

TEST(BatchReport, CountsNoPictureThatWasNotDrawn) {
    EXPECT_EQ(describe_warnings(std::vector{outcome(TaskVerdict::failed, {"skin"})}), "");
}

TEST(BatchReport, NamesOtherWarningsByWhatTheySayOfAnyFile) {
    Outcome first = outcome(TaskVerdict::ok, {}), second = first,
            third = outcome(TaskVerdict::drawn_with_faults, {"skin"});
    first.warnings = {"nodes[3]: has a singular matrix: not drawn", "12 pixels are not finite"};
    second.warnings = {"nodes[14]: has a singular matrix: not drawn"};
    third.warnings = {"images[0]: is gone"};  // the fault
    EXPECT_EQ(describe_warnings(std::vector{first, second}),
              "2 with warnings: \"has a singular matrix: not drawn\" in 2, \"N pixels are not "
              "finite\" in 1\n");
    EXPECT_EQ(describe_warnings(std::vector{first, second, third}),
              "3 with warnings, 1 of them drawn with faults: \"has a singular matrix: not drawn\" "
              "in 2, \"N pixels are not finite\" in 1, skin in 1\n");
}

TEST(BatchReport, CountsABlankPictureOnlyForOtherWarningsThanItsReason) {
    Outcome blank = outcome(TaskVerdict::empty, {});
    blank.warnings = {"nothing is seen"};
    EXPECT_EQ(describe_warnings(std::vector{blank}), "");
    blank.warnings = {"nodes[1]: is empty: drawn once", "nothing is seen"};
    EXPECT_EQ(describe_warnings(std::vector{blank}),
              "1 with warnings: \"is empty: drawn once\" in 1\n");
}

TEST(BatchReport, SumsTheStagesOfWhatWasRendered) {
    Outcome one, two, skipped;
    one.stages = {{"decode", 1.0}, {"trace", 2.0}, {"open", 0.0}};
    two.stages = {{"decode", 4.0}, {"trace", 1.0}};
    skipped.stages = {{"trace", 100.0}};
    skipped.skipped = true;
    EXPECT_EQ(describe_stages(std::vector{one, two, skipped}),
              "8.0 s of work: decode 62 %, trace 38 %, open 0 %\n");
    EXPECT_EQ(describe_stages(std::vector{skipped}), "");
}

}  // namespace
}  // namespace sightline
