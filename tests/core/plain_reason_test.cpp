#include "core/plain_reason.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <stdexcept>

namespace sightline {
namespace {

std::string reason_of(const auto& action) {
    try {
        action();
    } catch (const std::exception& e) {
        return plain_reason(e);
    }
    return "";
}

TEST(PlainReason, OfAFaultOfTheSystemIsThePathAndTheReason) {
    EXPECT_EQ(reason_of([] { std::filesystem::create_directory("/nowhere/x"); }),
              "/nowhere/x: No such file or directory");
    EXPECT_EQ(reason_of([] { throw std::system_error(std::make_error_code(std::errc::io_error)); }),
              "Input/output error");
}

TEST(PlainReason, HasNoMarkOfTheJsonLibrary) {
    const std::string reason = reason_of([] { nlohmann::json(3).at("x"); });
    EXPECT_EQ(reason.find("json"), std::string::npos) << reason;
    EXPECT_NE(reason.find("number"), std::string::npos) << reason;
}

TEST(PlainReason, IsOtherwiseTheText) {
    EXPECT_EQ(reason_of([] { throw std::runtime_error("[1] is odd"); }), "[1] is odd");
}

}  // namespace
}  // namespace sightline
