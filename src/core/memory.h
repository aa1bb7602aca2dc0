#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline {

/// The largest resident set of this process since its start or the last reset, in bytes.
uint64_t peak_memory();

/// Gives free memory back to the system and begins a new peak, where the system can.
void reset_peak_memory();

/// Reserves memory for `count` elements in an empty vector, in pages of 2 MiB if the system has
/// them: with small pages, random reads mostly wait for address translation.
template <class T>
void reserve_in_large_pages(std::vector<T>& vector, size_t count) {
    constexpr uintptr_t page = uintptr_t{2} << 20;
    vector.reserve(count);
    auto* const begin = reinterpret_cast<std::byte*>(vector.data());
    const size_t unaligned = (page - reinterpret_cast<uintptr_t>(begin) % page) % page;
    const size_t size = count * sizeof(T);
    if (size >= unaligned + page)
        madvise(begin + unaligned, (size - unaligned) / page * page, MADV_HUGEPAGE);
}

}  // namespace sightline
