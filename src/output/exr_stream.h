#pragma once
// How OpenEXR reaches the disk and the cores; for exr.cpp alone.
#include "core/error.h"

#include <ImfIO.h>
#include <ImfThreading.h>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

namespace sightline {

/// A file that remembers that a write failed: OpenEXR writes its last bytes in its destructors,
/// where it swallows every exception.
class Stream : public Imf::OStream {
  public:
    Stream(const std::string& temporary, const std::string& path)
        : OStream(path.c_str()), path_(path), file_(std::fopen(temporary.c_str(), "wb")) {
        if (!file_) fail();
    }
    ~Stream() override {
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

    /// Throws Error if any write failed, also one whose exception was swallowed.
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

/// OpenEXR's pool of threads while pictures are written. It is emptied again because a pool that
/// lives until the end of the process can hang there.
struct ThreadPool {
    explicit ThreadPool(unsigned threads) {
        Imf::setGlobalThreadCount(threads > 1 ? static_cast<int>(threads) : 0);
    }
    ~ThreadPool() { Imf::setGlobalThreadCount(0); }
    ThreadPool(const ThreadPool&) = delete;
};

}  // namespace sightline
