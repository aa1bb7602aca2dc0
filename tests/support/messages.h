#pragma once
#include "core/error.h"

#include <string>

namespace sightline {

/// The message of the Error that `action` throws; "" if it throws none.
std::string message_of(const auto& action) {
    try {
        action();
    } catch (const Error& e) {
        return e.what();
    }
    return "";
}

}  // namespace sightline
