#include "batch/names.h"

#include "core/hash.h"
#include "core/text.h"
#include "output/output_folder.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <set>

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr size_t max_component_bytes = 255;  // on all common file systems

std::string without_slashes(std::string text) {
    std::ranges::replace(text, '/', '_');
    return text;
}

std::string expand(const std::string& field, const NameFields& fields) {
    const size_t colon = field.find(':');
    const std::string name = field.substr(0, colon);
    if (name == "frame") {
        size_t width = 0;
        const std::string digits = colon == std::string::npos ? "0" : field.substr(colon + 1);
        const auto [end, error] =
            std::from_chars(digits.data(), digits.data() + digits.size(), width);
        if (error == std::errc() && end == digits.data() + digits.size() && width <= 20)
            return fmt::format("{:0{}}", fields.frame, width);
    } else if (colon == std::string::npos) {
        if (name == "asset") return fields.asset;
        if (name == "stem") return fs::path(fields.asset).filename();
        if (name == "ext") return fields.extension;
        if (name == "view") return without_slashes(fields.view);
        if (name == "variant") return without_slashes(fields.variant);
    }
    throw NameError(fmt::format(
        "name template: unknown field {{{}}}; the fields are {{asset}}, {{stem}}, {{ext}}, "
        "{{view}}, {{frame}}, {{frame:04}} and {{variant}}, as in '{{stem}}_{{view}}'",
        field));
}

// Cuts a component to `most` bytes, at the end of a character.
std::string shortened(const std::string& component, size_t most) {
    const std::string hash = fmt::format("-{:08x}", hash_text(component) & 0xffffffff);
    std::string begin = component.substr(0, most - hash.size());
    for (int i = 0; i < 3 && is_utf8(component) && !is_utf8(begin); ++i) begin.pop_back();
    return begin + hash;
}

fs::path without_extension(const fs::path& path) { return path.parent_path() / path.stem(); }

// The deepest folder that holds all of the files; an absolute path.
fs::path common_folder(const std::set<std::string>& files) {
    fs::path common = fs::path(*files.begin()).parent_path();
    for (const std::string& file : files) {
        fs::path both;
        const fs::path folder = fs::path(file).parent_path();
        const auto end = std::mismatch(common.begin(), common.end(), folder.begin(), folder.end());
        for (auto part = common.begin(); part != end.first; ++part) both /= *part;
        common = both;
    }
    return common;
}

}  // namespace

std::string fill_in(const std::string& name_template, const NameFields& fields) {
    std::string result;
    for (size_t at = 0; at < name_template.size();) {
        const size_t open = name_template.find('{', at);
        result += name_template.substr(at, open - at);
        if (open == std::string::npos) break;
        const size_t close = name_template.find('}', open);
        if (close == std::string::npos)
            throw NameError(
                fmt::format("name template '{}': a {{ has no }}; fields are written as in "
                            "'{{stem}}_{{view}}'",
                            name_template));
        result += expand(name_template.substr(open + 1, close - open - 1), fields);
        at = close + 1;
    }
    return result;
}

bool has_field(const std::string& name_template, const std::string& field) {
    return name_template.find("{" + field + "}") != std::string::npos ||
           name_template.find("{" + field + ":") != std::string::npos;
}

std::string with_field(const std::string& name_template, const std::string& field) {
    std::string result = name_template;
    const size_t percent = result.find('%');
    const size_t letter = percent == std::string::npos
                              ? percent
                              : result.find_first_not_of("0123456789", percent + 1);
    if (letter != std::string::npos && result[letter] == 'd')
        return result.replace(percent, letter + 1 - percent, field);
    const size_t ending = fs::path(result).extension().native().size();
    return result.insert(result.size() - ending, "_" + field);
}

std::string output_name(const std::string& name, const std::string& format) {
    const auto refuse = [&](const char* why) {
        throw NameError(fmt::format("the name of a picture would be '{}', which {}", name, why));
    };
    if (name.find('\0') != std::string::npos) refuse("contains a zero byte");
    const fs::path path = fs::path(name).lexically_normal();
    if (name.empty() || path.is_absolute() || *path.begin() == "..")
        refuse("is not below the output folder; a name such as 'front/{stem}' is");
    if (path.filename().empty() || path.filename() == ".")
        refuse("is a folder; name the picture in it, such as with '{asset}/{view}'");
    if (*path.begin() == private_folder) refuse("is reserved for the batch's own files");
    fs::path result;
    for (auto part = path.begin(); part != path.end(); ++part) {
        const bool is_last = std::next(part) == path.end();
        const size_t most = max_component_bytes - (is_last ? format.size() + 1 : 0);
        result /= part->native().size() > most ? fs::path(shortened(*part, most)) : *part;
    }
    return result;
}

std::vector<std::string> mirrored_names(const std::vector<NamedAsset>& assets,
                                        const KnownNames& known) {
    std::map<std::string, std::set<std::string>> by_name;
    for (const NamedAsset& a : assets) by_name[a.name].insert(a.asset);
    for (const auto& [asset, names] : known)
        for (const std::string& name : names)
            if (const auto group = by_name.find(name); group != by_name.end())
                group->second.insert(asset);
    std::map<std::string, fs::path> folders;
    for (const auto& [name, files] : by_name) folders[name] = common_folder(files);
    std::vector<std::string> result;
    for (const auto& [asset, name] : assets) {
        const std::string mirrored =
            without_extension(fs::path(asset).lexically_relative(folders[name]));
        result.push_back(mirrored.size() > name.size() ? mirrored : name);
    }
    return result;
}

}  // namespace sightline
