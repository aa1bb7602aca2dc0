#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline {

/// Takes memory for `count` elements in an empty vector, in pages of 2 MiB where the system has
/// them: what is read at random from small ones mostly waits for their addresses.
template <class T>
void reserve_in_large_pages(std::vector<T>& vector, size_t count) {
    constexpr uintptr_t page = uintptr_t{2} << 20;
    vector.reserve(count);
    const auto begin = (reinterpret_cast<uintptr_t>(vector.data()) + page - 1) / page * page;
    const auto end = reinterpret_cast<uintptr_t>(vector.data() + count) / page * page;
    if (end > begin) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

}  // namespace sightline
