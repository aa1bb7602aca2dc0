#include "scene/gltf/uri.h"

#include "core/beneath.h"
#include "core/error.h"
#include "core/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <optional>

namespace sightline {
namespace {

namespace fs = std::filesystem;

int hex_digit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

// Decodes "%20" to " ". Empty if a % is not followed by two hexadecimal digits.
std::optional<std::string> percent_decode(std::string_view text) {
    std::string decoded;
    for (size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '%') {
            decoded += text[i];
            continue;
        }
        if (text.size() - i < 3) return {};
        const int high = hex_digit(text[i + 1]), low = hex_digit(text[i + 2]);
        if (high < 0 || low < 0) return {};
        decoded += static_cast<char>(high * 16 + low);
        i += 2;
    }
    return decoded;
}

std::optional<FileBytes> decode_base64(std::string_view text) {
    static constexpr auto values = [] {
        std::array<int, 256> table{};
        table.fill(-1);
        constexpr std::string_view digits =
            "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        for (size_t i = 0; i < digits.size(); ++i)
            table[static_cast<uint8_t>(digits[i])] = static_cast<int>(i);
        return table;
    }();
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    if (text.size() % 4 == 1) return {};
    FileBytes bytes;
    bytes.reserve(text.size() / 4 * 3 + 2);
    uint32_t bits = 0;
    int count = 0;
    for (const char c : text) {
        const int value = values[static_cast<uint8_t>(c)];
        if (value < 0) return {};
        bits = bits << 6 | static_cast<uint32_t>(value);
        count += 6;
        if (count >= 8) {
            count -= 8;
            bytes.push_back(static_cast<std::byte>(bits >> count & 0xff));
        }
    }
    return bytes;
}

// Whether a URI starts with "data:", in any case.
bool is_data_uri(std::string_view uri) {
    constexpr std::string_view scheme = "data:";
    return uri.size() >= scheme.size() &&
           std::equal(scheme.begin(), scheme.end(), uri.begin(),
                      [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b + 32 : b); });
}

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\f' || c == '\r'; }

std::string without_blanks(std::string_view text) {
    std::string result;
    std::ranges::copy_if(text, std::back_inserter(result), [](char c) { return !is_blank(c); });
    return result;
}

// Whether a data URI's media type ends with ";base64", as browsers read it: in any case, and with
// blanks.
bool says_base64(std::string_view type) {
    constexpr std::string_view mark = ";base64";
    const std::string word = without_blanks(type);
    return word.size() >= mark.size() &&
           std::equal(mark.rbegin(), mark.rend(), word.rbegin(),
                      [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b + 32 : b); });
}

// The bytes encoded in a data URI; empty if it is malformed. Base64 is decoded as browsers do,
// blanks and capitals included, with a report.
std::optional<FileBytes> decode_data_uri(Document& document, std::string_view uri,
                                         const std::string& place) {
    const size_t comma = uri.find(',');
    if (comma == std::string_view::npos) return {};
    const std::string_view type = uri.substr(0, comma), data = uri.substr(comma + 1);
    std::string storage;
    std::string_view text = data;
    if (data.find('%') != std::string_view::npos) {
        auto decoded = percent_decode(data);
        if (!decoded) return {};
        storage = std::move(*decoded);
        text = storage;
    }
    if (!says_base64(type)) {
        const auto bytes = std::as_bytes(std::span(text));
        return FileBytes(bytes.begin(), bytes.end());
    }
    const bool has_blanks = std::ranges::any_of(text, is_blank);
    if (has_blanks || !type.ends_with(";base64")) document.report(Fault::data_uri_form, place);
    return decode_base64(has_blanks ? without_blanks(text) : text);
}

bool has_scheme(const std::string& uri) {
    const size_t end = uri.find_first_of(":/?#");
    return end != std::string::npos && end > 0 && uri[end] == ':';
}

fs::path folder_of(const Document& document) {
    const fs::path file(document.path);
    return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

// Reads the file that a URI names, or says in `problem` why it cannot.
std::optional<FileBytes> read_named_file(Document& document, const std::string& uri,
                                         const std::string& place, const LoadOptions& options,
                                         std::string& problem) {
    const auto fail = [&](const std::string& reason) {
        problem = "'" + uri + "' " + reason;
        return std::nullopt;
    };
    if (has_scheme(uri)) return fail("is not a relative path");
    if (!document.has_folder)
        throw Error(
            fmt::format("{}: {}: '{}' names another file, which standard input cannot have "
                        "beside it; give the asset as one .glb, or its path",
                        document.path, place, uri));
    const auto decoded = percent_decode(uri);
    if (!decoded || decoded->empty() || decoded->find('\0') != std::string::npos)
        return fail("is not a valid URI");
    const fs::path folder = folder_of(document);
    const std::string path = folder / *decoded;
    const int fd = options.allow_outside ? open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)
                                         : open_beneath(folder, *decoded);
    if (fd < 0 && errno == EXDEV) return fail("is outside the file's folder (see --allow-outside)");
    if (fd < 0 && (errno == ENOENT || errno == ENOTDIR)) {
        document.files.push_back({path, SourceFile::missing});
        return fail("is not an existing file");
    }
    if (fd < 0) return fail(std::string("cannot be opened: ") + std::strerror(errno));
    struct stat status {};
    if (fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) {
        close(fd);
        return fail("is not an existing file");
    }
    try {
        FileBytes bytes = read_open_file(fd, path, options.max_file_bytes);
        document.add_file(path, bytes);
        return bytes;
    } catch (const LimitError& error) {
        throw LimitError(document.path + ": " + error.what());
    } catch (const Error& error) {
        return fail(std::string("cannot be read: ") + error.what());
    }
}

}  // namespace

std::optional<FileBytes> read_uri(Document& document, const std::string& uri,
                                  const std::string& place, const LoadOptions& options,
                                  std::string& problem) {
    if (!is_data_uri(uri)) return read_named_file(document, uri, place, options, problem);
    auto decoded = decode_data_uri(document, uri, place);
    if (!decoded) problem = "is a malformed data URI";
    return decoded;
}

std::vector<std::string> named_files(const Document& document) {
    std::vector<std::string> paths;
    for (const char* list : {"buffers", "images"}) {
        for (const nlohmann::json& item : document.list(list)) {
            const std::string uri = item.value("uri", "");
            const auto name = is_data_uri(uri) ? std::nullopt : percent_decode(uri);
            if (name && !name->empty()) paths.push_back((folder_of(document) / *name).string());
        }
    }
    return paths;
}

}  // namespace sightline
