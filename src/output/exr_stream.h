#pragma once
// OpenEXR's access to the disk and to threads; for exr.cpp only.
#include "core/error.h"

#include <ImfIO.h>
#include <ImfThreading.h>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <string>
#include <utility>

namespace sightline {

/// A file that remembers that a write failed: OpenEXR writes its last bytes in its destructors,
/// which swallow every exception.
class ExrOStream : public Imf::OStream {
  public:
    ExrOStream(const std::string& temporary, const std::string& path)
        : OStream(path.c_str()), path_(path), file_(std::fopen(temporary.c_str(), "wb")) {
        if (!file_) fail();
    }
    ~ExrOStream() override {
        if (file_) std::fclose(file_);
    }

    void write(const char bytes[], int count) override {
        const auto size = static_cast<size_t>(count);
        if (std::fwrite(bytes, 1, size, file_) != size) fail();
        position_ += size;
    }
    uint64_t tellp() override { return position_; }
    void seekp(uint64_t position) override {
        if (fseeko(file_, static_cast<off_t>(position), SEEK_SET) != 0) fail();
        position_ = position;
    }

    /// Throws Error if any write failed, even if its exception was swallowed.
    void finish() {
        const int closed = std::fclose(std::exchange(file_, nullptr));
        if (error_ == 0 && closed != 0) error_ = errno;
        if (error_ != 0) throw Error(message());
    }

  private:
    [[noreturn]] void fail() {
        if (error_ == 0) error_ = errno;
        throw Error(message());
    }
    std::string message() const {
        return fmt::format("{}: cannot write: {}", path_, std::strerror(error_));
    }

    std::string path_;
    std::FILE* file_;
    uint64_t position_ = 0;
    int error_ = 0;
};

/// Gives OpenEXR its threads while pictures are written: those that the first of them asked for.
/// They end with the last, because a pool that lives until the end of the process can hang there.
class ScopedExrThreads {
  public:
    explicit ScopedExrThreads(unsigned threads) {
        const std::lock_guard lock(mutex_);
        if (users_++ == 0) Imf::setGlobalThreadCount(threads > 1 ? static_cast<int>(threads) : 0);
    }
    ~ScopedExrThreads() {
        const std::lock_guard lock(mutex_);
        if (--users_ == 0) Imf::setGlobalThreadCount(0);
    }
    ScopedExrThreads(const ScopedExrThreads&) = delete;

  private:
    static inline std::mutex mutex_;
    static inline int users_ = 0;
};

}  // namespace sightline
