#include "scene/gltf/document.h"

#include "core/error.h"
#include "core/hash.h"
#include "core/text.h"

#include <fmt/format.h>

#include <utility>

namespace sightline {
namespace {

constexpr uint64_t max_faults = 65536;

}  // namespace

bool Warnings::add(const std::string& line) {
    if (!hashes_.insert(hash_text(line)).second) return false;
    if (lines_.size() < max_lines) lines_.push_back(printable(line));
    return true;
}

std::vector<std::string> Warnings::lines() const {
    std::vector<std::string> all = lines_;
    if (hashes_.size() > max_lines)
        all.push_back(fmt::format("… and {} more", hashes_.size() - max_lines));
    return all;
}

void Document::fail(const std::string& place, const std::string& reason) const {
    throw Error(path + ": " + place + ": " + reason);
}

void Document::fail_part(Fault fault, const std::string& place, const std::string& detail) const {
    throw FaultyPart(path, fault, place, detail);
}

void Document::require_usable(uint32_t accessor, Fault fault, const std::string& place) const {
    if (accessors[accessor].dropped)
        fail_part(fault, place, fmt::format("accessors[{}] is left out", accessor));
}

void Document::report(Fault fault, const std::string& place, std::string detail) {
    ++reports;
    const FaultEntry& entry = entry_of(fault);
    if (detail.empty()) detail = entry.wrong;
    const bool is_note = entry.severity == Severity::noted;
    if (entry.severity == Severity::refused || (strict && !is_note)) fail(place, detail);
    const std::string text = fmt::format("{}: {}", detail, entry.done);
    if (!warnings.add(place + ": " + text) || is_note) return;
    if (++fault_count > max_faults) report(Fault::too_many_faults, place);
    if (faults.size() < Warnings::max_lines)
        faults.push_back({std::string(entry.key), printable(place), printable(text)});
}

void Document::warn(const std::string& place, const std::string& text) {
    ++reports;
    warnings.add(place + ": " + text);
}

const nlohmann::json& Document::list(const char* key) const {
    static const nlohmann::json empty = nlohmann::json::array();
    const auto found = json.find(key);
    return found == json.end() ? empty : *found;
}

void Document::charge(uint32_t accessor) {
    const GltfAccessor& a = accessors[accessor];
    const uint64_t values = a.count * a.components();
    const std::string place = fmt::format("accessors[{}]", accessor);
    if (a.buffer_view != none) return charge(place, values);
    if (values > budget.zeros) fail(place, "too many elements of accessors without data are read");
    budget.zeros -= values;
}

void Document::charge(const std::string& place, uint64_t values) {
    if (values > budget.values)
        fail(place,
             "the count of numbers read, repeated reads included, exceeds --max-accessor-values");
    budget.values -= values;
}

void Document::drop_nodes(uint32_t root) {
    const uint32_t parent = nodes[root].parent;
    std::vector<uint32_t> open{root};
    while (!open.empty()) {
        const uint32_t i = open.back();
        open.pop_back();
        const std::vector<uint32_t> children = std::move(nodes[i].children);
        open.insert(open.end(), children.begin(), children.end());
        nodes[i] = {};
        dropped_nodes.emplace_back(i, std::exchange(json["nodes"][i], nlohmann::json::object()));
    }
    nodes[root].parent = parent;
}

DocumentState Document::save() {
    dropped_nodes.clear();
    return *this;
}

void Document::restore(const DocumentState& state) {
    // Backwards: of a node that was dropped twice, the first entry has the file's JSON.
    for (; !dropped_nodes.empty(); dropped_nodes.pop_back())
        json["nodes"][dropped_nodes.back().first] = std::move(dropped_nodes.back().second);
    static_cast<DocumentState&>(*this) = state;
}

void Document::add_file(const std::string& name, std::span<const std::byte> bytes) {
    files.push_back({name, hash_bytes(bytes)});
    content_hash = hash_bytes(std::as_bytes(std::span(&files.back().hash, 1)), content_hash);
}

const nlohmann::json* find_extension(const nlohmann::json& object, const char* name) {
    const auto extensions = object.find("extensions");
    if (extensions == object.end() || !extensions->is_object()) return nullptr;
    const auto extension = extensions->find(name);
    return extension == extensions->end() ? nullptr : &*extension;
}

}  // namespace sightline
