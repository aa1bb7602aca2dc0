#include "lab/instructions.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

uint64_t instructions_of(int turns) {
    const auto before = thread_instructions();
    for (volatile int i = 0; i < turns;) i = i + 1;
    return *thread_instructions() - *before;
}

TEST(Instructions, GrowWithTheWork) {
    if (!thread_instructions()) GTEST_SKIP() << "the machine does not count instructions";
    const auto once = static_cast<double>(instructions_of(100000));
    EXPECT_GT(once, 100000);
    EXPECT_NEAR(static_cast<double>(instructions_of(200000)) / once, 2, 0.1);
}

}  // namespace
}  // namespace sightline
