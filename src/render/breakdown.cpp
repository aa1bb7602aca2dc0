#include "render/breakdown.h"

#include <limits>
#include <nlohmann/json.hpp>

namespace sightline {

extern const char* const breakdown_json;  // src/render/breakdown.json as a string

namespace {

constexpr double largest_step = 100;

using nlohmann::json;

/// The family's entry; empty where there is none, or none for the method.
const json& entry(const std::string& family, const std::string& method) {
    static const json families = json::parse(breakdown_json).at("families");
    static const json nothing = json::object();
    const auto found = families.find(family);
    return found != families.end() && found->at("breakdown").contains(method) ? *found : nothing;
}

}  // namespace

double right_up_to(const std::string& family, const std::string& method) {
    const json& measured = entry(family, method);
    if (measured.empty()) return 0;
    const json& breakdown = measured["breakdown"][method];
    return breakdown.is_null() ? measured["largest"].get<double>()
                               : breakdown.get<double>() / largest_step;
}

double wrong_from(const std::string& family, const std::string& method) {
    const json& measured = entry(family, method);
    if (measured.empty()) return 0;
    const json& breakdown = measured["breakdown"][method];
    return breakdown.is_null() ? std::numeric_limits<double>::infinity() : breakdown.get<double>();
}

}  // namespace sightline
