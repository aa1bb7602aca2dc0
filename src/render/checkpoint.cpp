#include "render/checkpoint.h"

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <span>
#include <type_traits>
#include <utility>

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr auto sync_interval = std::chrono::seconds(2);
constexpr const char* checkpoint_extension = ".tiles";

struct FileHeader {
    std::array<char, 8> magic{'S', 'L', 'T', 'I', 'L', 'E', 'S', '1'};
    uint64_t key = 0;
    uint64_t record_size = 0;
    bool operator==(const FileHeader&) const = default;
};

// A record: this, the values of all channels one after the other, and a hash of both.
struct RecordHeader {
    int32_t x = 0, y = 0;
    Counters counters;
};
static_assert(std::is_trivially_copyable_v<RecordHeader>);

size_t record_size(const Film& tile) {
    size_t values = 0;
    for (const Channel& c : tile.channels) values += c.values.size() + c.integers.size();
    return sizeof(RecordHeader) + values * sizeof(float) + sizeof(uint64_t);
}

template <class T>
void put(std::vector<std::byte>& record, std::span<const T> values) {
    const auto bytes = std::as_bytes(values);
    record.insert(record.end(), bytes.begin(), bytes.end());
}

template <class T>
void take(std::span<const std::byte>& rest, std::span<T> values) {
    if (values.empty()) return;
    std::memcpy(values.data(), rest.data(), values.size_bytes());
    rest = rest.subspan(values.size_bytes());
}

[[noreturn]] void fail(const std::string& path, const char* what) {
    throw Error(fmt::format("{}: {}: {}", path, what, std::strerror(errno)));
}

}  // namespace

struct Checkpoint::File {
    std::string path;
    int fd = -1;
    uint64_t record_size = 0;
    uint64_t size = 0;  // bytes that this process has appended

    ~File() {
        if (fd >= 0) close(fd);
    }
    bool read(std::span<std::byte> to, uint64_t offset) const {
        return pread(fd, to.data(), to.size(), static_cast<off_t>(offset)) == std::ssize(to);
    }
    // The next append overwrites what a failed one has left.
    void append(std::span<const std::byte> bytes) {
        if (!write_all(fd, bytes, size)) fail(path, "cannot write");
        size += bytes.size();
    }
};

Checkpoint::Checkpoint(std::string folder, uint64_t key)
    : folder_(std::move(folder)), key_(key), synced_(std::chrono::steady_clock::now()) {
    std::error_code error;
    fs::create_directory(folder_, error);
    if (!fs::is_directory(folder_))
        throw Error(fmt::format("{}: cannot make this folder for finished tiles", folder_));
    for (const auto& entry : fs::directory_iterator(folder_)) add_file(entry.path());
}

Checkpoint::~Checkpoint() = default;

void Checkpoint::add_file(const std::string& path) {
    auto file = std::make_unique<File>();
    file->path = path;
    file->fd = open(path.c_str(), O_RDONLY | O_CLOEXEC);
    FileHeader header;
    struct stat status {};
    const FileHeader expected{.key = key_, .record_size = 0};
    if (file->fd < 0 || fstat(file->fd, &status) != 0 || !S_ISREG(status.st_mode)) return;
    const bool whole = file->read(std::as_writable_bytes(std::span(&header, 1)), 0);
    file->record_size = std::exchange(header.record_size, 0);
    if (!whole) return;
    if (header != expected || file->record_size < sizeof(RecordHeader)) {
        ++foreign_;
        return;
    }
    // Ignores an incomplete record at the end, which a killed process leaves.
    const auto size = static_cast<uint64_t>(status.st_size);
    for (uint64_t at = sizeof header; at + file->record_size <= size; at += file->record_size) {
        std::array<int32_t, 2> tile{};
        if (file->read(std::as_writable_bytes(std::span(tile)), at))
            records_[{tile[0], tile[1]}] = {file.get(), at};
    }
    files_.push_back(std::move(file));
}

bool Checkpoint::restore(Film& tile, Counters& counters) const {
    const auto found = records_.find({tile.window.x0, tile.window.y0});
    if (found == records_.end()) return false;
    const auto& [file, offset] = found->second;
    if (file->record_size != record_size(tile)) return false;
    std::vector<std::byte> record(file->record_size);
    if (!file->read(record, offset)) return false;
    std::span<const std::byte> rest(record);
    const uint64_t expected = hash_bytes(rest.first(rest.size() - sizeof(uint64_t)), key_);
    RecordHeader header;
    take(rest, std::span(&header, 1));
    std::span<const std::byte> end = rest.last(sizeof(uint64_t));
    uint64_t hash = 0;
    take(end, std::span(&hash, 1));
    if (hash != expected || header.x != tile.window.x0 || header.y != tile.window.y0) return false;
    for (Channel& c : tile.channels) {
        take(rest, std::span(c.values));
        take(rest, std::span(c.integers));
    }
    counters.add(header.counters);
    return true;
}

void Checkpoint::keep(const Film& tile, const Counters& counters) {
    std::vector<std::byte> record;
    record.reserve(record_size(tile));
    const RecordHeader header{tile.window.x0, tile.window.y0, counters};
    put(record, std::span(&header, 1));
    for (const Channel& c : tile.channels) {
        put(record, std::span(c.values));
        put(record, std::span(c.integers));
    }
    const uint64_t hash = hash_bytes(record, key_);
    put(record, std::span(&hash, 1));

    std::unique_lock lock(appending_);
    if (!own_) {
        create_own();
        const FileHeader file{.key = key_, .record_size = record.size()};
        own_->append(std::as_bytes(std::span(&file, 1)));
    }
    own_->append(record);
    const auto now = std::chrono::steady_clock::now();
    if (now - synced_ < sync_interval) return;
    synced_ = now;
    lock.unlock();
    if (fdatasync(own_->fd) != 0) fail(own_->path, "cannot write");
}

void Checkpoint::create_own() {
    uint64_t random = 0;
    if (getrandom(&random, sizeof random, 0) != sizeof random) fail(folder_, "no random number");
    own_ = std::make_unique<File>();
    own_->path = fs::path(folder_) / fmt::format("{:016x}{}", random, checkpoint_extension);
    own_->fd = open(own_->path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (own_->fd < 0) fail(own_->path, "cannot write");
}

void Checkpoint::sync() {
    const std::lock_guard lock(appending_);
    if (!own_) return;
    if (fsync(own_->fd) != 0) fail(own_->path, "cannot write");
    const int directory = open(folder_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (directory >= 0) {
        fsync(directory);
        close(directory);
    }
}

void Checkpoint::remove() {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_, ignored))
        if (entry.path().extension() == checkpoint_extension) fs::remove(entry.path(), ignored);
    fs::remove(folder_, ignored);  // fails if someone keeps other files in it
}

}  // namespace sightline
