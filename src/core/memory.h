#pragma once
#include <sys/mman.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace sightline {

/// The largest resident set of this process since its start or the last reset, in bytes.
uint64_t peak_memory();

/// Gives free memory back to the system and begins a new peak, where the system can.
void reset_peak_memory();

/// An allocator whose vectors leave elements that are given no value uninitialised: what is to be
/// filled at once need not be cleared first.
template <class T>
struct UninitializedAllocator : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = UninitializedAllocator<U>;
    };

    template <class U>
    void construct(U* at) {
        ::new (static_cast<void*>(at)) U;
    }
    template <class U, class... Values>
    void construct(U* at, Values&&... values) {
        ::new (static_cast<void*>(at)) U(std::forward<Values>(values)...);
    }
};

/// Reserves memory for `count` elements in an empty vector, in pages of 2 MiB if the system has
/// them: small pages cost time where they are touched first, and random reads mostly wait for
/// address translation.
template <class T, class Allocator>
void reserve_in_large_pages(std::vector<T, Allocator>& vector, size_t count) {
    constexpr uintptr_t page = uintptr_t{2} << 20;
    vector.reserve(count);
    auto* const begin = reinterpret_cast<std::byte*>(vector.data());
    const size_t unaligned = (page - reinterpret_cast<uintptr_t>(begin) % page) % page;
    const size_t size = count * sizeof(T);
    if (size >= unaligned + page)
        madvise(begin + unaligned, (size - unaligned) / page * page, MADV_HUGEPAGE);
}

}  // namespace sightline
